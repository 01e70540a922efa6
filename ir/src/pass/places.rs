//! Where expressions can be rewritten.

use super::pipeline::{Options, parse, run};
use super::rewrite::{Rewrite, fits};
use crate::program::Program;
use std::collections::BTreeSet;

/// The places of a program that some rule fits, in files that are not the library's: those that a wish for the
/// rule and the line rewrites. The program is as the front end gives it.
pub fn places(program: &Program, options: &Options) -> BTreeSet<Rewrite> {
    let mut program = program.clone();
    let mut found = BTreeSet::new();
    // Once before functions are in the place of their calls, and once after, as the pass runs.
    for passes in ["simplify", "inline,simplify"] {
        let passes = parse(passes).expect("the passes are in the table");
        run(&mut program, &passes, options, &mut |_, _| {});
        found.extend(fits(&program));
    }
    found
}
