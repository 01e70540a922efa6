//! What something was made of, and that of, and so on.

use super::Place;
use super::links::{Link, Links};
use srp_archdesc::isa::{Effect, Opcode};
use std::collections::BTreeMap;

/// What a pixel has of something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Want {
    /// That its value says where, or whether, something is done.
    Address,
    /// Its value.
    Value,
}

/// All that these were made of, and they themselves: of each what is wanted, and what it was made of.
pub(super) fn slice(links: &Links, roots: Vec<u32>) -> BTreeMap<u32, (Want, Vec<u32>)> {
    let mut wants: BTreeMap<u32, Want> = BTreeMap::new();
    let mut open: Vec<(u32, Want)> = roots.into_iter().map(|id| (id, Want::Value)).collect();
    while let Some((id, want)) = open.pop() {
        let known = wants.get(&id);
        if known.is_some_and(|&known| known >= want) {
            continue;
        }
        wants.insert(id, want);
        open.extend(parts(links, id, want));
    }
    let from = |(&id, &want): (&u32, &Want)| {
        let mut from: Vec<u32> = parts(links, id, want)
            .into_iter()
            .map(|part| part.0)
            .collect();
        from.sort_unstable();
        from.dedup();
        (id, (want, from))
    };
    wants.iter().map(from).collect()
}

/// What one thing was made of.
fn parts(links: &Links, id: u32, want: Want) -> Vec<(u32, Want)> {
    let link = &links.links[id as usize];
    let memory = links.memory(link).iter();
    let Some(step) = link.step else {
        return memory.map(|&store| (store, Want::Value)).collect();
    };
    let opcode = links.steps[step as usize].opcode;
    let effect = opcode.map(|op| op.info().effect);
    let is_access = matches!(effect, Some(Effect::Load | Effect::Store));
    let of_operand = |(i, &producer): (usize, &Option<u32>)| {
        let producer = producer?;
        let want = match i {
            0 if is_access => Want::Address,
            1 if is_access && opcode != Some(Opcode::Tex) => Want::Address,
            _ => want,
        };
        // A guard that was false is all that there is.
        let is_read = !is_access || link.is_made || i == 0;
        let follows = is_read && follows(links, link, &links.links[producer as usize], want);
        follows.then_some((producer, want))
    };
    let operands = link.operands.iter().enumerate().filter_map(of_operand);
    let through_memory = memory.filter_map(|&writer| {
        let of = &links.links[writer as usize];
        let is_queue = of.step.is_some() && matches!(of.place, Place::Bundle(_));
        (want == Want::Value || !is_queue).then_some((writer, want))
    });
    operands.chain(through_memory).collect()
}

/// True if what has made an operand is followed.
fn follows(links: &Links, reader: &Link, producer: &Link, want: Want) -> bool {
    let is_same = reader.step == producer.step;
    let counts = reader
        .step
        .is_some_and(|step| links.steps[step as usize].counts);
    if is_same && counts {
        return false;
    }
    match (reader.place, producer.place) {
        (
            Place::Array {
                kernel,
                launch,
                iteration,
            },
            Place::Array {
                kernel: of,
                launch: during,
                iteration: before,
            },
        ) if (kernel, launch) == (of, during) => {
            iteration == before || (want == Want::Value && !is_counter(links, producer))
        }
        _ => true,
    }
}

/// True if something is a step further than the same one before.
fn is_counter(links: &Links, of: &Link) -> bool {
    let counts = of
        .step
        .is_some_and(|step| links.steps[step as usize].counts);
    let mut operands = of.operands.iter().flatten();
    counts && operands.any(|&operand| links.links[operand as usize].step == of.step)
}
