//! Prices of issue slots and registers, which rise where more are taken than there are, and stay raised in part
//! (*negotiated congestion*, McMurchie and Ebeling, FPGA 1995).

use super::array::Array;
use crate::modulo::rows::NEVER;
use crate::modulo::slots::Slots;

/// Prices without overuse, of an issue slot and of a register for a cycle.
const ISSUE: i16 = 16;
const REGISTER: i16 = 4;
/// Prices do not rise above this: sums of several stay below [`NEVER`].
const DEAREST: i32 = 3000;
/// By how much the price of what is taken too often rises with each stage, and that of an issue slot falls that is not.
const RISE: i16 = 6;
const FALL: i16 = 1;

/// The two kinds of goods.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// The issue slot of a unit, and with it the output in the cycle after: who keeps the output from the next
    /// result keeps the unit from issuing.
    Issue,
    /// A register of a unit's file.
    Register,
}

/// Goods of one kind, slot by slot, lane by lane.
struct Goods {
    base: i16,
    used: Vec<u16>,
    room: Vec<u16>,
    history: Vec<i16>,
    price: Vec<i16>,
}

impl Goods {
    fn new(base: i16, slots: usize, room: &[u16]) -> Goods {
        let count = slots * room.len();
        let rooms = room.iter().copied().cycle().take(count);
        Goods {
            base,
            used: vec![0; count],
            room: rooms.collect(),
            history: vec![0; count],
            price: vec![NEVER; count],
        }
    }

    fn set(&mut self, at: usize, penalty: i32) {
        if self.room[at] == 0 {
            return;
        }
        // One more use than there is now.
        let over = (i32::from(self.used[at]) + 1 - i32::from(self.room[at])).max(0);
        let price = i32::from(self.base) + i32::from(self.history[at]) + over * penalty;
        self.price[at] = price.min(DEAREST) as i16;
    }
}

/// The goods of an array, with their prices.
pub(super) struct Prices {
    pub(super) slots: Slots,
    lanes: usize,
    issue: Goods,
    registers: Goods,
    /// The price of each use beyond what there is.
    pub(super) penalty: i32,
    /// Uses beyond what there is, of all together.
    pub(super) excess: i64,
}

impl Prices {
    pub(super) fn new(array: &Array, ii: u32) -> Prices {
        let mut issue = vec![0; array.lanes];
        issue[..array.files.len()].fill(1);
        let mut registers = vec![0; array.lanes];
        for (room, file) in registers.iter_mut().zip(&array.files) {
            *room = file.map_or(0, |(_, size)| size);
        }
        let mut prices = Prices {
            slots: Slots::of(ii as i32),
            lanes: array.lanes,
            issue: Goods::new(ISSUE, ii as usize, &issue),
            registers: Goods::new(REGISTER, ii as usize, &registers),
            penalty: 0,
            excess: 0,
        };
        prices.reprice(0);
        prices
    }

    fn goods(&mut self, kind: Kind) -> &mut Goods {
        match kind {
            Kind::Issue => &mut self.issue,
            Kind::Register => &mut self.registers,
        }
    }

    #[inline(always)]
    pub(super) fn index(&self, time: i32, lane: u16) -> usize {
        self.slots.slot(time) * self.lanes + usize::from(lane)
    }

    /// Begins a stage: sets the price of each use beyond what there is, and moves all prices on.
    pub(super) fn reprice(&mut self, penalty: i32) {
        self.penalty = penalty;
        for (goods, fall) in [(&mut self.issue, FALL), (&mut self.registers, 0)] {
            for at in 0..goods.used.len() {
                let history = &mut goods.history[at];
                match goods.used[at] > goods.room[at] {
                    true => *history = (*history + RISE).min(DEAREST as i16),
                    false => *history = (*history - fall).max(0),
                }
                goods.set(at, penalty);
            }
        }
    }

    /// Takes one more; returns its price.
    #[inline(always)]
    pub(super) fn take(&mut self, kind: Kind, time: i32, lane: u16) -> i32 {
        let (at, penalty) = (self.index(time, lane), self.penalty);
        let goods = self.goods(kind);
        let price = goods.price[at];
        goods.used[at] += 1;
        let over = goods.used[at] > goods.room[at];
        goods.set(at, penalty);
        self.excess += i64::from(over);
        i32::from(price)
    }

    /// Gives one back; returns its price.
    #[inline(always)]
    pub(super) fn give_back(&mut self, kind: Kind, time: i32, lane: u16) -> i32 {
        let (at, penalty) = (self.index(time, lane), self.penalty);
        let goods = self.goods(kind);
        let over = goods.used[at] > goods.room[at];
        goods.used[at] -= 1;
        goods.set(at, penalty);
        let price = goods.price[at];
        self.excess -= i64::from(over);
        i32::from(price)
    }

    pub(super) fn is_overused(&self, kind: Kind, time: i32, lane: u16) -> bool {
        let goods = match kind {
            Kind::Issue => &self.issue,
            Kind::Register => &self.registers,
        };
        let at = self.index(time, lane);
        goods.used[at] > goods.room[at]
    }

    /// Takes a register of a unit away for good, because they did not suffice as they were counted.
    pub(super) fn shrink(&mut self, lane: u16) {
        for slot in 0..self.registers.used.len() / self.lanes {
            let at = slot * self.lanes + usize::from(lane);
            let goods = &mut self.registers;
            if goods.room[at] > 1 {
                self.excess += i64::from(goods.used[at] >= goods.room[at]);
                goods.room[at] -= 1;
                goods.set(at, self.penalty);
            }
        }
    }

    /// Prices of issuing in a cycle, by lane.
    #[inline(always)]
    pub(super) fn issue_row(&self, time: i32) -> &[i16] {
        &self.issue.price[self.slots.slot(time) * self.lanes..][..self.lanes]
    }

    /// Prices of a register in a cycle, by lane.
    #[inline(always)]
    pub(super) fn register_row(&self, time: i32) -> &[i16] {
        &self.registers.price[self.slots.slot(time) * self.lanes..][..self.lanes]
    }

    /// The price of a register in a cycle.
    pub(super) fn register(&self, time: i32, lane: u16) -> i16 {
        self.registers.price[self.index(time, lane)]
    }
}
