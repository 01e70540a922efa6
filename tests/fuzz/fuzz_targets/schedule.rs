//! Any text is a scheduled program that the checker accepts, which then runs or traps; or it is refused.

#![no_main]

use libfuzzer_sys::fuzz_target;
use srp_archdesc::arch::Arch;
use srp_archdesc::{Unwatched, machines};
use srp_csimgen::{Interpreter, link};
use srp_ir::check::check;
use srp_ir::dre;
use srp_runtime::solo::{self, Finish, Solo};
use std::sync::LazyLock;

/// Cycles that a program gets.
const CYCLES: u64 = 20_000;

static TINY: LazyLock<Arch> =
    LazyLock::new(|| srp_archdesc::parse("tiny.xml", machines::TINY.xml).expect("it comes along"));

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    let arch = &*TINY;
    let Ok(scheduled) = dre::read_scheduled(&text, arch) else {
        return;
    };
    let Ok(checked) = check(scheduled, arch) else {
        return;
    };
    let Ok(spec) = link(&checked) else {
        return;
    };
    let mut core = Interpreter::new(&spec);
    let mut bus = Solo::new(&checked.image, arch.system.sram_bytes);
    let mut finish = Finish::default();
    let ended = solo::run_until(&mut core, &mut bus, CYCLES, &Unwatched, &mut finish);
    if let Err(error) = ended {
        error.to_string();
    }
});
