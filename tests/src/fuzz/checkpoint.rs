//! Any bytes are the state of a program on the way, from which it goes on or traps; or they are refused. What stands before
//! the state in a checkpoint, its digest among it, is not of these bytes.

use super::schedule::{TINY, run};
use crate::{LITTLE, compiled, root, session};
use srp_archdesc::Unwatched;
use srp_csimgen::{Interpreter, SimSpec, link};
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Finish, Solo};
use srp_toolchain::checkpoint::ProgramState;
use srp_toolchain::schedule;
use std::sync::LazyLock;

/// A program with loops on the array.
static PROGRAM: LazyLock<SimSpec> = LazyLock::new(|| {
    let source = root().join("tests/cases/kernels_auto.c");
    let program = compiled(&[source], &TINY).expect("it is a case");
    let scheduled = schedule(program, &TINY, LITTLE, &session()).expect("it fits");
    link(&scheduled.schedule.program).expect("it has few stages")
});

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let Ok(state) = postcard::from_bytes::<ProgramState>(data) else {
        return;
    };
    let (engine, mut solo, mut finish) = state.parts();
    let mut core = Interpreter::new(&PROGRAM);
    if core.restore(&engine) {
        run(&mut core, &mut solo, &mut finish);
    }
}

/// A state that is right: that of the program after so many cycles.
///
/// # Panics
///
/// If the program does not last so long.
pub fn seed(cycles: u64) -> Vec<u8> {
    let mut core = Interpreter::new(&PROGRAM);
    let mut solo = Solo::new(&PROGRAM.image, PROGRAM.sram_bytes);
    let mut finish = Finish::default();
    let ended = solo::run_until(&mut core, &mut solo, cycles, &Unwatched, &mut finish);
    ended.expect_err("it is not over yet");
    let engine = core.save().expect("it has not trapped");
    let state = ProgramState::new(engine, solo, finish);
    postcard::to_allocvec(&state).expect("it is plain data")
}
