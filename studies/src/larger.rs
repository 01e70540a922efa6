//! Arrays with a row or a column more, which a machine's file describes by itself: its rows repeat, and so do the units of
//! a row.

use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::xml::{self, Change};
use srp_archdesc::{Watch, threads};
use srp_ir::dfg::Dfg;
use srp_scheduler::modulo::Options;
use srp_scheduler::what_if;

/// A larger array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Larger {
    /// The change in words.
    pub(crate) what: &'static str,
    /// The setting of the machine's file that makes it, `PATH=VALUE`.
    pub(crate) setting: String,
    pub(crate) srp: Srp,
}

/// The larger arrays of a machine with this text: those of which the file with one attribute changed is a machine.
pub(crate) fn of(arch: &Arch, text: &str) -> Vec<Larger> {
    let sides = [
        ("one more row of units", "rows", arch.srp.rows),
        ("one more column of units", "cols", arch.srp.cols),
    ];
    let larger = |(what, side, now): (&'static str, &str, u32)| {
        let setting = format!("array.{side}={}", now + 1);
        let changed = setting.parse::<Change>().ok()?.make(text).ok()?;
        let srp = xml::parse("", &changed).ok()?.srp;
        Some(Larger { what, setting, srp })
    };
    sides.into_iter().filter_map(larger).collect()
}

/// The arrays on which a loop's II is below `ii`, by their numbers, with the II that it has there.
pub(crate) fn lower(
    larger: &[Larger],
    dfg: &Dfg,
    ii: u32,
    options: &Options,
    (number, watch): (usize, &dyn Watch),
) -> Vec<(usize, u32)> {
    let none_is_lower = ii <= 1;
    let arrays = if none_is_lower { &[] } else { larger };
    let try_one = |(): &mut (), i: usize| {
        let reached = what_if::lower(dfg, &arrays[i].srp, ii, options, watch)?;
        Some((i, reached))
    };
    let found = threads::each(number, arrays.len(), || (), try_one);
    found.into_iter().flatten().collect()
}
