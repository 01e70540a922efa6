//! Cells to values: where they meet they become block parameters (Cytron et al. 1991).

use super::{Access, Cell};
use crate::flow::{Cfg, Dominators};
use crate::pass::narrow::Narrow;
use crate::pass::rename::Renames;
use crate::program::*;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Effect, Opcode, Ty};
use std::collections::BTreeMap;

/// Replaces the accesses by values.
pub(super) fn promote(
    func: &mut Function,
    accesses: &BTreeMap<Inst, Access>,
    cells: &EntityMap<Cell, Ty>,
) {
    let cfg = Cfg::of(func);
    let dominators = Dominators::of(&cfg);
    let meetings = place_params(func, &cfg, &dominators, accesses, cells);
    let truths = truths(func);
    let mut promoter = Promoter {
        func,
        accesses,
        cells,
        meetings,
        current: EntityMap::filled(cells.len(), None),
        undo: Vec::new(),
        renames: Renames::default(),
        zeros: Vec::new(),
        truths,
    };
    promoter.walk(&dominators);
    let Promoter {
        mut renames, zeros, ..
    } = promoter;
    let entry = func.entry();
    let zeros = zeros.into_iter().map(|(_, inst)| inst);
    func.blocks[entry].insts.splice(0..0, zeros);
    renames.apply(func);
}

/// The parameters that each block gets for cells, in order.
type Meetings = EntityMap<Block, Vec<(Cell, Value)>>;

/// True if an access needs the value before it: anything but a store to all of a cell.
fn reads(kind: &InstKind, access: Access, is_true: impl Fn(Value) -> bool) -> bool {
    match kind {
        InstKind::Op { op, args, .. } if op.info().effect == Effect::Store => {
            access.lane.is_some() || !is_true(args[0])
        }
        _ => true,
    }
}

/// Adds a parameter for a cell to every block where different values of it meet and one is needed.
fn place_params(
    func: &mut Function,
    cfg: &Cfg,
    dominators: &Dominators,
    accesses: &BTreeMap<Inst, Access>,
    cells: &EntityMap<Cell, Ty>,
) -> Meetings {
    let truths = truths(func);
    let is_true = |value: Value| truths.get(value.index()) == Some(&true);
    let mut writes = EntityMap::<Cell, Vec<Block>>::filled(cells.len(), Vec::new());
    let mut needs = EntityMap::<Cell, Vec<Block>>::filled(cells.len(), Vec::new());
    let mut kills = EntityMap::<Cell, Vec<Block>>::filled(cells.len(), Vec::new());
    for &block in &cfg.order {
        for inst in &func.blocks[block].insts {
            let Some(&access) = accesses.get(inst) else {
                continue;
            };
            let cell = access.cell;
            let kind = &func.insts[*inst].kind;
            if reads(kind, access, is_true) {
                if kills[cell].last() != Some(&block) && needs[cell].last() != Some(&block) {
                    needs[cell].push(block);
                }
            } else if kills[cell].last() != Some(&block) {
                kills[cell].push(block);
            }
            if func.insts[*inst].results.is_empty() && writes[cell].last() != Some(&block) {
                writes[cell].push(block);
            }
        }
    }
    let frontiers = frontiers(cfg, dominators);
    let mut meetings = Meetings::filled(func.blocks.len(), Vec::new());
    let mut live = Marks::new(func.blocks.len());
    let mut placed = Marks::new(func.blocks.len());
    for (cell, &ty) in cells.iter() {
        live.clear();
        placed.clear();
        mark_live(cfg, &needs[cell], &kills[cell], &mut live);
        let mut work = writes[cell].clone();
        while let Some(block) = work.pop() {
            for &meeting in &frontiers[block] {
                if live.has(meeting) && placed.set(meeting) {
                    let param = func.add_param(meeting, ty);
                    meetings[meeting].push((cell, param));
                    work.push(meeting);
                }
            }
        }
    }
    meetings
}

/// Marks the blocks at whose start a cell's value is needed.
fn mark_live(cfg: &Cfg, needs: &[Block], kills: &[Block], live: &mut Marks) {
    let kills: rustc_hash::FxHashSet<Block> = kills.iter().copied().collect();
    let mut work = needs.to_vec();
    while let Some(block) = work.pop() {
        if live.set(block) {
            let preds = cfg.preds[block].iter().copied();
            work.extend(preds.filter(|pred| !kills.contains(pred)));
        }
    }
}

/// A set of blocks that is emptied in no time.
struct Marks {
    round: u32,
    marked: EntityMap<Block, u32>,
}

impl Marks {
    fn new(blocks: usize) -> Marks {
        Marks {
            round: 0,
            marked: EntityMap::filled(blocks, 0),
        }
    }

    fn clear(&mut self) {
        self.round += 1;
    }

    fn has(&self, block: Block) -> bool {
        self.marked[block] == self.round
    }

    /// Adds a block; true if it was not there before.
    fn set(&mut self, block: Block) -> bool {
        std::mem::replace(&mut self.marked[block], self.round) != self.round
    }
}

/// For each block those where its dominance ends.
fn frontiers(cfg: &Cfg, dominators: &Dominators) -> EntityMap<Block, Vec<Block>> {
    let mut frontiers = EntityMap::<Block, Vec<Block>>::filled(cfg.preds.len(), Vec::new());
    for &block in &cfg.order {
        if cfg.preds[block].len() < 2 {
            continue;
        }
        let parent = dominators.parent(block);
        for &pred in &cfg.preds[block] {
            let mut runner = Some(pred);
            while let Some(at) = runner.filter(|_| runner != parent) {
                if frontiers[at].last() != Some(&block) {
                    frontiers[at].push(block);
                }
                runner = dominators.parent(at);
            }
        }
    }
    frontiers
}

/// Which values are the constant *true*, by index.
fn truths(func: &Function) -> Vec<bool> {
    let mut truths = vec![false; func.values.len()];
    for &block in &func.layout {
        for &inst in &func.blocks[block].insts {
            if func.insts[inst].kind == InstKind::Const(Bits::Pred(true)) {
                truths[func.insts[inst].results[0].index()] = true;
            }
        }
    }
    truths
}

/// The walk that gives each access its value.
struct Promoter<'a> {
    func: &'a mut Function,
    accesses: &'a BTreeMap<Inst, Access>,
    cells: &'a EntityMap<Cell, Ty>,
    meetings: Meetings,
    /// The value of each cell here.
    current: EntityMap<Cell, Option<Value>>,
    /// Previous values in `current`, newest last.
    undo: Vec<(Cell, Option<Value>)>,
    renames: Renames,
    /// Zeros of the types that are needed, for the start of the function.
    zeros: Vec<(Ty, Inst)>,
    truths: Vec<bool>,
}

impl Promoter<'_> {
    fn walk(&mut self, dominators: &Dominators) {
        let entry = self.func.entry();
        let mut stack = vec![(entry, 0, self.undo.len())];
        self.block(entry);
        while let Some((block, next, mark)) = stack.last_mut() {
            match dominators.children(*block).get(*next) {
                Some(&child) => {
                    *next += 1;
                    stack.push((child, 0, self.undo.len()));
                    self.block(child);
                }
                None => {
                    for (cell, value) in self.undo.drain(*mark..).rev() {
                        self.current[cell] = value;
                    }
                    stack.pop();
                }
            }
        }
    }

    fn set(&mut self, cell: Cell, value: Value) {
        self.undo.push((cell, self.current[cell]));
        self.current[cell] = Some(value);
    }

    /// The value of a cell here.
    fn get(&mut self, cell: Cell) -> Value {
        match self.current[cell] {
            Some(value) => value,
            None => self.zero(self.cells[cell]),
        }
    }

    fn zero(&mut self, ty: Ty) -> Value {
        let made = self.zeros.iter().find(|&&(of, _)| of == ty);
        let inst = match made {
            Some(&(_, inst)) => inst,
            None => {
                let kind = InstKind::Const(Bits::zero(ty));
                let inst = self.func.make_inst(kind, &[ty], Pos::nowhere());
                self.zeros.push((ty, inst));
                inst
            }
        };
        self.func.insts[inst].results[0]
    }

    fn block(&mut self, block: Block) {
        for i in 0..self.meetings[block].len() {
            let (cell, param) = self.meetings[block][i];
            self.set(cell, param);
        }
        let mut kept = Vec::new();
        for inst in std::mem::take(&mut self.func.blocks[block].insts) {
            match self.accesses.get(&inst) {
                None => kept.push(inst),
                Some(&access) => {
                    let mut place = Place {
                        insts: &mut kept,
                        pos: self.func.insts[inst].pos,
                    };
                    self.access(inst, access, &mut place);
                }
            }
        }
        self.func.blocks[block].insts = kept;
        let mut end = self.func.blocks[block].end.clone();
        for target in end.targets_mut() {
            for i in 0..self.meetings[target.block].len() {
                let (cell, _) = self.meetings[target.block][i];
                target.args.push(self.get(cell));
            }
        }
        self.func.blocks[block].end = end;
    }

    fn access(&mut self, inst: Inst, access: Access, place: &mut Place<'_>) {
        let InstKind::Op { op, args, .. } = self.func.insts[inst].kind.clone() else {
            unreachable!("accesses are loads and stores")
        };
        let guard = args[0];
        let guarded = !self.truths.get(guard.index()).copied().unwrap_or(false);
        if op.info().effect == Effect::Store {
            let mut value = args[2];
            if let Some(lane) = access.lane {
                let whole = self.get(access.cell);
                value = self.op(place, Opcode::Vins, &[whole, value], lane);
            }
            if guarded {
                let old = self.get(access.cell);
                let select = Opcode::select(self.cells[access.cell]);
                value = self.op(place, select, &[guard, value, old], 0);
            }
            return self.set(access.cell, value);
        }
        let mut value = self.get(access.cell);
        if let Some(lane) = access.lane {
            value = self.op(place, Opcode::Vext, &[value], lane);
        }
        if let Some(narrow) = Narrow::loaded(op) {
            let (insts, extended) = narrow.extend(self.func, value, place.pos);
            place.insts.extend(insts);
            value = extended;
        }
        if guarded {
            let ty = op.result().expect("loads have a result");
            let zero = self.zero(ty);
            value = self.op(place, Opcode::select(ty), &[guard, value, zero], 0);
        }
        let result = self.func.insts[inst].results[0];
        let value = self.renames.find(value);
        self.renames.replace(result, value);
    }

    fn op(&mut self, place: &mut Place<'_>, op: Opcode, args: &[Value], imm: u32) -> Value {
        let kind = InstKind::Op {
            op,
            args: args.to_vec(),
            imm: imm as i32,
        };
        self.make(place, kind, op.result().as_slice())
    }

    fn make(&mut self, place: &mut Place<'_>, kind: InstKind, tys: &[Ty]) -> Value {
        let inst = self.func.make_inst(kind, tys, place.pos);
        place.insts.push(inst);
        self.func.insts[inst].results[0]
    }
}

/// Where new instructions go.
struct Place<'a> {
    insts: &'a mut Vec<Inst>,
    pos: Pos,
}
