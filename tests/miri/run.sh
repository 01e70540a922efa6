#!/usr/bin/env bash
# Runs what is `unsafe` under Miri: a generated simulator with its host, and the tests of the interface between them.
# It takes a nightly compiler with the components miri and rust-src.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
cargo build --manifest-path "$root/Cargo.toml" --bin srp
rm -rf simulator/program.*
"$root/target/debug/srp" compile program.c --machine tiny --emit schedule,rust -o simulator

# The environment and the clock of the host may be read.
export MIRIFLAGS="-Zmiri-disable-isolation"
cargo +nightly miri run
cd "$root"
cargo +nightly miri test -p srp-csimgen --lib preamble::
