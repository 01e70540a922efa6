#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| srp_tests::fuzz::compile::any(data));
