//! Deliveries from what a value has to everywhere.

use super::map::{Map, Own};
use super::{Deliver, over_moves};
use crate::modulo::negotiate::lanes::{OddMover, Shift, Ways};
use crate::modulo::rows::{NEVER, VECTOR, least, relax, relax_by, set, wide};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;

impl Deliver<'_> {
    /// The cheapest delivery of a value to everywhere from what it has, from the first cycle to the
    /// last; with `tag`, it is wanted in registers that are set before the loop.
    #[inline(always)]
    pub(in crate::modulo::negotiate) fn forward(
        &self,
        ty: Ty,
        own: &Own,
        (from, to): (i32, i32),
        tag: bool,
        map: &mut Map,
    ) {
        map.begin(self.lanes, from, to, tag);
        let ways = self.ways(ty);
        let (width, margin, stride) = (map.width, map.margin, map.stride);
        let mut own_lands = own.lands.iter().skip_while(|(t, _)| *t < from).peekable();
        let mut own_stands = own.stands.iter().skip_while(|(t, _)| *t < from).peekable();
        let mut own_tagged = own.tagged.iter().skip_while(|(t, _)| *t < from).peekable();
        for cycle in 0..map.cycles {
            let time = from + cycle as i32;
            match time <= self.deadline {
                true => self.land(ways, map, cycle, time),
                false => map.lands[cycle * stride..][..stride].fill(NEVER),
            }
            while let Some((_, unit)) = own_lands.next_if(|(t, _)| *t == time) {
                map.lands[cycle * stride + unit] = 0;
            }
            let hold = self.stay_row(time);
            stay(ways, &mut map.stands, (cycle, width, margin), hold);
            let row = &mut map.stands[cycle * width + margin..];
            let lands = &map.lands[cycle * stride..][..stride];
            come_out(ways, row, lands);
            self.enter(
                ways,
                &mut map.stands,
                (cycle, width, margin),
                time,
                lands,
                None,
            );
            while let Some((_, lane)) = own_stands.next_if(|(t, _)| *t == time) {
                map.stands[cycle * width + margin + lane] = 0;
            }
            self.read(
                ways,
                &map.stands,
                &mut map.inputs,
                (cycle, width, margin),
                time,
            );
            if !tag {
                continue;
            }
            stay(ways, &mut map.tagged, (cycle, width, margin), hold);
            let lands = &map.lands[cycle * stride..][..stride];
            let plain = Some(&map.stands[..]);
            self.enter(
                ways,
                &mut map.tagged,
                (cycle, width, margin),
                time,
                lands,
                plain,
            );
            while let Some((_, lane)) = own_tagged.next_if(|(t, _)| *t == time) {
                map.tagged[cycle * width + margin + lane] = 0;
            }
            self.read(
                ways,
                &map.tagged,
                &mut map.tagged_inputs,
                (cycle, width, margin),
                time,
            );
        }
    }

    /// [`forward`](Self::forward), compiled for the host's vectors.
    pub(in crate::modulo::negotiate) fn forward_wide(
        &self,
        ty: Ty,
        own: &Own,
        span: (i32, i32),
        tag: bool,
        map: &mut Map,
    ) {
        wide!(self.forward(ty, own, span, tag, map) => self.forward_avx2(ty, own, span, tag, map));
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn forward_avx2(&self, ty: Ty, own: &Own, span: (i32, i32), tag: bool, map: &mut Map) {
        self.forward(ty, own, span, tag, map);
    }

    /// Computes the least cost of landing by a move in a cycle.
    #[inline(always)]
    fn land(&self, ways: &Ways, map: &mut Map, cycle: usize, time: i32) {
        let stride = map.stride;
        let hold = self.market.hold_row(self.market.slot(time));
        let lands = &mut map.lands[cycle * stride..][..stride];
        lands.fill(NEVER);
        for movers in &ways.movers {
            let Some(issued) = cycle.checked_sub(movers.latency as usize) else {
                continue;
            };
            let slot = self.market.slot(time - movers.latency);
            let inputs = &map.inputs[issued * stride..][..stride];
            let price = (self.market.issue_row(slot), &movers.mask[..]);
            over_moves(ways, lands, inputs, price, hold);
        }
        for OddMover { fu, timing } in &ways.odd_movers {
            let Some(issued) = cycle.checked_sub(timing.latency as usize) else {
                continue;
            };
            let unit = fu.index();
            let inputs = map.inputs[issued * stride + unit];
            let cost = self.odd_move(ways, *fu, time - timing.latency as i32, timing, inputs);
            lands[unit] = lands[unit].min(cost);
        }
    }

    /// Enters values into files in a cycle: those that land then, and those that come over links from where
    /// they stand, in `stands` itself where there is no `plain`.
    #[inline(always)]
    fn enter(
        &self,
        ways: &Ways,
        stands: &mut [i16],
        (cycle, width, margin): (usize, usize, usize),
        time: i32,
        lands: &[i16],
        plain: Option<&[i16]>,
    ) {
        let enter = self.market.enter_row(self.market.slot(time));
        let (before, row) = stands.split_at_mut(cycle * width);
        let before = plain.unwrap_or(before);
        for Shift { to, mask, .. } in &ways.writes.regular {
            relax_by(
                &mut row[margin + to..][..mask.len()],
                lands,
                &enter[*to..],
                mask,
            );
        }
        for way in &ways.writes.odd {
            let cost = lands[way.from].saturating_add(enter[way.to]);
            let to = &mut row[margin + way.to];
            *to = (*to).min(cost);
        }
        if time > self.deadline {
            return;
        }
        for shift in &ways.transfers.regular {
            let Some(left) = cycle.checked_sub(shift.delay as usize) else {
                continue;
            };
            let start = ((left * width + margin) as isize + shift.from) as usize;
            let row = &mut row[margin + shift.to..][..shift.mask.len()];
            relax_by(row, &before[start..], &enter[shift.to..], &shift.mask);
        }
        for way in &ways.transfers.odd {
            let Some(left) = cycle.checked_sub(way.delay as usize) else {
                continue;
            };
            let cost = before[left * width + margin + way.from].saturating_add(enter[way.to]);
            let to = &mut row[margin + way.to];
            *to = (*to).min(cost);
        }
    }

    /// Computes the cost at which units can read in a cycle from places, reading included.
    #[inline(always)]
    fn read(
        &self,
        ways: &Ways,
        stands: &[i16],
        inputs: &mut [i16],
        (cycle, width, margin): (usize, usize, usize),
        time: i32,
    ) {
        let stride = self.lanes.stride;
        let row = &mut inputs[cycle * stride..][..stride];
        let at = (cycle, width, margin);
        if stride == VECTOR {
            // A row of its own length stays in a register.
            let mut least = [NEVER; VECTOR];
            self.read_regularly(ways, stands, &mut least, at, time);
            row.copy_from_slice(&least);
        } else {
            row.fill(NEVER);
            self.read_regularly(ways, stands, row, at, time);
        }
        for way in &ways.reads.odd {
            let Some(stood) = cycle.checked_sub(way.delay as usize) else {
                continue;
            };
            let price = self.market.read_row(self.market.slot(time - way.delay))[way.from];
            let cost = stands[stood * width + margin + way.from].saturating_add(price);
            row[way.to] = row[way.to].min(cost);
        }
    }

    /// Lowers a row of units to what they can read over ways that many of them have.
    #[inline(always)]
    fn read_regularly(
        &self,
        ways: &Ways,
        stands: &[i16],
        row: &mut [i16],
        (cycle, width, margin): (usize, usize, usize),
        time: i32,
    ) {
        for shift in &ways.reads.regular {
            let Some(stood) = cycle.checked_sub(shift.delay as usize) else {
                continue;
            };
            let start = ((stood * width + margin) as isize + shift.from) as usize;
            let from = &stands[start..][..row.len()];
            if shift.free {
                relax(row, from, &shift.mask);
            } else {
                let price = self.market.read_row(self.market.slot(time - shift.delay));
                relax_by(row, from, &price[shift.from as usize..], &shift.mask);
            }
        }
    }
}

/// Keeps values where they stood in the cycle before.
#[inline(always)]
fn stay(
    ways: &Ways,
    stands: &mut [i16],
    (cycle, width, margin): (usize, usize, usize),
    hold: &[i16],
) {
    let (before, row) = stands.split_at_mut(cycle * width);
    let row = &mut row[margin..];
    for &(first, length) in &ways.spans {
        let row = &mut row[first..first + length];
        match cycle {
            0 => row.fill(NEVER),
            _ => {
                let before = &before[(cycle - 1) * width + margin + first..];
                set(row, before, &hold[first..first + length]);
            }
        }
    }
}

/// Lets values that land in units' outputs stand there.
#[inline(always)]
fn come_out(ways: &Ways, row: &mut [i16], lands: &[i16]) {
    match ways.landing_block {
        Some(block) => least(&mut row[block..][..lands.len()], lands),
        None => {
            for (unit, landing) in ways.landing.iter().enumerate() {
                if let Some(landing) = landing {
                    row[landing.lane] = row[landing.lane].min(lands[unit]);
                }
            }
        }
    }
}
