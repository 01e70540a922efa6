//! Which object each address of a function points into.
//!
//! Pointer arithmetic stays inside the object that it starts from (C17 6.5.6), so the address of a
//! global plus anything points into that global.

use super::{restrict_number, restrict_pointers_stay};
use crate::flow::Cfg;
use crate::program::{Block, Function, InstData, InstKind, Slot, Symbol, Value};
use rustc_hash::FxHashMap;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Effect, Opcode, Space};

/// Rounds after which a value that still changes counts as unknown.
const MAX_ROUNDS: usize = 24;

/// An object with an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Object {
    /// A global, or a function.
    Symbol(Symbol),
    /// A stack slot.
    Slot(Slot),
}

/// Something with bytes that are no bytes of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Object(Object),
    /// That of the `restrict` pointer of this number, in its scope.
    Restrict(u32),
}

/// The target of a word used as an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Points {
    /// Not known yet.
    Open,
    /// A number.
    Number,
    /// Somewhere into an object.
    Into(Target),
    /// A number, or an address that the function was given or has loaded and that is based on no `restrict` pointer of the scope.
    Given,
    /// A number or any address.
    Unknown,
    /// One of several of these.
    Several,
    /// That, or a distance from one object to another.
    Across,
}

impl Points {
    fn or(self, other: Points) -> Points {
        match (self, other) {
            (Points::Open, x) | (x, Points::Open) => x,
            (a, b) if a == b => a,
            (Points::Across, _) | (_, Points::Across) => Points::Across,
            (Points::Given, Points::Number) | (Points::Number, Points::Given) => Points::Given,
            (a, b) if a.is_open_to_all() && b.is_open_to_all() => Points::Unknown,
            _ => Points::Several,
        }
    }

    fn plus(self, other: Points) -> Points {
        match (self, other) {
            (Points::Across, _) | (_, Points::Across) => Points::Across,
            (Points::Open, x) | (x, Points::Open) => x,
            (Points::Number, Points::Number) => Points::Number,
            (Points::Into(_), Points::Into(_)) => Points::Several,
            (Points::Several, _) | (_, Points::Several) => Points::Several,
            (Points::Into(object), _) | (_, Points::Into(object)) => Points::Into(object),
            (Points::Unknown, _) | (_, Points::Unknown) => Points::Unknown,
            _ => Points::Given,
        }
    }

    /// True for what may be a number as well as an address.
    fn is_open_to_all(self) -> bool {
        matches!(self, Points::Number | Points::Given | Points::Unknown)
    }
}

/// The objects of all addresses of a function; by default, nothing is known of any.
#[derive(Default)]
pub struct Objects {
    points: EntityMap<Value, Points>,
}

impl Objects {
    /// The objects of the addresses, wherever they are used.
    pub fn of(func: &Function) -> Objects {
        Objects::in_scope(func, &[])
    }

    /// The objects of the addresses in the scope of some `restrict` pointers, by their numbers: the least
    /// solution of the definitions.
    fn in_scope(func: &Function, restrict: &[u32]) -> Objects {
        let cfg = Cfg::of(func);
        let mut points = EntityMap::filled(func.values.len(), Points::Open);
        for &param in &func.blocks[func.entry()].params {
            points[param] = Points::Given;
        }
        let loaded = match restrict.is_empty() || restrict_pointers_stay(func) {
            true => Points::Given,
            false => Points::Unknown,
        };
        for round in 0.. {
            let mut changed = false;
            let mut set = |points: &mut EntityMap<Value, Points>, value: Value, now: Points| {
                if points[value] != now {
                    let settled = round < MAX_ROUNDS;
                    points[value] = if settled { now } else { Points::Across };
                    changed = true;
                }
            };
            for &block in &cfg.order {
                for &inst in &func.blocks[block].insts {
                    let InstData { kind, results, .. } = &func.insts[inst];
                    let number = restrict_number(kind).filter(|n| restrict.contains(n));
                    let now = match number {
                        Some(number) => Points::Into(Target::Restrict(number)),
                        None => of_inst(kind, &points, loaded),
                    };
                    for &result in results {
                        let now = points[result].or(now);
                        set(&mut points, result, now);
                    }
                }
                for target in func.blocks[block].end.targets() {
                    for (&param, &arg) in func.blocks[target.block].params.iter().zip(&target.args)
                    {
                        let now = points[param].or(points[arg]);
                        set(&mut points, param, now);
                    }
                }
            }
            if !changed {
                break;
            }
        }
        Objects { points }
    }

    /// The object that an address points into, if there is one that it surely does.
    pub fn object(&self, address: Value) -> Option<Object> {
        match self.points_of(address) {
            Points::Into(Target::Object(object)) => Some(object),
            _ => None,
        }
    }

    /// Of a value that was made since nothing is known.
    fn points_of(&self, value: Value) -> Points {
        self.points.get(value).copied().unwrap_or(Points::Unknown)
    }

    /// True if two addresses certainly point into different objects, if one of the two is written through.
    pub(super) fn are_apart(&self, one: Value, other: Value) -> bool {
        match (self.points_of(one), self.points_of(other)) {
            (Points::Into(one), Points::Into(other)) => one != other,
            // What is reached through a restrict pointer is reached through no pointer that is not based on it.
            (Points::Into(Target::Restrict(_)), Points::Given)
            | (Points::Given, Points::Into(Target::Restrict(_))) => true,
            _ => false,
        }
    }

    /// True if a value is certainly no address.
    pub fn is_number(&self, value: Value) -> bool {
        matches!(self.points_of(value), Points::Number | Points::Open)
    }
}

/// The objects of a function's addresses in each scope of `restrict` pointers, looked for where they are first asked for.
#[derive(Default)]
pub(super) struct Scopes {
    scopes: FxHashMap<Vec<u32>, Objects>,
}

impl Scopes {
    /// The objects of the addresses in a block: in the scope of the pointers of its kernel, if it is one.
    pub(super) fn of_block(&mut self, func: &Function, block: Block) -> &Objects {
        let mark = func.blocks[block].kernel.as_ref();
        let numbers = mark.map_or(&[][..], |mark| &mark.restrict);
        if !self.scopes.contains_key(numbers) {
            let objects = Objects::in_scope(func, numbers);
            self.scopes.insert(numbers.to_vec(), objects);
        }
        &self.scopes[numbers]
    }
}

/// A piece of memory that an access reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    space: Space,
    base: Value,
    /// Bytes from the base to its first one, and behind its last one.
    start: i64,
    end: i64,
}

impl Piece {
    /// The piece of an access; `None` for what accesses no memory, or none at an address.
    pub(super) fn of(op: Opcode, base: Value, imm: i32) -> Option<Piece> {
        let start = i64::from(imm);
        Some(Piece {
            space: op.space()?,
            base,
            start,
            end: start + i64::from(op.access_bytes()?),
        })
    }

    /// True if two pieces may have a byte in common: the same memory, not of different objects, and not disjoint from
    /// the same base.
    pub(super) fn may_meet(&self, other: &Piece, objects: &Objects) -> bool {
        if self.space != other.space {
            return false;
        }
        if self.base != other.base {
            return !objects.are_apart(self.base, other.base);
        }
        self.start < other.end && other.start < self.end
    }

    /// True if all bytes of another piece are in this one.
    pub(super) fn contains(&self, other: &Piece) -> bool {
        (self.space, self.base) == (other.space, other.base)
            && self.start <= other.start
            && other.end <= self.end
    }

    /// True if it is in this memory.
    pub(super) fn is_in(&self, space: Space) -> bool {
        self.space == space
    }
}

fn of_inst(kind: &InstKind, points: &EntityMap<Value, Points>, loaded: Points) -> Points {
    match kind {
        InstKind::Const(_) => Points::Number,
        InstKind::SymbolAddr(symbol, _) => Points::Into(Target::Object(Object::Symbol(*symbol))),
        InstKind::SlotAddr(slot, _) => Points::Into(Target::Object(Object::Slot(*slot))),
        InstKind::Op { op, args, .. } => match op {
            Opcode::Mov => points[args[0]],
            Opcode::Add | Opcode::And | Opcode::Or => points[args[0]].plus(points[args[1]]),
            Opcode::Sub => match (points[args[0]], points[args[1]]) {
                (Points::Open, _) | (_, Points::Open) => Points::Open,
                (Points::Across, _) | (_, Points::Across) => Points::Across,
                (Points::Into(left), Points::Into(right)) if left != right => Points::Across,
                (Points::Number, Points::Into(_)) => Points::Across,
                (_, Points::Into(_)) => Points::Number,
                (_, Points::Several) => Points::Several,
                (left, _) => left,
            },
            Opcode::Sel => points[args[1]].or(points[args[2]]),
            _ if op.info().effect == Effect::Load => loaded,
            Opcode::Min | Opcode::Max | Opcode::Minu | Opcode::Maxu => Points::Unknown,
            _ if op.is_pure() && op.class() != Class::Lane => Points::Number,
            _ => Points::Unknown,
        },
        InstKind::Call { .. } | InstKind::Launch { .. } => Points::Unknown,
    }
}
