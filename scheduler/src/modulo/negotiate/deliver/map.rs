//! Maps of costs by cycle and lane, and the points that a delivery may start from.

use super::super::lanes::Lanes;
use crate::modulo::rows::NEVER;

/// A value that was delivered to everywhere, or that is wanted somewhere: costs by cycle and lane.
///
/// Rows hold what earlier maps left in lanes where no value of this type stands. Those are read under
/// masks only.
#[derive(Default)]
pub(in crate::modulo::negotiate) struct Map {
    /// The first cycle, and how many there are.
    pub(in crate::modulo::negotiate) from: i32,
    pub(in crate::modulo::negotiate) cycles: usize,
    /// Lanes of a row of `stands`, margins included, and the first lane in it.
    pub(super) width: usize,
    pub(super) margin: usize,
    pub(super) stride: usize,
    /// Standing in a place, and in registers that are set before the loop.
    pub(super) stands: Vec<i16>,
    pub(super) tagged: Vec<i16>,
    /// Landing in a unit's output.
    pub(super) lands: Vec<i16>,
    /// Forward: being readable by a unit. Backward: being moved by it.
    pub(super) inputs: Vec<i16>,
    /// Forward: being readable from registers that are set before the loop.
    pub(super) tagged_inputs: Vec<i16>,
    /// True when the value has to be in such registers.
    pub(super) has_tag: bool,
}

/// The points of a value's routes that others may start from: cycle, and lane or unit; by cycle.
#[derive(Default)]
pub(in crate::modulo::negotiate) struct Own {
    pub(in crate::modulo::negotiate) stands: Vec<(i32, usize)>,
    pub(in crate::modulo::negotiate) tagged: Vec<(i32, usize)>,
    pub(in crate::modulo::negotiate) lands: Vec<(i32, usize)>,
}

impl Own {
    /// Puts all in order.
    pub(in crate::modulo::negotiate) fn sort(&mut self) {
        self.stands.sort_unstable();
        self.tagged.sort_unstable();
        self.lands.sort_unstable();
    }
}

impl Map {
    pub(super) fn begin(&mut self, lanes: &Lanes, from: i32, to: i32, has_tag: bool) {
        self.from = from;
        self.cycles = (to - from + 1).max(0) as usize;
        self.stride = lanes.stride;
        self.margin = lanes.stride;
        self.width = lanes.count + 2 * lanes.stride;
        self.has_tag = has_tag;
        let (wide, narrow) = (self.cycles * self.width, self.cycles * self.stride);
        let room = |row: &mut Vec<i16>, length: usize| {
            if row.len() < length {
                row.resize(length, NEVER);
            }
        };
        room(&mut self.stands, wide);
        room(&mut self.lands, narrow);
        room(&mut self.inputs, narrow);
        if has_tag {
            room(&mut self.tagged, wide);
            room(&mut self.tagged_inputs, narrow);
        }
    }

    /// Forgets everything: nothing is delivered anywhere.
    pub(in crate::modulo::negotiate) fn empty(&mut self) {
        self.cycles = 0;
    }

    /// The costs of being at the units' inputs in a cycle, in the form that is wanted.
    pub(in crate::modulo::negotiate) fn inputs_row(&self, time: i32) -> Option<&[i16]> {
        let start = self.unit_index(time, 0)?;
        let inputs = match self.has_tag {
            true => &self.tagged_inputs,
            false => &self.inputs,
        };
        Some(&inputs[start..start + self.stride])
    }

    /// The costs of landing in the units' outputs in a cycle.
    pub(in crate::modulo::negotiate) fn lands_row(&self, time: i32) -> Option<&[i16]> {
        let start = self.unit_index(time, 0)?;
        Some(&self.lands[start..start + self.stride])
    }

    fn index(&self, time: i32, lane: usize) -> Option<usize> {
        let cycle = usize::try_from(time - self.from).ok()?;
        (cycle < self.cycles).then_some(cycle * self.width + self.margin + lane)
    }

    fn unit_index(&self, time: i32, unit: usize) -> Option<usize> {
        let cycle = usize::try_from(time - self.from).ok()?;
        (cycle < self.cycles).then_some(cycle * self.stride + unit)
    }

    /// The cost of standing in a lane.
    pub(in crate::modulo::negotiate) fn stands(&self, time: i32, lane: usize) -> i16 {
        self.index(time, lane).map_or(NEVER, |i| self.stands[i])
    }

    /// The cost of standing in a register that is set before the loop.
    pub(in crate::modulo::negotiate) fn tagged(&self, time: i32, lane: usize) -> i16 {
        match (self.has_tag, self.index(time, lane)) {
            (true, Some(i)) => self.tagged[i],
            _ => NEVER,
        }
    }

    /// The cost of landing in a unit's output.
    pub(in crate::modulo::negotiate) fn lands(&self, time: i32, unit: usize) -> i16 {
        self.unit_index(time, unit).map_or(NEVER, |i| self.lands[i])
    }
}
