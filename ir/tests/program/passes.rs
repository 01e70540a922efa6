//! Passes keep the semantics of a program, and produce their goldens.

use crate::generate;
use srp_archdesc::arch::Precision;
use srp_ir::interp::{FlatWorld, Outcome, Trap};
use srp_ir::pass::{self, Remark};
use srp_ir::program::Program;
use srp_ir::text::write;
use srp_ir::verify;

/// Everything but permissions to change results.
fn options() -> pass::Options {
    pass::Options {
        prefetch: Some(64),
        ..pass::Options::new(Precision::EXACT)
    }
}

/// Runs the passes of a list.
pub(crate) fn run(program: &mut Program, list: &str) -> Result<Vec<Remark>, String> {
    let passes = pass::parse(list).map_err(|name| format!("no pass is called {name}"))?;
    Ok(pass::run(program, &passes, &options(), &mut |_, _| {}))
}

/// The names of all passes, and the one of all of them together.
fn names() -> impl Iterator<Item = &'static str> + Clone {
    let all = pass::PASSES.iter().map(|pass| pass.name);
    all.chain(["standard"])
}

/// A program and its behaviour.
pub(crate) struct Case {
    seed: u64,
    program: Program,
    expected: (Result<Outcome, Trap>, FlatWorld),
}

impl Case {
    pub(crate) fn new(seed: u64, program: Program) -> Case {
        let expected = generate::run(&program);
        Case {
            seed,
            program,
            expected,
        }
    }

    /// Checks that a changed program is valid and does the same.
    pub(crate) fn check(&self, changed: &Program, pass: &str) {
        let fail = |what: &str| {
            let (seed, before, after) = (self.seed, write(&self.program), write(changed));
            panic!("seed {seed}, {pass}: {what}\n{before}\nbecame\n{after}");
        };
        if let Err(found) = verify(changed) {
            let list: Vec<String> = found.iter().map(|v| v.to_string()).collect();
            fail(&list.join("\n"));
        }
        let (outcome, world) = generate::run(changed);
        match (&self.expected.0, outcome) {
            (Ok(a), Ok(b)) if a.end == b.end => {}
            (a, b) => fail(&format!("{a:?} before, {b:?} after")),
        }
        if world.outputs != self.expected.1.outputs {
            fail("ports differ");
        }
        if world != self.expected.1 {
            fail("memory differs");
        }
    }
}

/// Each pass alone, and then all of them one after the other, twice.
#[test]
fn passes_keep_the_meaning() {
    for seed in 1000..1100 {
        let case = Case::new(seed, generate::program(seed));
        for name in names() {
            let mut changed = case.program.clone();
            run(&mut changed, name).expect("it is a name");
            case.check(&changed, name);
        }
        let mut changed = case.program.clone();
        for name in names().chain(names()) {
            run(&mut changed, name).expect("it is a name");
            case.check(&changed, &format!("… {name}"));
        }
    }
}

/// The identities of the constant folder, on programs full of them.
#[test]
fn identities_hold() {
    for seed in 0..1500 {
        let case = Case::new(seed, generate::expressions(seed));
        let mut changed = case.program.clone();
        for _ in 0..3 {
            run(&mut changed, "fold, gvn").expect("they are names");
            case.check(&changed, "fold, gvn");
        }
    }
}
