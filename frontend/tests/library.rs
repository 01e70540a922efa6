//! The C library where it does something else than the host's.

use srp_archdesc::arch::Precision;
use srp_archdesc::diagnostic::Source;
use srp_frontend::{Options, compile};
use srp_ir::interp::{self, End, FlatWorld};
use srp_ir::layout::Layout;
use srp_ir::{Program, pass, verify};

const SRAM_BYTES: u32 = 240 * 1024;

fn optimised(text: &str) -> Program {
    let source = Source::new("test.c", text);
    let (mut program, warnings) = compile(&[source], &Options::default()).expect("it compiles");
    assert!(warnings.is_empty(), "{warnings:?}");
    pass::optimise(&mut program, &pass::Options::new(Precision::EXACT));
    verify(&program).expect("the passes keep the rules");
    program
}

/// Runs a program: its output, and how it ends.
fn run(program: &Program) -> (String, End) {
    let layout = Layout::of(program, SRAM_BYTES).expect("it fits");
    let mut world = FlatWorld::new(&layout, SRAM_BYTES);
    let main = program.main.expect("there is a main");
    let options = interp::Options::new(&layout);
    let outcome = interp::run(program, main, &[], &mut world, &options).expect("it runs");
    let output = String::from_utf8_lossy(&world.output).into_owned();
    (output, outcome.end)
}

/// An assertion that fails says so, and ends the program as `abort` does.
#[test]
fn failed_assertions_are_told() {
    let text = "#include <assert.h>
        static void inner(int x) {\n assert(x < 3 && \"small\"); }
        int main(void) { for (int i = 0; i < 9; i++) inner(i); return 0; }";
    let program = optimised(text);
    let (output, end) = run(&program);
    assert_eq!(
        output,
        "test.c:3: inner: assertion `x < 3 && \"small\"' failed\n"
    );
    assert_eq!(end, End::Exited(134));
    // No `printf`, no heap.
    let layout = Layout::of(&program, SRAM_BYTES).expect("it fits");
    assert!(layout.image.len() < 256, "{} bytes", layout.image.len());
    assert!(program.funcs.len() <= 3, "{}", program.funcs.len());
}
