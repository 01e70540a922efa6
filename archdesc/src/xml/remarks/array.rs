//! Warnings about links and wires of the array.

use super::super::findings::Findings;
use super::super::raw::{self, Text};
use super::dead_if_given;
use crate::arch::{Arch, Input, Srp};

/// Warns of attributes of links and wires that the array does not have.
pub(super) fn remarks(found: &Findings, machine: &raw::Machine, arch: &Arch) {
    let Some(raw) = &machine.array else {
        return;
    };
    let srp = &arch.srp;
    // Beside those with an element of their own.
    if srp.links.len() == raw.link.len() {
        let why = "the topology has no links";
        let help = "have another `topology`; a `<link>` has attributes of its own";
        dead_if_given(found, some(&raw.link_delay), "link-delay", why, help);
        dead_if_given(found, &raw.link_width, "link-width", why, help);
    }
    let why = match srp.wires.is_empty() {
        true => "the array has no wires",
        false => "all wires of the array have elements of their own",
    };
    let help = "give the array `wires`; a `<wire>` has attributes of its own";
    if srp.wires.len() == raw.wire.len() {
        dead_if_given(found, some(&raw.wire_delay), "wire-delay", why, help);
        if raw.wire.iter().all(|wire| wire.width.is_some()) {
            dead_if_given(found, &raw.wire_width, "wire-width", why, help);
        }
    }
    if srp.wires.is_empty() {
        dead_if_given(found, &raw.hops, "hops", why, help);
    } else if !has_hops(srp) {
        let why = "no value goes from wire to wire within a cycle";
        let help = "have switches, such as `wires=\"mesh\"`, without registers";
        dead_if_given(found, &raw.hops, "hops", why, help);
    }
}

/// A delay, unless it asks for none.
fn some(delay: &Option<Text>) -> &Option<Text> {
    match delay {
        Some(text) if text.value == "0" => &None,
        _ => delay,
    }
}

/// True if a value may pass two wires in a cycle.
fn has_hops(srp: &Srp) -> bool {
    let mut inputs = srp.wires.values().flat_map(|wire| &wire.from);
    inputs.any(|input| matches!(*input, Input::Wire(before) if srp.wires[before].delay == 0))
}
