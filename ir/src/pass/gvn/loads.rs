//! Values that loads would find, for they were loaded or stored before.

use crate::pass::alias::{Objects, Piece};
use crate::pass::guards::Guards;
use crate::pass::narrow::Narrow;
use crate::program::*;
use srp_archdesc::isa::{Effect, Opcode};

/// Accesses that are remembered at a time.
const MAX_KNOWN: usize = 128;

/// Stores under predicates that are looked through for the value under them.
const MAX_OVER: usize = 4;

/// Values known to be in memory at a point.
#[derive(Clone, Default)]
pub(super) struct Loads {
    known: Vec<Known>,
}

/// Where `guard` holds, an access has left `value` in memory, over which stores under predicates have gone since.
#[derive(Clone)]
struct Known {
    op: Opcode,
    guard: Value,
    piece: Piece,
    value: Value,
    /// The predicates of stores and what they have stored, the last one last.
    over: Vec<(Value, Value)>,
}

/// The value of a load.
pub(super) struct Held {
    value: Value,
    over: Vec<(Value, Value)>,
    /// The type that it takes the low bits of, and extends.
    narrow: Option<Narrow>,
    /// The load gives zero where this does not hold.
    under: Option<Value>,
}

impl Loads {
    /// Notes what an instruction does to memory; the value that it would load, if that is known.
    pub(super) fn see(
        &mut self,
        kind: &InstKind,
        result: Option<Value>,
        objects: &Objects,
        guards: &Guards,
    ) -> Option<Held> {
        let (op, args, imm) = match kind {
            InstKind::Op { op, args, imm } => (*op, args, *imm),
            _ => {
                self.known.clear();
                return None;
            }
        };
        let piece = args.get(1).and_then(|&base| Piece::of(op, base, imm));
        match (op.info().effect, piece) {
            // Where a texture is read is no sum of two operands.
            (Effect::Load, None) => {}
            (Effect::Load, Some(piece)) => {
                let of = |k| held(k, op, &piece, args[0], guards);
                if let Some(held) = self.known.iter().rev().find_map(of) {
                    return Some(held);
                }
                self.note(op, args[0], piece, result?);
            }
            (Effect::Store, Some(piece)) => {
                self.known.retain_mut(|k| {
                    let stays = k.piece == piece
                        && returns(op, k.op).is_some_and(|way| way.is_none())
                        && !guards.implies(k.guard, args[0])
                        && k.over.len() < MAX_OVER;
                    if stays {
                        k.over.push((args[0], args[2]));
                    }
                    stays || !k.piece.may_meet(&piece, objects)
                });
                self.note(op, args[0], piece, args[2]);
            }
            _ => self.known.clear(),
        }
        None
    }

    fn note(&mut self, op: Opcode, guard: Value, piece: Piece, value: Value) {
        if self.known.len() >= MAX_KNOWN {
            self.known.clear();
        }
        self.known.push(Known {
            op,
            guard,
            piece,
            value,
            over: Vec::new(),
        });
    }
}

/// The value that a load of a piece under a guard would give, if that follows from what is known.
fn held(k: &Known, op: Opcode, piece: &Piece, guard: Value, guards: &Guards) -> Option<Held> {
    if k.piece != *piece || !guards.implies(guard, k.guard) {
        return None;
    }
    let is_loaded = k.op == op;
    let narrow = returns(k.op, op)?;
    // Nothing that was stored before the last store that surely was made is left.
    let surely = |&(under, _): &(Value, Value)| guards.implies(guard, under);
    let (value, over) = match k.over.iter().rposition(surely) {
        Some(last) => (k.over[last].1, &k.over[last + 1..]),
        None => (k.value, &k.over[..]),
    };
    let is_same = is_loaded && k.over.is_empty() && k.guard == guard;
    Some(Held {
        value,
        over: over.to_vec(),
        narrow,
        under: (!is_same && !guards.is_true(guard)).then_some(guard),
    })
}

/// The type whose low bits of what a store or load was of a load of the same bytes extends, where it does not take it
/// whole; `None` where it takes something else.
pub(in crate::pass) fn returns(from: Opcode, load: Opcode) -> Option<Option<Narrow>> {
    use Opcode::*;
    match (from, load) {
        _ if from == load => Some(None),
        (Sw, Lw) | (Sv, Lv) | (Gsw, Glw) | (Gsv, Glv) => Some(None),
        (Sb, Lbu | Lb) | (Gsb, Glbu | Glb) | (Sh, Lhu | Lh) | (Gsh, Glhu | Glh) => {
            Some(Narrow::loaded(load))
        }
        _ => None,
    }
}

impl Held {
    /// The instructions that compute it in the place of a load, and the value.
    pub(super) fn build(self, func: &mut Function, load: Inst) -> (Vec<Inst>, Value) {
        let InstData { results, pos, .. } = &func.insts[load];
        let (pos, ty) = (*pos, func.values[results[0]]);
        let mut steps = Vec::new();
        let make = |func: &mut Function, kind: InstKind, steps: &mut Vec<Inst>| {
            let inst = func.make_inst(kind, &[ty], pos);
            steps.push(inst);
            func.insts[inst].results[0]
        };
        let of = |op, args| InstKind::Op { op, args, imm: 0 };
        let mut value = self.value;
        for (under, stored) in self.over {
            let kind = of(Opcode::select(ty), vec![under, stored, value]);
            value = make(func, kind, &mut steps);
        }
        if let Some(narrow) = self.narrow {
            let (extension, extended) = narrow.extend(func, value, pos);
            steps.extend(extension);
            value = extended;
        }
        if let Some(under) = self.under {
            let zero = make(func, InstKind::Const(Bits::zero(ty)), &mut steps);
            let kind = of(Opcode::select(ty), vec![under, value, zero]);
            value = make(func, kind, &mut steps);
        }
        (steps, value)
    }
}
