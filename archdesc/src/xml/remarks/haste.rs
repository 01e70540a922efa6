//! Warnings of cycles in which no operator of the technology does its work.

use super::super::findings::Findings;
use super::super::raw::{self, Text};
use crate::arch::{Arch, FuOp};
use crate::chip;
use crate::cost::memory::access_fo4;
use crate::cost::pipeline::MOST_HASTE;
use crate::cost::usable_fo4;
use crate::diagnostic::Span;
use crate::haste::Haste;
use crate::isa::Class;

/// Warns of operators that would have to be quicker than a synthesis makes them, and of caches that cannot be read so quickly.
pub(super) fn remarks(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
    operations(found, machine, at, arch);
    if let Some(system) = &machine.system {
        stages(found, system, arch);
        tni_operators(found, system, arch);
        caches(found, system, arch);
    }
}

fn cycles(number: u32) -> String {
    match number {
        1 => "cycle".to_owned(),
        n => format!("{n} cycles"),
    }
}

/// Operators that would have to be quicker than a synthesis makes them.
fn operations(found: &Findings, machine: &raw::Machine, at: Span, arch: &Arch) {
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
            cycles(how.latency),
            arch.system.srp_mhz
        );
        let span = text.map_or(at, |text| text.span);
        let warning = found.warning("A0704", span, message, "quicker than the technology");
        found.push(warning.help("leave `latency` out: it then follows from the clock"));
    }
}

/// Stages of the T&I unit whose latencies are given.
fn stages(found: &Findings, system: &raw::System, arch: &Arch) {
    let Some(raw) = &system.tni else {
        return;
    };
    let tni = &arch.system.tni;
    let haste = Haste::of(tni, arch.system.tni_mhz_at_65nm());
    let given = &tni.given;
    for (what, text, haste, latency) in [
        (
            "a node's fetch",
            &raw.pre_latency,
            haste.pre,
            tni.pre_latency,
        ),
        (
            "a box test",
            &raw.aabb_latency,
            haste.aabb.add,
            tni.aabb_latency,
        ),
        (
            "a stack's access",
            &raw.post_latency,
            haste.post,
            tni.post_latency,
        ),
        (
            "a triangle test",
            &raw.ist_latency,
            haste.ist.add,
            tni.ist_latency,
        ),
    ]
    .into_iter()
    .zip([given.pre, given.aabb, given.post, given.ist])
    .filter_map(|(stage, is_given)| is_given.then_some(stage))
    {
        let Some(text) = text.as_ref().or(raw.latencies.as_ref()) else {
            continue;
        };
        hasty(found, text, what, haste, latency, arch);
    }
}

/// Operators of the T&I unit whose latencies are given.
fn tni_operators(found: &Findings, system: &raw::System, arch: &Arch) {
    let tni = &arch.system.tni;
    let raw = (system.tni.as_ref()).and_then(|tni| tni.fp.as_ref());
    let (Some(raw), Some(fp)) = (raw, tni.given.operators) else {
        return;
    };
    // Of a test whose latency is given, the operators' have no effect.
    let haste = Haste::of(tni, arch.system.tni_mhz_at_65nm());
    let of = match (tni.given.aabb, tni.given.ist) {
        (true, true) => return,
        (false, true) => haste.aabb,
        (_, false) => haste.ist,
    };
    for (what, text, haste, latency) in [
        ("a sum", &raw.add, of.add, fp.add),
        ("a product", &raw.mul, of.mul, fp.mul),
        ("a comparison", &raw.cmp, of.cmp, fp.cmp),
        ("a reciprocal", &raw.rcp, of.rcp, fp.rcp),
    ] {
        if let Some(text) = text {
            hasty(found, text, what, haste, latency, arch);
        }
    }
}

fn hasty(found: &Findings, text: &Text, what: &str, haste: f64, latency: u32, arch: &Arch) {
    if haste <= MOST_HASTE {
        return;
    }
    let message = format!(
        "{what} of the T&I unit passes {haste:.1} times as much logic as fits in its {} at {} MHz",
        cycles(latency),
        arch.system.tni_mhz
    );
    let warning = found.warning("A0704", text.span, message, "quicker than the technology");
    found.push(warning.help("leave it out: it then follows from `tni-mhz`"));
}

/// The part that arrays of the quickest cells take of the time of those that are priced: CACTI's of 16 to 128 KB, HP over LOP.
const QUICKEST_CELLS: f64 = 0.53;

/// Caches of the T&I unit that take longer than their latency, where latency or clock are given.
fn caches(found: &Findings, system: &raw::System, arch: &Arch) {
    let tni = &arch.system.tni;
    let raw = system.tni.as_ref().map(|tni| &tni.value);
    let cycle = usable_fo4(arch.system.tni_mhz_at_65nm());
    for (name, raw, cache) in [
        (
            "trv-l1",
            raw.and_then(|raw| raw.trv_l1.as_ref()),
            &tni.trv_l1,
        ),
        (
            "trv-l2",
            raw.and_then(|raw| raw.trv_l2.as_ref()),
            &tni.trv_l2,
        ),
        (
            "ist-l1",
            raw.and_then(|raw| raw.ist_l1.as_ref()),
            &tni.ist_l1,
        ),
    ] {
        let bits = 8.0 * f64::from(cache.bytes) / f64::from(cache.banks);
        let haste = QUICKEST_CELLS * access_fo4(bits) / (f64::from(cache.latency) * cycle);
        let text = raw.and_then(|raw| raw.latency.as_ref());
        let Some(text) = text
            .or(system.tni_mhz.as_ref())
            .filter(|_| haste > MOST_HASTE)
        else {
            continue;
        };
        let message = format!(
            "a look into `<{name}>` takes {haste:.1} times as long as its {} at {} MHz, even with the quickest cells",
            cycles(cache.latency),
            arch.system.tni_mhz
        );
        let warning = found.warning("A0704", text.span, message, "quicker than the technology");
        found.push(warning.help(format!(
            "give `<{name}>` a longer `latency`, or make it smaller"
        )));
    }
}
