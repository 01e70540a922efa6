//! Warnings about memories.

use super::super::findings::Findings;
use super::super::limits;
use super::super::raw;
use super::{dead, dead_if_given};
use crate::arch::Arch;
use crate::dram::{BankedSpec, DramModel};

/// Warns of what a memory leaves without effect.
pub(super) fn remarks(found: &Findings, system: &raw::System, arch: &Arch) {
    sram(found, system, arch);
    buffers(found, system, arch);
    let Some(raw) = &system.dram else {
        return;
    };
    if arch.system.cores == 1 && !arch.system.dram.shared {
        let why = "the only core has memory and bus for itself";
        dead_if_given(
            found,
            &raw.shared,
            "shared",
            why,
            "give the system more `cores`",
        );
    }
    if let DramModel::Banked(banked) = &arch.system.dram.model {
        if let Some(timing) = &raw.timing {
            refresh(found, timing, banked);
            timings(found, timing, banked);
        }
        if let Some(controller) = &raw.controller {
            write_drain(found, controller, banked);
        }
    }
}

fn sram(found: &Findings, system: &raw::System, arch: &Arch) {
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
}

/// Buffers that the frame's program leaves empty: a packet that is traced takes one of each kind, and one more ray buffer is
/// filled meanwhile.
fn buffers(found: &Findings, system: &raw::System, arch: &Arch) {
    let Some(raw) = &system.buffers else {
        return;
    };
    let spec = &arch.system.buffers;
    let (rays, hits) = (spec.ray_buffers, spec.hit_buffers);
    let packets = hits.min(rays - 1);
    let (text, name, number, used) = match rays - 1 > hits {
        true => (&raw.ray_buffers, "ray-buffers", rays, packets + 1),
        false => (&raw.hit_buffers, "hit-buffers", hits, packets),
    };
    if let Some(text) = text.as_ref().filter(|_| number > used) {
        let message = format!(
            "of {number} `{name}` the shipped frame uses {used}: each packet that is traced takes a ray buffer and a hit \
             buffer, and one ray buffer more is filled meanwhile"
        );
        let warning = found.warning("A0701", text.span, message, "stay empty");
        let hit = hits.max(rays - 1).min(limits::RAY_BUFFERS.max - 1);
        let ray = hit + 1;
        found.push(warning.help(format!(
            "have `ray-buffers=\"{ray}\" hit-buffers=\"{hit}\"`, if no program of your own takes them"
        )));
    }
}

/// A refresh that never comes. Times of 0 ask for nothing.
fn refresh(found: &Findings, raw: &raw::DramTiming, spec: &BankedSpec) {
    if spec.timing.refi == 0 && spec.timing.rfc > 0 {
        let why = "with `refi` 0 the memory is never refreshed";
        dead_if_given(found, &raw.rfc, "rfc", why, "give `refi`, or a preset");
    }
}

/// Times that others cover.
fn timings(found: &Findings, raw: &raw::DramTiming, spec: &BankedSpec) {
    let t = &spec.timing;
    if (1..t.ras + t.rp).contains(&t.rc) {
        let why = format!(
            "`ras` and `rp` lie between two activations of a bank, {} cycles",
            t.ras + t.rp
        );
        let help = "make it longer, or `ras` and `rp` shorter";
        dead_if_given(found, &raw.rc, "rc", &why, help);
    }
    let burst = spec.burst.div_ceil(2);
    if (1..burst).contains(&t.ccd) {
        let why = format!("a burst of {} columns takes {burst} cycles", spec.burst);
        let help = "make it longer, or `burst` smaller";
        dead_if_given(found, &raw.ccd, "ccd", &why, help);
    }
    if (1..=4 * t.rrd).contains(&t.faw) {
        let why = format!(
            "four times `rrd` lie between an activation and the fourth after it, {} cycles",
            4 * t.rrd
        );
        let help = "make it longer, or `rrd` shorter";
        dead_if_given(found, &raw.faw, "faw", &why, help);
    }
}

/// Writes that never wait for so many, for their queue is full before.
fn write_drain(found: &Findings, raw: &raw::Controller, spec: &BankedSpec) {
    let controller = &spec.controller;
    if controller.write_drain >= controller.write_queue {
        let why = format!(
            "the queue of writes is full at {}, and drained then",
            controller.write_queue
        );
        let help = "make it less than `write-queue`";
        dead_if_given(found, &raw.write_drain, "write-drain", &why, help);
    }
}
