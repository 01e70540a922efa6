//! Warnings about a machine that is right: attributes that have no effect beside others, and cycles in which no operator of
//! the technology does what is asked of it. An architect who changes one of these would look for an effect in vain, or believe
//! a wrong one.

mod array;
mod haste;
mod memory;
mod special;
mod tni;

use std::collections::BTreeSet;

use super::findings::Findings;
use super::raw::{self, Text};
use crate::arch::Arch;
use crate::cost::{self, FO4_PS};
use crate::diagnostic::Span;
use crate::isa::Class;

/// Warns of everything in a machine that is not as it seems.
pub(super) fn remarks(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
    let system = machine.system.as_ref().map(|system| &system.value);
    operations(found, machine, arch);
    unused_resources(found, machine, arch);
    array::remarks(found, machine, arch);
    special::remarks(found, machine, arch);
    if let Some(system) = system {
        memory::remarks(found, system, arch);
        tni::remarks(found, system, arch);
    }
    clocks(found, machine, at, arch);
    haste::remarks(found, machine, at, arch);
}

/// An attribute without an effect.
fn dead(found: &Findings, span: Span, what: &str, why: &str, help: &str) {
    let message = format!("{what} has no effect: {why}");
    let warning = found.warning("A0701", span, message, "changes nothing");
    found.push(warning.help(help));
}

/// The same where the file has the attribute.
fn dead_if_given(found: &Findings, text: &Option<Text>, name: &str, why: &str, help: &str) {
    if let Some(text) = text {
        dead(found, text.span, &format!("`{name}`"), why, help);
    }
}

fn operations(found: &Findings, machine: &raw::Machine, arch: &Arch) {
    for op in &machine.op {
        let Some(class) = op.class.as_ref().and_then(|text| Class::parse(text)) else {
            continue;
        };
        let runs = arch.srp.fus.values().any(|fu| fu.op(class).is_some());
        let slow = || {
            let mut branches = arch.srp.fus.values().filter_map(|fu| fu.op(class));
            branches.any(|how| how.given[0] && how.latency > 1)
        };
        let cycles = [&op.latency, &op.interval].into_iter().flatten().next();
        match cycles {
            Some(text) if !runs => dead(
                found,
                text.span,
                &format!("the timing of `<op class=\"{class}\">`"),
                &format!("no unit runs class `{class}`"),
                "add the class to a unit",
            ),
            Some(text) if class == Class::Branch && slow() => dead(
                found,
                text.span,
                "the latency of branches",
                "what a branch costs is the branch delay",
                "set `branch-delay` of `<vliw>`",
            ),
            _ => {}
        }
    }
}

fn unused_resources(found: &Findings, machine: &raw::Machine, arch: &Arch) {
    let ops = arch.srp.fus.values().flat_map(|fu| &fu.ops);
    let used: BTreeSet<_> = ops.flat_map(|how| &how.uses).collect();
    for (resource, spec) in arch.srp.resources.iter() {
        let at = machine.resource.iter().find(|raw| {
            let name = raw.name.as_ref().map(|text| text.value.as_str());
            name == Some(spec.name.as_str())
        });
        if let Some(raw) = at.filter(|_| !used.contains(&resource)) {
            dead(
                found,
                raw.span,
                &format!("resource `{}`", spec.name),
                "no operation of a unit uses it",
                "name it in `uses` of an `<op>`",
            );
        }
    }
}

/// Clocks at which registers leave no time for logic.
fn clocks(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
    let raw = machine.system.as_ref().map(|system| &system.value);
    let system = &arch.system;
    for (clock, text, at_65nm, mhz) in [
        (
            "srp-mhz",
            raw.and_then(|raw| raw.srp_mhz.as_ref()),
            system.srp_mhz_at_65nm(),
            system.srp_mhz,
        ),
        (
            "tni-mhz",
            raw.and_then(|raw| raw.tni_mhz.as_ref()),
            system.tni_mhz_at_65nm(),
            system.tni_mhz,
        ),
    ] {
        let whole = 1e6 / f64::from(at_65nm) / FO4_PS;
        if whole - cost::OVERHEAD >= cost::LEAST_FO4 {
            continue;
        }
        let message = format!(
            "a cycle of `{clock}` {mhz} is {whole:.1} delays of a gate of {} ps, of which registers, skew and jitter take {}",
            system.fo4_ps,
            cost::OVERHEAD
        );
        let span = text.map_or(at, |text| text.span);
        let warning = found.warning("A0703", span, message, "too quick for the technology");
        found.push(warning.help(
            "lower the clock, or give the `fo4-ps` of a quicker technology to `<system>`: 25 is 65 nm, 12 about 28 nm",
        ));
    }
}
