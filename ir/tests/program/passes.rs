//! Passes keep what a program means, and do what their goldens say.

use crate::generate;
use srp_archdesc::arch::Precision;
use srp_ir::interp::{FlatWorld, Outcome, Trap};
use srp_ir::pass::{self, Remark};
use srp_ir::program::{Function, Program};
use srp_ir::text::write;
use srp_ir::verify;

/// A pass over a program, with what it has to tell.
type Pass = fn(&mut Program) -> Vec<Remark>;

const OPTIONS: pass::Options = pass::Options::new(Precision::EXACT);

/// Applies a pass to each function.
fn each(program: &mut Program, mut pass: impl FnMut(&mut Function)) -> Vec<Remark> {
    program.funcs.values_mut().for_each(&mut pass);
    Vec::new()
}

fn simplify_cfg(program: &mut Program) -> Vec<Remark> {
    let mut remarks = Vec::new();
    each(program, |f| _ = pass::simplify_cfg(f, &mut remarks));
    remarks
}

fn ifconvert(program: &mut Program) -> Vec<Remark> {
    let funcs = program.funcs.values_mut();
    funcs.flat_map(pass::ifconvert).collect()
}

pub(crate) const PASSES: &[(&str, Pass)] = &[
    ("cfg", simplify_cfg),
    ("copyprop", |p| each(p, |f| _ = pass::copyprop(f))),
    ("dce", |p| each(p, |f| _ = pass::dce(f))),
    ("fold", |p| {
        each(p, |f| _ = pass::fold(f, &OPTIONS.precision))
    }),
    ("gvn", |p| each(p, |f| _ = pass::gvn(f))),
    ("ifconvert", ifconvert),
    ("inline", pass::inline),
    ("licm", |p| each(p, |f| _ = pass::licm(f))),
    ("mem2reg", |p| each(p, |f| _ = pass::mem2reg(f))),
    ("strength", |p| each(p, |f| _ = pass::strength(f))),
    ("compact", |p| each(p, pass::compact)),
    ("optimise", |p| pass::optimise(p, &OPTIONS)),
];

/// A program and what it does.
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
        for (name, pass) in PASSES {
            let mut changed = case.program.clone();
            pass(&mut changed);
            case.check(&changed, name);
        }
        let mut changed = case.program.clone();
        for (name, pass) in PASSES.iter().chain(PASSES) {
            pass(&mut changed);
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
            each(&mut changed, |f| _ = pass::fold(f, &OPTIONS.precision));
            each(&mut changed, |f| _ = pass::gvn(f));
            case.check(&changed, "fold, gvn");
        }
    }
}
