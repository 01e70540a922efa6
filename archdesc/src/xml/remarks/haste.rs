//! Warnings of cycles in which no operator of the technology does its work.

use super::super::findings::Findings;
use super::super::raw;
use crate::arch::{Arch, FuOp};
use crate::chip;
use crate::cost::pipeline::MOST_HASTE;
use crate::diagnostic::Span;
use crate::isa::Class;

/// Operators that would have to be quicker than a synthesis makes them.
pub(super) fn remarks(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
    let hasty = |how: &&FuOp| how.given[0] && chip::haste(how, arch) > MOST_HASTE;
    let ops = arch.srp.fus.values().flat_map(|fu| &fu.ops);
    let mut hasty: Vec<&FuOp> = ops.filter(hasty).collect();
    hasty.sort_by_key(|how| (how.class, how.latency));
    hasty.dedup_by_key(|how| how.class);
    for how in hasty {
        let raw = machine.op.iter().find(|op| {
            let class = op.class.as_ref().and_then(|text| Class::parse(text));
            class == Some(how.class)
        });
        let text = raw.and_then(|op| op.latency.as_ref());
        let message = format!(
            "an operation of class `{}` passes {:.1} times as much logic as fits in its {} at {} MHz",
            how.class,
            chip::haste(how, arch),
            match how.latency {
                1 => "cycle".to_owned(),
                n => format!("{n} cycles"),
            },
            arch.system.srp_mhz
        );
        let span = text.map_or(at, |text| text.span);
        let warning = found.warning("A0704", span, message, "quicker than the technology");
        found.push(warning.help("leave `latency` out: it then follows from the clock"));
    }
}
