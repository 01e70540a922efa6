//! The stores to the slots of a function before its passes, and their order.

use srp_archdesc::isa::Effect;
use srp_ir::flow::Flow;
use srp_ir::program::{
    Bits, Block, Function, Inst, InstData, InstKind, Pos, Slot, Terminator, Value,
};
use std::collections::{BTreeMap, BTreeSet};

pub(crate) fn insts(function: &Function) -> impl Iterator<Item = Inst> + '_ {
    let blocks = function.layout.iter();
    blocks.flat_map(|&block| function.blocks[block].insts.iter().copied())
}

/// A store of a whole slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Store {
    pub(crate) value: Value,
    block: Block,
    /// Its number in the block.
    number: usize,
}

/// The stores to the slots of a function.
pub(crate) struct Stored<'a> {
    function: &'a Function,
    /// The slots that get a value, itself or as a copy.
    pub(crate) slots: BTreeMap<Value, Vec<Slot>>,
    /// The stores to each slot.
    pub(crate) stores: BTreeMap<Slot, Vec<Store>>,
    /// Slots that are reached otherwise than by loads and stores of their own.
    pub(crate) escaped: BTreeSet<Slot>,
    pub(crate) constants: BTreeMap<Value, Bits>,
    made_by: BTreeMap<Value, Inst>,
    addresses: BTreeMap<Value, Slot>,
    flow: Flow,
}

impl<'a> Stored<'a> {
    pub(crate) fn of(function: &'a Function) -> Stored<'a> {
        let mut stored = Stored {
            function,
            slots: BTreeMap::new(),
            stores: BTreeMap::new(),
            escaped: BTreeSet::new(),
            constants: BTreeMap::new(),
            made_by: BTreeMap::new(),
            addresses: BTreeMap::new(),
            flow: Flow::of(function),
        };
        for inst in insts(function) {
            stored.add(inst);
        }
        for &block in &function.layout {
            stored.walk(block);
        }
        stored
    }

    fn add(&mut self, inst: Inst) {
        let data = &self.function.insts[inst];
        for &value in &data.results {
            self.made_by.insert(value, inst);
            match data.kind {
                InstKind::SlotAddr(slot, _) => {
                    self.addresses.insert(value, slot);
                }
                InstKind::Const(bits) => {
                    self.constants.insert(value, bits);
                }
                _ => {}
            }
        }
    }

    fn walk(&mut self, block: Block) {
        // What is in a slot, as long as the block goes on.
        let mut held: BTreeMap<Slot, Value> = BTreeMap::new();
        let mut copies: BTreeMap<Value, Value> = BTreeMap::new();
        let data = &self.function.blocks[block];
        for (number, &inst) in data.insts.iter().enumerate() {
            let data = &self.function.insts[inst];
            match (self.accessed(data), data.results.first()) {
                (Some((slot, Some(value))), _) => {
                    // A copy on another line comes later than the operation.
                    let copied = copies.get(&value).copied();
                    let value = copied
                        .filter(|&of| self.line(of) == Some(data.pos.line))
                        .unwrap_or(value);
                    self.store(
                        slot,
                        Store {
                            value,
                            block,
                            number,
                        },
                    );
                    held.insert(slot, value);
                }
                (Some((slot, None)), Some(&result)) => {
                    copies.extend(held.get(&slot).map(|&value| (result, value)));
                }
                _ => data
                    .kind
                    .for_each_use(|value| self.escaped.extend(self.addresses.get(&value))),
            }
        }
        data.end
            .for_each_use(|value| self.escaped.extend(self.addresses.get(&value)));
    }

    /// The slot that an instruction loads or stores as a whole, and what it stores.
    fn accessed(&self, data: &InstData) -> Option<(Slot, Option<Value>)> {
        let InstKind::Op { op, args, imm: 0 } = &data.kind else {
            return None;
        };
        op.access_bytes()?;
        let slot = *self.addresses.get(args.get(1)?)?;
        match op.info().effect {
            Effect::Store => Some((slot, Some(*args.get(2)?))),
            _ => Some((slot, None)),
        }
    }

    fn store(&mut self, slot: Slot, store: Store) {
        let slots = self.slots.entry(store.value).or_default();
        if !slots.contains(&slot) {
            slots.push(slot);
        }
        self.stores.entry(slot).or_default().push(store);
        self.escaped.extend(self.addresses.get(&store.value));
    }

    fn line(&self, value: Value) -> Option<u32> {
        let inst = *self.made_by.get(&value)?;
        Some(self.function.insts[inst].pos.line)
    }

    /// The one constant that a slot ever gets.
    pub(crate) fn constant(&self, slot: Slot) -> Option<Bits> {
        let constants = self.stores.get(&slot)?.iter();
        let constants: BTreeSet<Option<Bits>> = constants
            .map(|store| self.constants.get(&store.value).copied())
            .collect();
        let one = *constants.first()?;
        one.filter(|_| constants.len() == 1 && !self.escaped.contains(&slot))
    }

    /// The place of the operation that makes the value of a store.
    pub(crate) fn maker(&self, store: &Store) -> Option<Pos> {
        let data = &self.function.insts[*self.made_by.get(&store.value)?];
        let is_operation = matches!(data.kind, InstKind::Op { .. });
        let is_load = self.accessed(data).is_some();
        (is_operation && !is_load && data.pos.line > 0).then_some(data.pos)
    }

    /// True if no other store is in the innermost loop, or outside of loops where it is in none.
    pub(crate) fn is_alone(&self, store: &Store, all: &[Store]) -> bool {
        let is_beside = |other: &Store| match self.flow.loops.innermost(store.block) {
            Some(of) => self.flow.loops.loops[of].contains(other.block),
            None => self.flow.loops.innermost(other.block).is_none(),
        };
        // Constants and copies outside of loops are judged by whether they come first.
        let is_judged = |other: &&Store| {
            self.flow.loops.innermost(store.block).is_some() || self.maker(other).is_some()
        };
        let beside = all
            .iter()
            .filter(is_judged)
            .filter(|other| is_beside(other));
        beside.count() == 1
    }

    /// True if an iteration of the innermost loop, or a call where there is none, need not come to a store.
    pub(crate) fn is_conditional(&self, store: &Store) -> bool {
        let always = |block: Block| self.flow.dominators.dominates(store.block, block);
        let Some(of) = self.flow.loops.innermost(store.block) else {
            let blocks = self.function.layout.iter().copied();
            let ends = |&block: &Block| {
                self.flow.cfg.is_reached(block)
                    && matches!(self.function.blocks[block].end, Terminator::Return(_))
            };
            return !blocks.filter(ends).all(always);
        };
        let data = &self.flow.loops.loops[of];
        let ways_out = data.exits(self.function).count();
        ways_out > 1 || !data.latches.iter().all(|&latch| always(latch))
    }

    /// True if the value comes from what is in the slot.
    pub(crate) fn reads(&self, value: Value, slot: Slot) -> bool {
        let (mut seen, mut open) = (BTreeSet::new(), vec![value]);
        while let Some(value) = open.pop() {
            let Some(&inst) = self.made_by.get(&value).filter(|_| seen.insert(value)) else {
                continue;
            };
            let data = &self.function.insts[inst];
            match self.accessed(data) {
                Some((of, None)) if of == slot => return true,
                Some(_) => {}
                None => data.kind.for_each_use(|value| open.push(value)),
            }
        }
        false
    }

    pub(crate) fn is_in_loop(&self, store: &Store) -> bool {
        self.flow.loops.innermost(store.block).is_some()
    }

    /// The place of the innermost loop, where it may run on the array.
    pub(crate) fn loop_of(&self, store: &Store) -> Option<Pos> {
        let header = self.flow.loops.loops[self.flow.loops.innermost(store.block)?].header;
        let mark = self.function.blocks[header].kernel.as_ref();
        mark.map(|mark| mark.pos)
    }

    /// True if a store is in no loop and before all others.
    pub(crate) fn comes_first(&self, store: &Store, all: &[Store]) -> bool {
        let is_before = |other: &Store| match store.block == other.block {
            true => store.number <= other.number,
            false => self.flow.dominators.dominates(store.block, other.block),
        };
        self.flow.loops.innermost(store.block).is_none() && all.iter().all(is_before)
    }
}
