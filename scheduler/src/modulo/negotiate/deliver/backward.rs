//! Deliveries from everywhere to where a value is wanted.

use super::map::Map;
use super::{Deliver, Goal, over_moves};
use crate::modulo::negotiate::lanes::{OddMover, Shift, Shifts, Ways};
use crate::modulo::rows::{NEVER, relax, relax_by, set};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;

impl Deliver<'_> {
    /// The least cost from everywhere to a goal, from the first cycle to the last, in which an operand
    /// is read. `lands` then says what a landing costs.
    #[inline(always)]
    pub(in crate::modulo::negotiate) fn backward(
        &self,
        ty: Ty,
        goal: Goal,
        (from, at): (i32, i32),
        tag: bool,
        map: &mut Map,
    ) {
        map.begin(self.lanes, from, at, tag);
        let ways = self.ways(ty);
        let (width, margin, stride) = (map.width, map.margin, map.stride);
        // What the consumer reads itself costs no move.
        let operand = match goal {
            Goal::Operand(unit) => Some(unit),
            Goal::Keep(..) => None,
        };
        if tag {
            map.tagged_inputs[..map.cycles * stride].fill(NEVER);
        }
        for cycle in (0..map.cycles).rev() {
            let time = from + cycle as i32;
            let slot = self.market.slot(time);
            self.move_on(ways, map, cycle, time);
            if let Some(unit) = operand
                && time == at
            {
                let wanted = match tag {
                    true => &mut map.tagged_inputs,
                    false => &mut map.inputs,
                };
                wanted[cycle * stride + unit] = 0;
            }
            let hold = self.stay_row(time + 1);
            let (cycles, at) = (map.cycles, (cycle, width, margin));
            stay_before(ways, &mut map.stands, cycles, at, hold);
            let price = self.market.read_row(slot);
            let row = &mut map.stands[cycle * width..][..width];
            read_back(
                &ways.reads,
                &map.inputs,
                (cycle, cycles, stride),
                price,
                row,
                margin,
            );
            if tag {
                stay_before(ways, &mut map.tagged, cycles, at, hold);
                let row = &mut map.tagged[cycle * width..][..width];
                let inputs = &map.tagged_inputs;
                read_back(
                    &ways.reads,
                    inputs,
                    (cycle, cycles, stride),
                    price,
                    row,
                    margin,
                );
            }
            if let Goal::Keep(lane, price) = goal {
                // Entering pays for the first slot.
                let hold = i32::from(self.market.hold_row(slot)[lane]);
                let rest = (price - hold).clamp(0, i32::from(NEVER)) as i16;
                map.tagged[cycle * width + margin + lane] = rest;
            }
            self.transfer_back(ways, map, cycle, time);
            self.land_back(ways, map, cycle, slot);
        }
    }

    /// Computes the cost until the end of a move that is issued in a cycle.
    #[inline(always)]
    fn move_on(&self, ways: &Ways, map: &mut Map, cycle: usize, time: i32) {
        let stride = map.stride;
        let slot = self.market.slot(time);
        let inputs = &mut map.inputs[cycle * stride..][..stride];
        inputs.fill(NEVER);
        for movers in &ways.movers {
            let lands_in = cycle + movers.latency as usize;
            if lands_in >= map.cycles || time + movers.latency > self.deadline {
                continue;
            }
            let hold = (self.market).hold_row(self.market.slot(time + movers.latency));
            let lands = &map.lands[lands_in * stride..][..stride];
            let price = (self.market.issue_row(slot), &movers.mask[..]);
            over_moves(ways, inputs, lands, price, hold);
        }
        for OddMover { fu, timing } in &ways.odd_movers {
            let lands_in = cycle + timing.latency as usize;
            if lands_in >= map.cycles || time + timing.latency as i32 > self.deadline {
                continue;
            }
            let unit = fu.index();
            let lands = map.lands[lands_in * stride + unit];
            let cost = self.odd_move(ways, *fu, time, timing, lands);
            inputs[unit] = inputs[unit].min(cost);
        }
    }

    /// Lowers the cost of standing in an output to that of going over a link into a file.
    #[inline(always)]
    fn transfer_back(&self, ways: &Ways, map: &mut Map, cycle: usize, time: i32) {
        let (width, margin, cycles) = (map.width, map.margin, map.cycles);
        let (rows, after) = map.stands.split_at_mut((cycle + 1) * width);
        let row = &mut rows[cycle * width..];
        for shift in &ways.transfers.regular {
            let lands_in = cycle + shift.delay as usize;
            if lands_in >= cycles || time + shift.delay > self.deadline {
                continue;
            }
            let enter = self.market.enter_row(self.market.slot(time + shift.delay));
            let enter = &enter[shift.to..];
            let row = &mut row[(margin as isize + shift.from) as usize..][..shift.mask.len()];
            let rest = &after[(lands_in - cycle - 1) * width + margin + shift.to..];
            relax_by(row, rest, enter, &shift.mask);
            if map.has_tag {
                let rest = &map.tagged[lands_in * width + margin + shift.to..];
                relax_by(row, rest, enter, &shift.mask);
            }
        }
        for way in &ways.transfers.odd {
            let lands_in = cycle + way.delay as usize;
            if lands_in >= cycles || time + way.delay > self.deadline {
                continue;
            }
            let enter = self.market.enter_row(self.market.slot(time + way.delay))[way.to];
            let mut rest = after[(lands_in - cycle - 1) * width + margin + way.to];
            if map.has_tag {
                rest = rest.min(map.tagged[lands_in * width + margin + way.to]);
            }
            let to = &mut row[margin + way.from];
            *to = (*to).min(rest.saturating_add(enter));
        }
    }

    /// Computes the cost of landing in a unit's output: by standing there, or by being written into files.
    #[inline(always)]
    fn land_back(&self, ways: &Ways, map: &mut Map, cycle: usize, slot: usize) {
        let (width, margin, stride) = (map.width, map.margin, map.stride);
        let enter = self.market.enter_row(slot);
        let stands = &map.stands[cycle * width + margin..];
        let lands = &mut map.lands[cycle * stride..][..stride];
        match ways.landing_block {
            Some(block) => lands.copy_from_slice(&stands[block..][..stride]),
            None => {
                for (land, landing) in lands.iter_mut().zip(&ways.landing) {
                    *land = landing.map_or(NEVER, |landing| stands[landing.lane]);
                }
            }
        }
        let tagged = map.has_tag.then(|| &map.tagged[cycle * width + margin..]);
        for rest in [Some(stands), tagged].into_iter().flatten() {
            for Shift { to, mask, .. } in &ways.writes.regular {
                relax_by(lands, &rest[*to..], &enter[*to..], mask);
            }
            for way in &ways.writes.odd {
                let cost = rest[way.to].saturating_add(enter[way.to]);
                lands[way.from] = lands[way.from].min(cost);
            }
        }
    }
}

/// Lowers the cost of standing somewhere to that of standing there in the next cycle.
#[inline(always)]
fn stay_before(
    ways: &Ways,
    stands: &mut [i16],
    cycles: usize,
    (cycle, width, margin): (usize, usize, usize),
    hold: &[i16],
) {
    let (rows, after) = stands.split_at_mut((cycle + 1) * width);
    let row = &mut rows[cycle * width + margin..];
    for &(first, length) in &ways.spans {
        let row = &mut row[first..first + length];
        match cycle + 1 < cycles {
            true => set(row, &after[margin + first..], &hold[first..first + length]),
            false => row.fill(NEVER),
        }
    }
}

/// Lowers the cost of standing in places in a cycle to that of a unit's reading them.
#[inline(always)]
fn read_back(
    ways: &Shifts,
    inputs: &[i16],
    (cycle, cycles, stride): (usize, usize, usize),
    price: &[i16],
    row: &mut [i16],
    margin: usize,
) {
    for shift in &ways.regular {
        let read = cycle + shift.delay as usize;
        if read >= cycles {
            continue;
        }
        let inputs = &inputs[read * stride..][..stride];
        let start = (margin as isize + shift.from) as usize;
        let row = &mut row[start..][..stride];
        if shift.free {
            relax(row, inputs, &shift.mask);
        } else {
            relax_by(row, inputs, &price[shift.from as usize..], &shift.mask);
        }
    }
    for way in &ways.odd {
        let read = cycle + way.delay as usize;
        if read >= cycles {
            continue;
        }
        let cost = inputs[read * stride + way.to].saturating_add(price[way.from]);
        let to = &mut row[margin + way.from];
        *to = (*to).min(cost);
    }
}
