//! Prices: each resource has a price in each slot, which rises while it is overused and stays
//! raised in part afterwards (*negotiated congestion*, McMurchie and Ebeling, FPGA 1995).

use super::lanes::Lanes;
use crate::modulo::problem::Problem;
use crate::modulo::rows::NEVER;
use crate::modulo::slots::Slots;
use crate::modulo::table::Item;
use srp_archdesc::arch::{FileKind, Fu, FuOp, Resource};
use srp_archdesc::entity::Entity;
use srp_archdesc::resource::Place;

/// Prices without overuse. Issue slots and cycles of outputs are scarce; registers are cheap.
const ISSUE: i16 = 32;
const OUTPUT: i16 = 32;
const REGISTER: i16 = 1;
const WRITE: i16 = 1;
const READ: i16 = 0;
const SHARED: i16 = 4;
/// The additional price of a cycle in a file that does not rotate, for a value that lives longer than it can stay there.
const OVERSTAY: i16 = 2;

/// Prices do not rise above this: sums of several stay below [`NEVER`].
const DEAREST: i16 = 3000;

/// A resource in a slot, by its index.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct Good(u32);

/// Resources of one kind, slot by slot: `slot * count + number`.
struct Goods {
    first: u32,
    count: usize,
}

/// All resources.
pub(super) struct Market {
    ii: i32,
    slots: Slots,
    issue: Goods,
    hold: Goods,
    write: Goods,
    read: Goods,
    shared: Goods,
    used: Vec<u16>,
    room: Vec<u16>,
    base: Vec<i16>,
    history: Vec<i16>,
    price: Vec<i16>,
    /// The price of a file's port to write and of standing there, by lane.
    enter: Vec<i16>,
    /// The price of standing there for values that live long, by lane, and what it has more than the usual one.
    hold_long: Vec<i16>,
    overstay: Vec<i16>,
    /// The price of each use beyond the capacity.
    penalty: i16,
    /// Uses beyond the capacity, of all resources together.
    pub(super) excess: i64,
}

impl Market {
    pub(super) fn new(problem: &Problem<'_>, lanes: &Lanes, ii: u32) -> Market {
        let slots = ii as usize;
        let mut total = 0;
        let mut goods = |count: usize| {
            let first = total;
            total += (count * slots) as u32;
            Goods { first, count }
        };
        let (issue, hold) = (goods(lanes.stride), goods(lanes.count));
        let (write, read) = (goods(lanes.count), goods(lanes.count));
        let shared = goods(problem.srp.resources.len());
        let all = total as usize;
        let mut market = Market {
            ii: ii as i32,
            slots: Slots::of(ii as i32),
            used: vec![0; all],
            room: vec![0; all],
            base: vec![NEVER; all],
            history: vec![0; all],
            price: vec![NEVER; all],
            enter: vec![NEVER; lanes.count * slots],
            hold_long: vec![NEVER; lanes.count * slots],
            overstay: vec![0; lanes.count * slots],
            penalty: 0,
            excess: 0,
            issue,
            hold,
            write,
            read,
            shared,
        };
        for slot in 0..slots {
            for fu in problem.srp.fus.keys() {
                let good = market.issue.at(slot, fu.index());
                market.offer(good, 1, ISSUE);
            }
            let places = problem.graph.places.iter();
            for (place, spec) in places.filter(|&(place, _)| lanes.has(place)) {
                let lane = lanes.of[place];
                let held = match problem.is_output(place) {
                    true => OUTPUT,
                    false => REGISTER,
                };
                market.offer(market.hold.at(slot, lane), spec.capacity, held);
                let Some(file) = problem.graph.as_file(place) else {
                    // Whoever sees an output may read it.
                    let good = market.read.at(slot, lane);
                    market.offer(good, u32::from(u16::MAX), 0);
                    continue;
                };
                let spec = &problem.srp.files[file];
                if spec.kind != FileKind::Rotating {
                    market.overstay[slot * lanes.count + lane] = OVERSTAY;
                }
                market.offer(market.write.at(slot, lane), spec.write_ports, WRITE);
                market.offer(market.read.at(slot, lane), spec.read_ports, READ);
            }
            for (resource, spec) in problem.srp.resources.iter() {
                let good = market.shared.at(slot, resource.index());
                market.offer(good, spec.count, SHARED);
            }
        }
        market.reprice(0);
        market
    }

    fn offer(&mut self, good: Good, room: u32, base: i16) {
        let at = good.0 as usize;
        self.room[at] = room.min(u32::from(u16::MAX)) as u16;
        self.base[at] = base;
    }

    /// The slot of a cycle.
    pub(super) fn slot(&self, time: i32) -> usize {
        self.slots.slot(time)
    }

    /// Sets the price of each use beyond the capacity.
    pub(super) fn reprice(&mut self, penalty: i16) {
        self.penalty = penalty;
        (0..self.used.len() as u32).for_each(|i| self.set_price(Good(i)));
    }

    /// Raises the prices of overused resources for good.
    pub(super) fn remember(&mut self, by: i16) {
        for i in 0..self.used.len() {
            if self.used[i] > self.room[i] {
                self.history[i] = (self.history[i] + by).min(DEAREST);
                self.set_price(Good(i as u32));
            }
        }
    }

    fn set_price(&mut self, good: Good) {
        let i = good.0 as usize;
        if self.base[i] == NEVER {
            return;
        }
        // One more use than there is now.
        let over = (i32::from(self.used[i]) + 1 - i32::from(self.room[i])).max(0);
        let price =
            i32::from(self.base[i]) + i32::from(self.history[i]) + over * i32::from(self.penalty);
        self.price[i] = price.min(i32::from(DEAREST)) as i16;
        let (write, hold) = (&self.write, &self.hold);
        let lane = match good.0 {
            g if g >= write.first && g < write.first + self.enter.len() as u32 => g - write.first,
            g if g >= hold.first && g < hold.first + self.enter.len() as u32 => g - hold.first,
            _ => return,
        };
        let lane = lane as usize;
        let write = self.price[write.first as usize + lane];
        let hold = self.price[hold.first as usize + lane];
        self.enter[lane] = write.saturating_add(hold).min(NEVER);
        self.hold_long[lane] = hold.saturating_add(self.overstay[lane]);
    }

    pub(super) fn take(&mut self, good: Good) {
        let i = good.0 as usize;
        self.used[i] += 1;
        self.excess += i64::from(self.used[i] > self.room[i]);
        self.set_price(good);
    }

    pub(super) fn give_back(&mut self, good: Good) {
        let i = good.0 as usize;
        self.excess -= i64::from(self.used[i] > self.room[i]);
        self.used[i] -= 1;
        self.set_price(good);
    }

    /// Takes room from a file for good, because its registers did not suffice as they were counted.
    pub(super) fn shrink(&mut self, lane: usize) {
        for slot in 0..self.ii as usize {
            let i = self.hold.at(slot, lane).0 as usize;
            if self.room[i] > 0 {
                self.excess += i64::from(self.used[i] >= self.room[i]);
                self.room[i] -= 1;
            }
            self.set_price(Good(i as u32));
        }
    }

    /// Takes registers of a file in every slot, which are not to be had at any price.
    pub(super) fn reserve(&mut self, lane: usize, count: u32) {
        (0..count).for_each(|_| self.shrink(lane));
    }

    pub(super) fn is_overused(&self, good: Good) -> bool {
        self.used[good.0 as usize] > self.room[good.0 as usize]
    }

    fn row(&self, goods: &Goods, slot: usize) -> &[i16] {
        let start = goods.first as usize + slot * goods.count;
        &self.price[start..start + goods.count]
    }

    /// Prices of issue slots, by unit.
    pub(super) fn issue_row(&self, slot: usize) -> &[i16] {
        self.row(&self.issue, slot)
    }

    /// Prices of standing in a place for a cycle, by lane.
    pub(super) fn hold_row(&self, slot: usize) -> &[i16] {
        self.row(&self.hold, slot)
    }

    /// The same for values that live longer than they can stay in files that do not rotate.
    pub(super) fn hold_long_row(&self, slot: usize) -> &[i16] {
        let count = self.hold.count;
        &self.hold_long[slot * count..(slot + 1) * count]
    }

    /// Prices of reading a place, by lane.
    pub(super) fn read_row(&self, slot: usize) -> &[i16] {
        self.row(&self.read, slot)
    }

    /// Prices of being written into a file and standing there, by lane.
    pub(super) fn enter_row(&self, slot: usize) -> &[i16] {
        let count = self.hold.count;
        &self.enter[slot * count..(slot + 1) * count]
    }

    pub(super) fn hold_good(&self, time: i32, lane: usize) -> Good {
        self.hold.at(self.slot(time), lane)
    }

    pub(super) fn read_good(&self, time: i32, lane: usize) -> Good {
        self.read.at(self.slot(time), lane)
    }

    /// The price of an operation with this timing on a unit, issued in a cycle.
    pub(super) fn operation(&self, fu: Fu, time: i32, timing: &FuOp) -> i32 {
        let slots = (0..timing.interval as i32).map(|k| self.slot(time + k));
        let price = |slot: usize| {
            let shared = timing.uses.iter().map(|r| self.shared.at(slot, r.index()));
            let goods = shared.chain([self.issue.at(slot, fu.index())]);
            goods
                .map(|g| i32::from(self.price[g.0 as usize]))
                .sum::<i32>()
        };
        slots.map(price).sum()
    }

    pub(super) fn price(&self, good: Good) -> i32 {
        i32::from(self.price[good.0 as usize])
    }

    /// Adds the goods of an operation: its unit's issue slots, and shared resources.
    pub(super) fn goods_of_operation(
        &self,
        fu: Fu,
        time: i32,
        timing: &FuOp,
        goods: &mut Vec<Good>,
    ) {
        for k in 0..timing.interval as i32 {
            let slot = self.slot(time + k);
            goods.push(self.issue.at(slot, fu.index()));
            let shared = |r: &Resource| self.shared.at(slot, r.index());
            goods.extend(timing.uses.iter().map(shared));
        }
    }

    /// Adds the goods of an item of a value; `timing` is that of a move.
    pub(super) fn goods_of_item(
        &self,
        lanes: &Lanes,
        item: Item,
        timing: Option<&FuOp>,
        goods: &mut Vec<Good>,
    ) {
        let lane = |place: Place| lanes.of[place];
        match item {
            Item::Out(place, time) | Item::Held(place, time, _) => {
                goods.push(self.hold.at(self.slot(time), lane(place)));
            }
            Item::Written(place, time, ..) => {
                goods.push(self.write.at(self.slot(time), lane(place)));
            }
            Item::Read(place, time, ..) => {
                goods.push(self.read.at(self.slot(time), lane(place)));
            }
            Item::Move(fu, time, ..) => {
                let timing = timing.expect("a move comes with its timing");
                self.goods_of_operation(fu, time, timing, goods);
            }
            Item::Kept(place, _) => {
                let slots = 0..self.ii as usize;
                goods.extend(slots.map(|slot| self.hold.at(slot, lane(place))));
            }
            Item::Wire(..) => {}
        }
    }
}

impl Goods {
    fn at(&self, slot: usize, number: usize) -> Good {
        Good(self.first + (slot * self.count + number) as u32)
    }
}
