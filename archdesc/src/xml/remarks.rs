//! Warnings about a machine that is right: attributes that have no effect beside others, and cycles in which no operator of
//! the technology does what is asked of it. An architect who changes one of these would look for an effect in vain, or believe
//! a wrong one.

use std::collections::BTreeSet;

use super::de::Spanned;
use super::findings::Findings;
use super::raw::{self, Text};
use crate::arch::{Arch, FuOp};
use crate::chip;
use crate::cost::pipeline::MOST_HASTE;
use crate::cost::{self, FO4_PS};
use crate::diagnostic::Span;
use crate::dram::DramModel;
use crate::isa::Class;
use crate::system::NodeFormat;

/// Warns of everything in a machine that is not as it seems.
pub(super) fn remarks(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
    let system = machine.system.as_ref().map(|system| &system.value);
    operations(found, machine, arch);
    unused_resources(found, machine, arch);
    if let Some(system) = system {
        memories(found, system, arch);
        tni(found, system, arch);
    }
    clocks(found, machine, at, arch);
    haste(found, machine, at, arch);
}

/// An attribute without an effect.
fn dead(found: &Findings, span: Span, what: &str, why: &str, help: &str) {
    let message = format!("{what} has no effect: {why}");
    let warning = found.warning("A0701", span, message, "changes nothing");
    found.push(warning.help(help));
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

fn memories(found: &Findings, system: &raw::System, arch: &Arch) {
    let sram = system.sram.as_ref().map(|sram| &sram.value);
    if let (Some(sram), None) = (sram, arch.system.sram_banks) {
        for (name, text) in [("width", &sram.width), ("shared", &sram.shared)] {
            if let Some(text) = text {
                let what = format!("`{name}` of `<sram>`");
                let help = "give the SRAM `banks`";
                dead(found, text.span, &what, "it has no banks", help);
            }
        }
    }
    let timing = (system.dram.as_ref()).and_then(|dram| dram.value.timing.as_ref());
    let rfc = timing.and_then(|timing| timing.value.rfc.as_ref());
    if let (Some(rfc), DramModel::Banked(banked)) = (rfc, &arch.system.dram.model)
        && banked.timing.refi == 0
    {
        let why = "with `refi` 0 the memory is never refreshed";
        dead(found, rfc.span, "`rfc`", why, "give `refi`, or a preset");
    }
}

fn tni(found: &Findings, system: &raw::System, arch: &Arch) {
    let Some(Spanned { value: raw, .. }) = &system.tni else {
        return;
    };
    let tni = &arch.system.tni;
    let least = tni.node_format.bytes();
    let named = |text: &&Text| tni.node_format != NodeFormat::F32 && !text.value.is_empty();
    if let (Some(format), Some(bytes)) = (raw.node_format.as_ref().filter(named), &raw.node_bytes)
        && tni.node_bytes > least
    {
        let message = format!(
            "nodes of `{}` take {least} bytes, and `node-bytes` says {}",
            tni.node_format.name(),
            tni.node_bytes
        );
        let warning = found.warning("A0702", bytes.span, message, "keeps them as large");
        let also = warning.also(format.span, "the format");
        found.push(also.help("leave `node-bytes` out"));
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

/// Operators that would have to be quicker than a synthesis makes them.
fn haste(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
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
