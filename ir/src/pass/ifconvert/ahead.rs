//! Loads that do not wait for the way out.
//!
//! In a loop of [chunks](super::exits) every access is under the predicate that the loop is still alive, so
//! that a test of what was loaded decides on the next load: an iteration waits for the whole of the one before. A load
//! from a known object need not wait, if it is made only where it lies within the object: what it gives after the loop
//! was left is never used. The predicate of such a load is then a comparison of its address, which no iteration waits
//! for.
//!
//! Pointers stay in their objects (C17 6.5.6), so a load that counts is within one.

use crate::flow::LoopData;
use crate::pass::alias::{Object, Objects};
use crate::pass::defs::Defs;
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Effect, Opcode, Space, Ty};

/// How far definitions are followed for the alignment of an address.
const MAX_DEPTH: u32 = 24;

/// Bits of the largest alignment that matters.
const MOST_ALIGNED: u32 = 4;

/// A load that can be made in any iteration of a chunk.
struct Load {
    object: Object,
    address: Value,
    imm: i32,
    /// The last byte of the object at which the access may begin.
    last: u32,
}

/// The instructions of a loop that need not wait for the way out, in an order in which they can be computed.
pub(super) struct Ahead {
    insts: Vec<(Block, Inst)>,
    loads: FxHashMap<Inst, Load>,
}

impl Ahead {
    /// Of a loop whose header gets the values of an iteration as its parameters.
    pub(super) fn of(
        func: &Function,
        globals: &EntityMap<Global, GlobalData>,
        data: &LoopData,
    ) -> Ahead {
        let objects = Objects::of(func);
        let sizes = Sizes::of(func, globals);
        let mut known: FxHashSet<Value> = func.blocks[data.header].params.iter().copied().collect();
        let inside = inside(func, data);
        let mut ahead = Ahead {
            insts: Vec::new(),
            loads: FxHashMap::default(),
        };
        // A load behind a store of the same iteration may read what that stores.
        let mut stored = false;
        for &block in &data.blocks {
            for &inst in &func.blocks[block].insts {
                let InstData { kind, results, .. } = &func.insts[inst];
                let mut computed = true;
                kind.for_each_use(|v| computed &= known.contains(&v) || !inside.contains(&v));
                let InstKind::Op { op, args, imm } = kind else {
                    let constant = !matches!(kind, InstKind::Call { .. } | InstKind::Launch { .. });
                    if constant && computed {
                        ahead.insts.push((block, inst));
                        known.extend(results);
                    }
                    continue;
                };
                stored |= op.info().effect == Effect::Store;
                let load = match op.is_guarded() {
                    false if op.is_pure() => None,
                    true if !stored && op.info().effect == Effect::Load => {
                        match sizes.load(*op, args, *imm, &objects) {
                            Some(load) => Some(load),
                            None => continue,
                        }
                    }
                    _ => continue,
                };
                if computed {
                    known.extend(results);
                    ahead.insts.push((block, inst));
                    ahead.loads.extend(load.map(|load| (inst, load)));
                }
            }
        }
        ahead
    }

    /// Cycles of a common machine from the predicate that a loop is alive to the same in the next iteration, by the
    /// accesses that wait for it.
    pub(super) fn wait(&self, func: &Function, data: &LoopData) -> u32 {
        let early: FxHashSet<Inst> = self.insts.iter().map(|&(_, inst)| inst).collect();
        let stores = data
            .blocks
            .iter()
            .flat_map(|&block| &func.blocks[block].insts);
        let stores = stores
            .filter(|&&inst| effect(func, inst) == Some(Effect::Store))
            .count();
        let mut depth = FxHashMap::<Value, u32>::default();
        let mut longest = 0;
        for &block in &data.blocks {
            for &inst in &func.blocks[block].insts {
                let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
                    continue;
                };
                // Where the loop stores, a load may have to wait for that.
                let waits = op.is_guarded() && (stores > 0 || !early.contains(&inst));
                let from = args.iter().filter_map(|arg| depth.get(arg)).max().copied();
                let from = from.max(waits.then_some(1));
                if let (Some(from), Some(&result)) = (from, func.insts[inst].results.first()) {
                    depth.insert(result, from + latency(*op));
                }
            }
            let end = &func.blocks[block].end;
            if let Terminator::Branch { cond, .. } = end
                && data.is_left_at(func, block)
            {
                longest = longest.max(depth.get(cond).map_or(0, |depth| depth + 2));
            }
            for target in end.targets().filter(|t| t.block != data.header) {
                for (&param, arg) in func.blocks[target.block].params.iter().zip(&target.args) {
                    if let Some(&from) = depth.get(arg) {
                        let known = depth.entry(param).or_default();
                        *known = (*known).max(from + 1);
                    }
                }
            }
        }
        longest
    }

    /// Moves the instructions to the end of a block that runs in every iteration, loads under the predicate that they lie
    /// in their object.
    pub(super) fn move_to(self, func: &mut Function, to: Block) {
        let mut moved = FxHashSet::default();
        for (_, inst) in &self.insts {
            if let Some(load) = self.loads.get(inst) {
                let pos = func.insts[*inst].pos;
                let kind = match load.object {
                    Object::Symbol(symbol) => InstKind::SymbolAddr(symbol, load.imm.wrapping_neg()),
                    Object::Slot(slot) => InstKind::SlotAddr(slot, load.imm.wrapping_neg()),
                };
                let start = func.append(to, kind, &[Ty::Word], pos);
                let start = func.insts[start].results[0];
                let size = func.append_const(to, Bits::Word(load.last), pos);
                let mut op = |op, args: &[Value]| {
                    let made = func.append_op(to, op, args, 0, pos);
                    made.expect("it has a result")
                };
                let offset = op(Opcode::Sub, &[load.address, start]);
                let within = op(Opcode::Leu, &[offset, size]);
                let InstKind::Op { args, .. } = &func.insts[*inst].kind else {
                    continue;
                };
                let own = args[0];
                let both = func.append_op(to, Opcode::Pand, &[within, own], 0, pos);
                if let InstKind::Op { args, .. } = &mut func.insts[*inst].kind {
                    args[0] = both.expect("it has a result");
                }
            }
            func.blocks[to].insts.push(*inst);
            moved.insert(*inst);
        }
        let from: FxHashSet<Block> = self.insts.iter().map(|&(block, _)| block).collect();
        for block in from {
            func.blocks[block]
                .insts
                .retain(|inst| !moved.contains(inst));
        }
    }
}

fn effect(func: &Function, inst: Inst) -> Option<Effect> {
    match &func.insts[inst].kind {
        InstKind::Op { op, .. } => Some(op.info().effect),
        _ => None,
    }
}

/// Cycles of an operation on a common machine.
pub(super) fn latency(op: Opcode) -> u32 {
    match op.class() {
        Class::Fadd | Class::Fmul | Class::Vfadd | Class::Vfmul | Class::Load => 3,
        Class::Pair | Class::Vpair => 3,
        Class::Fma | Class::Vfma | Class::Cload => 4,
        Class::Imul | Class::Vmul | Class::Cvt => 2,
        Class::Vdot => 6,
        Class::Sfu | Class::Fast => 8,
        Class::Fdiv | Class::Idiv | Class::Tex => 12,
        _ => 1,
    }
}

/// The values that a loop computes.
fn inside(func: &Function, data: &LoopData) -> FxHashSet<Value> {
    let blocks = || data.blocks.iter().map(|&block| &func.blocks[block]);
    let params = blocks().flat_map(|block| block.params.iter().copied());
    let insts = blocks().flat_map(|block| &block.insts);
    params
        .chain(insts.flat_map(|&inst| func.insts[inst].results.iter().copied()))
        .collect()
}

/// Sizes and alignments of what addresses point into.
struct Sizes<'a> {
    func: &'a Function,
    globals: &'a EntityMap<Global, GlobalData>,
    defs: Defs,
    /// The values that jumps bring to the parameters of blocks.
    brought: FxHashMap<Value, Vec<Value>>,
}

impl<'a> Sizes<'a> {
    fn of(func: &'a Function, globals: &'a EntityMap<Global, GlobalData>) -> Sizes<'a> {
        let mut brought = FxHashMap::<Value, Vec<Value>>::default();
        for block in func.layout.iter().map(|&block| &func.blocks[block]) {
            for target in block.end.targets() {
                let params = &func.blocks[target.block].params;
                for (&param, &arg) in params.iter().zip(&target.args) {
                    brought.entry(param).or_default().push(arg);
                }
            }
        }
        // The function's own parameters also come from its callers.
        for param in &func.blocks[func.entry()].params {
            brought.remove(param);
        }
        Sizes {
            func,
            globals,
            defs: Defs::of(func),
            brought,
        }
    }

    /// A load from a known object, whose address is aligned wherever it lies.
    fn load(&self, op: Opcode, args: &[Value], imm: i32, objects: &Objects) -> Option<Load> {
        let bytes = op.access_bytes()?;
        let &[_, address] = args else {
            return None;
        };
        if op.space() != Some(Space::Sram) {
            return None;
        }
        let object = objects.object(address)?;
        let (size, _) = self.extent(object)?;
        let aligned = self
            .alignment(address, MAX_DEPTH)?
            .min(trailing(imm as u32));
        (aligned >= bytes.trailing_zeros() && size >= bytes).then_some(Load {
            object,
            address,
            imm,
            last: size - bytes,
        })
    }

    /// Size and alignment of an object.
    fn extent(&self, object: Object) -> Option<(u32, u32)> {
        match object {
            Object::Symbol(Symbol::Global(global)) => {
                let data = &self.globals[global];
                Some((data.size, data.align))
            }
            Object::Symbol(Symbol::Func(_)) => None,
            Object::Slot(slot) => {
                let data = &self.func.slots[slot];
                Some((data.size, data.align))
            }
        }
    }

    /// How many low bits of a value are certainly 0; `None` where it depends only on itself.
    fn alignment(&self, value: Value, depth: u32) -> Option<u32> {
        self.follow(value, depth, &mut Vec::new())
            .or(Some(MOST_ALIGNED))
    }

    fn follow(&self, value: Value, depth: u32, open: &mut Vec<Value>) -> Option<u32> {
        if open.contains(&value) {
            return None;
        }
        if depth == 0 {
            return Some(0);
        }
        open.push(value);
        let least = |values: &[Value], open: &mut Vec<Value>| {
            let each = values.iter().map(|&v| self.follow(v, depth - 1, open));
            each.fold(None, |least: Option<u32>, bits| match (least, bits) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            })
        };
        let bits = match self.definition(value) {
            Definition::Unknown => Some(0),
            Definition::Brought(values) => least(values, open),
            Definition::Made(InstKind::Const(Bits::Word(word))) => Some(trailing(*word)),
            Definition::Made(InstKind::SymbolAddr(symbol, offset)) => {
                let align = self
                    .extent(Object::Symbol(*symbol))
                    .map_or(1, |(_, align)| align);
                Some(trailing(align).min(trailing(*offset as u32)))
            }
            Definition::Made(InstKind::SlotAddr(slot, offset)) => {
                let align = self.func.slots[*slot].align;
                Some(trailing(align).min(trailing(*offset as u32)))
            }
            Definition::Made(InstKind::Op { op, args, .. }) => match op {
                Opcode::Add | Opcode::Sub | Opcode::Or => least(args, open),
                Opcode::Mov => least(&args[..1], open),
                Opcode::Sel => least(&args[1..], open),
                Opcode::Shl => {
                    let by = self.constant(args[1]).unwrap_or(0).min(MOST_ALIGNED);
                    let own = self.follow(args[0], depth - 1, open);
                    own.map(|bits| (bits + by).min(MOST_ALIGNED))
                }
                Opcode::Mul => {
                    let bits = |v: Value| self.constant(v).map_or(0, trailing);
                    Some(bits(args[0]).max(bits(args[1])))
                }
                _ => Some(0),
            },
            Definition::Made(_) => Some(0),
        };
        open.pop();
        bits
    }

    fn constant(&self, value: Value) -> Option<u32> {
        self.defs.word(self.func, value)
    }

    fn definition(&self, value: Value) -> Definition<'_> {
        if let Some(kind) = self.defs.kind(self.func, value) {
            return Definition::Made(kind);
        }
        match self.brought.get(&value) {
            Some(values) => Definition::Brought(values),
            None => Definition::Unknown,
        }
    }
}

/// Where a value comes from.
enum Definition<'a> {
    Made(&'a InstKind),
    Brought(&'a [Value]),
    Unknown,
}

/// Low bits that are 0, as far as they matter.
fn trailing(word: u32) -> u32 {
    word.trailing_zeros().min(MOST_ALIGNED)
}
