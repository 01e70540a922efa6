//! Any text is a scheduled program that the checker accepts, which then runs or traps, the same on two engines; or it is
//! refused.

use srp_archdesc::arch::Arch;
use srp_archdesc::{Unwatched, machines};
use srp_csimgen::{Counting, Interpreter, link};
use srp_ir::check::check;
use srp_ir::dre;
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Finish, Solo};
use std::sync::LazyLock;

/// Cycles that a program gets.
const CYCLES: u64 = 20_000;

/// The machine of schedules.
pub(super) static TINY: LazyLock<Arch> =
    LazyLock::new(|| srp_archdesc::parse("tiny.xml", machines::TINY.xml).expect("it comes along"));

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
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
    let world = || Solo::new(&checked.image, arch.system.sram_bytes);
    let [(mut one, mut first), (mut two, mut second)] =
        [(world(), Finish::default()), (world(), Finish::default())];
    run(&mut Interpreter::new(&spec), &mut one, &mut first);
    run(&mut Counting::new(&spec), &mut two, &mut second);
    assert_eq!((first, one), (second, two));
}

/// Runs a program for its cycles, or to its end or trap.
pub(super) fn run(core: &mut dyn Core, bus: &mut Solo, finish: &mut Finish) {
    if let Err(error) = solo::run_until(core, bus, CYCLES, &Unwatched, finish) {
        error.to_string();
    }
}
