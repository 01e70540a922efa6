//! Puts the steps of a cycle into an order in which carrying them out one after the other does
//! what the machine does at once: all reads before all writes.
//!
//! A step must come before every step that overwrites what it reads. Where that is circular, one of
//! the circle is split: it computes into a place of its own, and what it wrote is written later.

use crate::spec::{Cell, Landing, Step};
use srp_archdesc::isa::Effect;

/// Orders `steps`. Of two that write the same cell the one given first comes first. Loads come before stores, both otherwise in the order given.
///
/// `split` sends the result of a step elsewhere and gives the step that brings it to its place, if
/// that is a step of this cycle.
pub(super) fn sequence(
    steps: Vec<Step>,
    mut split: impl FnMut(&mut Step) -> Option<Step>,
) -> Vec<Step> {
    let mut ordered = Vec::with_capacity(steps.len());
    // Second halves are not split again: what they read is their own.
    let mut is_half = vec![false; steps.len()];
    let mut steps = steps;
    while !steps.is_empty() {
        if let Some(i) = (0..steps.len()).find(|&i| is_ready(&steps, i)) {
            ordered.push(steps.remove(i));
            is_half.remove(i);
            continue;
        }
        let i = (0..steps.len())
            .find(|&i| !is_half[i] && writes_here(&steps[i]) && memory_allows(&steps, i))
            .expect("a circle of steps goes through one that reads and writes cells");
        if let Some(half) = split(&mut steps[i]) {
            ordered.push(std::mem::replace(&mut steps[i], half));
            is_half[i] = true;
        } else {
            ordered.push(steps.remove(i));
            is_half.remove(i);
        }
    }
    ordered
}

fn writes_here(step: &Step) -> bool {
    step.landing == Landing::InPlace && !step.dests.is_empty()
}

fn effect(step: &Step) -> Effect {
    step.opcode().map_or(Effect::Pure, |op| op.info().effect)
}

/// Whether no other of `steps` must come before step `i`.
fn is_ready(steps: &[Step], i: usize) -> bool {
    let written: &[Cell] = if writes_here(&steps[i]) {
        &steps[i].dests
    } else {
        &[]
    };
    let blocked = steps.iter().enumerate().any(|(j, other)| {
        let overwrites = other.reads().any(|cell| written.contains(&cell));
        let older = j < i && writes_here(other) && other.dests.iter().any(|d| written.contains(d));
        j != i && (overwrites || older)
    });
    !blocked && memory_allows(steps, i)
}

/// Whether the order of memory accesses allows step `i` before the others.
fn memory_allows(steps: &[Step], i: usize) -> bool {
    let effect_of_step = effect(&steps[i]);
    steps.iter().enumerate().all(|(j, other)| {
        let before = match (effect(other), effect_of_step) {
            (Effect::Load, Effect::Store) => true,
            (Effect::Load, Effect::Load) | (Effect::Store, Effect::Store) => j < i,
            _ => false,
        };
        j == i || !before
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Action, Operand};
    use srp_archdesc::isa::{Opcode, Ty};

    fn cell(index: u32) -> Cell {
        Cell { store: 0, index }
    }

    fn op(op: Opcode, reads: &[u32], writes: &[u32]) -> Step {
        Step {
            stage: None,
            action: Action::Op {
                op,
                operands: reads.iter().map(|&r| Operand::Cell(cell(r))).collect(),
                imm: 0,
            },
            ty: op.result(),
            dests: writes.iter().map(|&w| cell(w)).collect(),
            landing: Landing::InPlace,
            at: 0,
        }
    }

    /// Carries out steps on small integers: each writes the sum of what it reads, times ten.
    fn run(steps: &[Step], state: &mut [u32]) {
        for step in steps {
            let value = step.reads().map(|c| state[c.index as usize]).sum::<u32>() * 10;
            for dest in &step.dests {
                state[dest.index as usize] = value;
            }
        }
    }

    fn split_to(temporary: u32) -> impl FnMut(&mut Step) -> Option<Step> {
        let mut next = temporary;
        move |step| {
            let place = cell(next);
            next += 1;
            let dests = std::mem::replace(&mut step.dests, vec![place]);
            let mut half = step.clone();
            half.action = Action::Copy(place);
            half.ty = Some(Ty::Word);
            half.dests = dests;
            Some(half)
        }
    }

    #[test]
    fn readers_come_before_writers() {
        let steps = vec![
            op(Opcode::Mov, &[3], &[2]),
            op(Opcode::Mov, &[2], &[1]),
            op(Opcode::Mov, &[1], &[0]),
        ];
        let mut state = [1, 2, 3, 4];
        run(&sequence(steps, |_| unreachable!()), &mut state);
        assert_eq!(state, [20, 30, 40, 4]);
    }

    #[test]
    fn a_circle_is_split_once() {
        let steps = vec![
            op(Opcode::Mov, &[1], &[0]),
            op(Opcode::Mov, &[2], &[1]),
            op(Opcode::Mov, &[0], &[2]),
        ];
        let ordered = sequence(steps, split_to(3));
        assert_eq!(ordered.len(), 4);
        // The second half of the split step copies, so its value is multiplied once more.
        let mut state = [1, 2, 3, 0, 0, 0];
        run(&ordered, &mut state);
        assert_eq!(state[..3], [200, 30, 10]);
    }

    #[test]
    fn loads_come_before_stores_even_in_a_circle() {
        // The store reads the register that the load overwrites.
        let steps = vec![
            op(Opcode::Sw, &[0, 1, 2], &[]),
            op(Opcode::Lw, &[0, 1], &[2]),
        ];
        let ordered = sequence(steps, split_to(3));
        let opcodes: Vec<_> = ordered.iter().map(Step::opcode).collect();
        assert_eq!(opcodes, [Some(Opcode::Lw), Some(Opcode::Sw), None]);
    }

    #[test]
    fn the_write_given_last_stays() {
        let steps = vec![op(Opcode::Mov, &[1], &[0]), op(Opcode::Mov, &[2], &[0])];
        let mut state = [0, 1, 2];
        run(&sequence(steps, |_| unreachable!()), &mut state);
        assert_eq!(state[0], 20);
    }
}
