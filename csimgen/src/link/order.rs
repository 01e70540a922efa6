//! Orders the steps of a cycle, so that running them one after the other has the effect of the machine,
//! which runs them at once: all reads before all writes.
//!
//! A step must come before every step that overwrites a cell that it reads. To break a cycle of such
//! constraints, one step is split: it computes into a cell of its own, and a later step copies the result.

use crate::spec::{Cell, Landing, Step};
use srp_archdesc::isa::Effect;

/// Orders `steps`. Of two that write the same cell the one given first comes first. Loads come
/// before stores, both otherwise in the order given. Where there is a choice, steps of the same
/// stage stay together.
///
/// `split` sends the result of a step elsewhere and gives the step that brings it to its place, if
/// that is a step of this cycle.
pub(super) fn sequence(
    steps: Vec<Step>,
    mut split: impl FnMut(&mut Step) -> Option<Step>,
) -> Vec<Step> {
    let mut pending = Pending::of(steps);
    let mut ordered: Vec<Step> = Vec::with_capacity(pending.steps.len());
    while pending.left > 0 {
        let stage = ordered.last().and_then(|step| step.stage);
        if let Some(i) = pending.ready(stage) {
            ordered.push(pending.take(i));
            continue;
        }
        let i = pending.splittable();
        let mut step = pending.take_reads(i);
        match split(&mut step) {
            Some(half) => pending.put_half(i, half),
            None => pending.finish_write(i),
        }
        ordered.push(step);
    }
    ordered
}

/// Steps that have no place in the order yet, and the steps that they wait for.
struct Pending {
    /// `None` once it is in order.
    steps: Vec<Option<Step>>,
    left: usize,
    /// True if a step is the second half of a split one. It is not split again: it reads only its own cells.
    is_half: Vec<bool>,
    /// How many steps must come before a step is carried out.
    waits: Vec<usize>,
    /// How many more must come before it writes.
    write_waits: Vec<usize>,
    /// The steps that wait for this one, to be carried out.
    followers: Vec<Vec<usize>>,
    /// The steps that wait for this one to have read, to write.
    overwriters: Vec<Vec<usize>>,
    /// The steps that wait for this one to have written, to write.
    later_writers: Vec<Vec<usize>>,
}

impl Pending {
    fn of(steps: Vec<Step>) -> Pending {
        let n = steps.len();
        let mut pending = Pending {
            left: n,
            is_half: vec![false; n],
            waits: vec![0; n],
            write_waits: vec![0; n],
            followers: vec![Vec::new(); n],
            overwriters: vec![Vec::new(); n],
            later_writers: vec![Vec::new(); n],
            steps: Vec::new(),
        };
        for (i, first) in steps.iter().enumerate() {
            for (j, other) in steps.iter().enumerate().filter(|(j, _)| *j != i) {
                let written = written(other);
                if memory_orders(first, other, i < j) {
                    pending.followers[i].push(j);
                    pending.waits[j] += 1;
                }
                if first
                    .reads()
                    .any(|cell| written.iter().any(|d| d.meets(cell)))
                {
                    pending.overwriters[i].push(j);
                    pending.write_waits[j] += 1;
                }
                let meets = |d: &Cell| written.iter().any(|other| other.meets(*d));
                if i < j && self::written(first).iter().any(meets) {
                    pending.later_writers[i].push(j);
                    pending.write_waits[j] += 1;
                }
            }
        }
        pending.steps = steps.into_iter().map(Some).collect();
        pending
    }

    /// A step that waits for nothing, of this stage if there is one.
    fn ready(&self, stage: Option<u32>) -> Option<usize> {
        let is_ready =
            |&i: &usize| self.steps[i].is_some() && self.waits[i] == 0 && self.write_waits[i] == 0;
        let mut ready = (0..self.steps.len()).filter(is_ready);
        let first = ready.clone().next();
        let alike = |&i: &usize| self.steps[i].as_ref().is_some_and(|s| s.stage == stage);
        ready.find(alike).or(first)
    }

    /// A step that may read but not write yet.
    fn splittable(&self) -> usize {
        (0..self.steps.len())
            .find(|&i| self.steps[i].is_some() && !self.is_half[i] && self.waits[i] == 0)
            .expect("memory orders steps in no circle, and second halves wait for first ones only")
    }

    /// Puts a whole step, or a second half, in order.
    fn take(&mut self, i: usize) -> Step {
        let step = if self.is_half[i] {
            self.steps[i].take()
        } else {
            Some(self.take_reads(i))
        };
        self.finish_write(i);
        step.expect("a step is put in order once")
    }

    /// Puts the first half of a step in order.
    fn take_reads(&mut self, i: usize) -> Step {
        for j in std::mem::take(&mut self.followers[i]) {
            self.waits[j] -= 1;
        }
        for j in std::mem::take(&mut self.overwriters[i]) {
            self.write_waits[j] -= 1;
        }
        self.steps[i].take().expect("a step is put in order once")
    }

    fn put_half(&mut self, i: usize, half: Step) {
        self.steps[i] = Some(half);
        self.is_half[i] = true;
    }

    fn finish_write(&mut self, i: usize) {
        self.left -= 1;
        for j in std::mem::take(&mut self.later_writers[i]) {
            self.write_waits[j] -= 1;
        }
    }
}

/// The cells that a step writes itself.
fn written(step: &Step) -> &[Cell] {
    match step.landing {
        Landing::InPlace => &step.dests,
        Landing::After(_) => &[],
    }
}

/// True if `first` must come before `other` because of memory; `is_earlier` if it was given first.
fn memory_orders(first: &Step, other: &Step, is_earlier: bool) -> bool {
    match (effect(first), effect(other)) {
        (Effect::Load, Effect::Store) => true,
        (Effect::Load, Effect::Load) | (Effect::Store, Effect::Store) => is_earlier,
        _ => false,
    }
}

fn effect(step: &Step) -> Effect {
    step.opcode().map_or(Effect::Pure, |op| op.info().effect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Action, Operand, Origin};
    use srp_archdesc::isa::{Opcode, Ty};

    fn cell(index: u32) -> Cell {
        Cell::new(0, index)
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
            origin: Origin::Way,
            at: 0,
        }
    }

    /// Carries out steps on small integers: each writes ten times the sum of the cells that it reads.
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
