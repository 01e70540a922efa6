//! Warnings about the T&I unit.

use super::super::findings::Findings;
use super::super::raw::{self, Text};
use super::dead_if_given;
use crate::arch::Arch;
use crate::system::{NodeFormat, TniSpec};

/// Warns of what the T&I unit cannot use.
pub(super) fn remarks(found: &Findings, system: &raw::System, arch: &Arch) {
    if let Some(raw) = &system.tni {
        let tni = &arch.system.tni;
        node_bytes(found, raw, tni);
        stacks(found, raw, tni);
        rows(found, raw, tni);
        if tni.rau_rows == 0 {
            let why =
                "with `rau-rows` 0 there is no accumulation unit, and a ray that misses stands";
            let help = "give `rau-rows`, or leave it out";
            dead_if_given(found, &raw.rau_rays, "rau-rays", why, help);
        }
    }
}

/// Stacks that no ray ever takes.
fn stacks(found: &Findings, raw: &raw::Tni, tni: &TniSpec) {
    let most = tni.most_in_flight();
    if let Some(text) = raw.stacks.as_ref().filter(|_| tni.stacks > most) {
        let message = format!(
            "of {} `stacks` {} have no effect: a traversal unit lets in {most} rays, no more than its pipelines and FIFOs hold \
             without standing still",
            tni.stacks,
            tni.stacks - most
        );
        let warning = found.warning("A0701", text.span, message, "take area and stay empty");
        found.push(warning.help(format!(
            "have `stacks=\"{most}\"`, or a longer `fifo` and more sub-pipelines"
        )));
    }
}

/// Rows of accumulation units that no ray ever opens: each waits for a line, and the cache before it asks for no more of them
/// than it may have misses. A row whose line has come gives up all its rays before another is opened.
fn rows(found: &Findings, raw: &raw::Tni, tni: &TniSpec) {
    let most = tni.trv_l1.misses.max(tni.ist_l1.misses);
    if let Some(text) = raw.rau_rows.as_ref().filter(|_| tni.rau_rows > most) {
        let message = format!(
            "of {} `rau-rows` {} have no effect: a row waits for a line, and at most {most} lines are asked for at a time",
            tni.rau_rows,
            tni.rau_rows - most
        );
        let warning = found.warning("A0701", text.span, message, "take area and stay empty");
        found.push(warning.help(format!(
            "have `rau-rows=\"{most}\"`, or more `misses` of `<trv-l1>` and `<ist-l1>`"
        )));
    }
}

/// Nodes that are stored in more bytes than their format has.
fn node_bytes(found: &Findings, raw: &raw::Tni, tni: &TniSpec) {
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
