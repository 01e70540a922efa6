//! The cheapest deliveries of a value: to everywhere from what it has, and from everywhere to where it
//! is wanted.
//!
//! A pass over the cycles computes both for all places at once, each cycle a few additions and minima
//! of vectors. [`Deliver::forward`] starts at no cost from every point that the value reaches already,
//! so that consumers share what leads to them. Costs are 16-bit integers: hosts agree, and vectors are
//! long.

use super::lanes::{Lanes, NEVER, OddMover, Shift, Shifts, Ways};
use super::market::Market;
use srp_archdesc::arch::{Fu, FuOp};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;

/// A value that was delivered to everywhere, or that is wanted somewhere: costs by cycle and lane.
///
/// Rows hold what earlier maps left in lanes where no value of this type stands. Those are read under
/// masks only.
#[derive(Default)]
pub(super) struct Map {
    /// The first cycle, and how many there are.
    pub(super) from: i32,
    pub(super) cycles: usize,
    /// Lanes of a row of `stands`, margins included, and the first lane in it.
    width: usize,
    margin: usize,
    stride: usize,
    /// Standing in a place, and in registers that are set before the loop.
    stands: Vec<i16>,
    tagged: Vec<i16>,
    /// Landing in a unit's output.
    lands: Vec<i16>,
    /// Forward: being readable by a unit. Backward: being moved by it.
    inputs: Vec<i16>,
    /// Forward: being readable from registers that are set before the loop.
    tagged_inputs: Vec<i16>,
    /// Whether the value has to be in such registers.
    has_tag: bool,
}

/// Where a value is wanted.
#[derive(Clone, Copy)]
pub(super) enum Goal {
    /// At the inputs of a unit in the last cycle.
    Operand(usize),
    /// In a register for good, by lane, at a price for all slots.
    Keep(usize, i32),
}

/// What a value has that others may start from: cycle, and lane or unit; by cycle.
#[derive(Default)]
pub(super) struct Own {
    pub(super) stands: Vec<(i32, usize)>,
    pub(super) tagged: Vec<(i32, usize)>,
    pub(super) lands: Vec<(i32, usize)>,
}

impl Own {
    /// Puts all in order.
    pub(super) fn sort(&mut self) {
        self.stands.sort_unstable();
        self.tagged.sort_unstable();
        self.lands.sort_unstable();
    }
}

impl Map {
    fn begin(&mut self, lanes: &Lanes, from: i32, to: i32, has_tag: bool) {
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
    pub(super) fn empty(&mut self) {
        self.cycles = 0;
    }

    /// The costs of being at the units' inputs in a cycle, in the form that is wanted.
    pub(super) fn inputs_row(&self, time: i32) -> Option<&[i16]> {
        let start = self.unit_index(time, 0)?;
        let inputs = match self.has_tag {
            true => &self.tagged_inputs,
            false => &self.inputs,
        };
        Some(&inputs[start..start + self.stride])
    }

    /// The costs of landing in the units' outputs in a cycle.
    pub(super) fn lands_row(&self, time: i32) -> Option<&[i16]> {
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
    pub(super) fn stands(&self, time: i32, lane: usize) -> i16 {
        self.index(time, lane).map_or(NEVER, |i| self.stands[i])
    }

    /// The cost of standing in a register that is set before the loop.
    pub(super) fn tagged(&self, time: i32, lane: usize) -> i16 {
        match (self.has_tag, self.index(time, lane)) {
            (true, Some(i)) => self.tagged[i],
            _ => NEVER,
        }
    }

    /// The cost of landing in a unit's output.
    pub(super) fn lands(&self, time: i32, unit: usize) -> i16 {
        self.unit_index(time, unit).map_or(NEVER, |i| self.lands[i])
    }
}

/// Sets a row to the sums of two.
#[inline(always)]
fn set(to: &mut [i16], from: &[i16], price: &[i16]) {
    for ((to, &from), &price) in to.iter_mut().zip(from).zip(price) {
        *to = from.saturating_add(price);
    }
}

/// Keeps the smaller of two rows.
#[inline(always)]
fn least(to: &mut [i16], from: &[i16]) {
    for (to, &from) in to.iter_mut().zip(from) {
        *to = (*to).min(from);
    }
}

/// Adds two rows and keeps the smaller sums.
#[inline(always)]
fn relax(to: &mut [i16], from: &[i16], price: &[i16]) {
    for ((to, &from), &price) in to.iter_mut().zip(from).zip(price) {
        *to = (*to).min(from.saturating_add(price));
    }
}

/// The same with two prices.
#[inline(always)]
fn relax_by(to: &mut [i16], from: &[i16], price: &[i16], mask: &[i16]) {
    for (((to, &from), &price), &mask) in to.iter_mut().zip(from).zip(price).zip(mask) {
        *to = (*to).min(from.saturating_add(price).saturating_add(mask));
    }
}

/// The same with three prices.
#[inline(always)]
fn relax_by_all(to: &mut [i16], from: &[i16], (a, b, mask): (&[i16], &[i16], &[i16])) {
    let prices = a.iter().zip(b).zip(mask);
    for ((to, &from), ((&a, &b), &mask)) in to.iter_mut().zip(from).zip(prices) {
        let price = a.saturating_add(b).saturating_add(mask);
        *to = (*to).min(from.saturating_add(price));
    }
}

/// Deliveries on one machine at the prices of the moment.
pub(super) struct Deliver<'a> {
    pub(super) lanes: &'a Lanes,
    pub(super) market: &'a Market,
}

impl Deliver<'_> {
    fn ways(&self, ty: Ty) -> &Ways {
        &self.lanes.ways[ty as usize]
    }

    /// The cheapest delivery of a value to everywhere from what it has, from the first cycle to the
    /// last; with `tag`, it is wanted in registers that are set before the loop.
    #[inline(always)]
    pub(super) fn forward(
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
            self.land(ways, map, cycle, time);
            while let Some((_, unit)) = own_lands.next_if(|(t, _)| *t == time) {
                map.lands[cycle * stride + unit] = 0;
            }
            let hold = self.market.hold_row(self.market.slot(time));
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
    pub(super) fn forward_wide(
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

    /// What moves land in a cycle.
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

    /// What a move that holds more than an issue slot adds to the cost of one of its ends.
    fn odd_move(&self, ways: &Ways, fu: Fu, issue: i32, timing: &FuOp, cost: i16) -> i16 {
        let Some(landing) = ways.landing[fu.index()] else {
            return NEVER;
        };
        let lands = issue + landing.latency;
        let hold = self.market.hold_row(self.market.slot(lands))[landing.lane];
        let operation = self.market.operation(fu, issue, timing);
        let operation = operation.min(i32::from(NEVER)) as i16;
        cost.saturating_add(operation).saturating_add(hold)
    }

    /// What is written into files in a cycle: what lands then, and what comes over links from where
    /// it stands, in `stands` itself where there is no `plain`.
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

    /// What units can read in a cycle of what stands in places, reading included.
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
        row.fill(NEVER);
        for shift in &ways.reads.regular {
            let Some(stood) = cycle.checked_sub(shift.delay as usize) else {
                continue;
            };
            let start = ((stood * width + margin) as isize + shift.from) as usize;
            let from = &stands[start..][..stride];
            if shift.free {
                relax(row, from, &shift.mask);
            } else {
                let price = self.market.read_row(self.market.slot(time - shift.delay));
                relax_by(row, from, &price[shift.from as usize..], &shift.mask);
            }
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

    /// The least cost from everywhere to a goal, from the first cycle to the last, in which an operand
    /// is read. `lands` then says what a landing costs.
    #[inline(always)]
    pub(super) fn backward(
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
            let hold = self.market.hold_row(self.market.slot(time + 1));
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

    /// What a move that is issued in a cycle costs until the end.
    #[inline(always)]
    fn move_on(&self, ways: &Ways, map: &mut Map, cycle: usize, time: i32) {
        let stride = map.stride;
        let slot = self.market.slot(time);
        let inputs = &mut map.inputs[cycle * stride..][..stride];
        inputs.fill(NEVER);
        for movers in &ways.movers {
            let lands_in = cycle + movers.latency as usize;
            if lands_in >= map.cycles {
                continue;
            }
            let hold = (self.market).hold_row(self.market.slot(time + movers.latency));
            let lands = &map.lands[lands_in * stride..][..stride];
            let price = (self.market.issue_row(slot), &movers.mask[..]);
            over_moves(ways, inputs, lands, price, hold);
        }
        for OddMover { fu, timing } in &ways.odd_movers {
            let lands_in = cycle + timing.latency as usize;
            if lands_in >= map.cycles {
                continue;
            }
            let unit = fu.index();
            let lands = map.lands[lands_in * stride + unit];
            let cost = self.odd_move(ways, *fu, time, timing, lands);
            inputs[unit] = inputs[unit].min(cost);
        }
    }

    /// What standing in an output is worth because it can go over a link into a file.
    #[inline(always)]
    fn transfer_back(&self, ways: &Ways, map: &mut Map, cycle: usize, time: i32) {
        let (width, margin, cycles) = (map.width, map.margin, map.cycles);
        let (rows, after) = map.stands.split_at_mut((cycle + 1) * width);
        let row = &mut rows[cycle * width..];
        for shift in &ways.transfers.regular {
            let lands_in = cycle + shift.delay as usize;
            if lands_in >= cycles {
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
            if lands_in >= cycles {
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

    /// What landing in a unit's output is worth: standing there, or being written into files.
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

/// What stands where it stood in the cycle before.
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

/// What standing somewhere is worth because it stands there in the next cycle.
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

/// What lands in units' outputs stands there.
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

/// Lowers the costs of one end of moves by those of the other: what a move issues and where it lands.
#[inline(always)]
fn over_moves(
    ways: &Ways,
    to: &mut [i16],
    from: &[i16],
    (issue, mask): (&[i16], &[i16]),
    hold: &[i16],
) {
    if let Some(block) = ways.landing_block {
        relax_by_all(to, from, (issue, &hold[block..], mask));
        return;
    }
    for (unit, landing) in ways.landing.iter().enumerate() {
        if let Some(landing) = landing {
            let cost = from[unit].saturating_add(issue[unit]);
            let cost = cost.saturating_add(hold[landing.lane]);
            to[unit] = to[unit].min(cost.saturating_add(mask[unit]));
        }
    }
}

/// What standing in places in a cycle is worth because units can read them.
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
