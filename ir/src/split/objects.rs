//! Which objects an address can point into.
//!
//! Pointer arithmetic stays inside the object that it starts from (C17 6.5.6), so an address made by
//! adding something to the address of a global points into that global, whatever was added.

use super::linear::Atom;
use super::shape::{Def, Loop};
use crate::program::{InstKind, Value};
use srp_archdesc::isa::{Class, Opcode};
use std::collections::{BTreeMap, BTreeSet};

/// How many definitions of one address are looked at.
const MAX_DEFINITIONS: usize = 256;

/// How often they are gone through until nothing changes.
const MAX_ROUNDS: usize = 32;

/// What a word can be as an address. Nothing at all: not known yet, in a circle of definitions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Objects {
    /// Objects that it can point into.
    objects: BTreeSet<Atom>,
    /// It can also be a number.
    number: bool,
    /// It can also point anywhere.
    anywhere: bool,
}

impl Objects {
    fn number() -> Objects {
        Objects {
            number: true,
            ..Objects::default()
        }
    }

    fn anywhere() -> Objects {
        Objects {
            anywhere: true,
            ..Objects::default()
        }
    }

    fn object(atom: Atom) -> Objects {
        Objects {
            objects: BTreeSet::from([atom]),
            ..Objects::default()
        }
    }

    /// Whether it points into the objects and nowhere else.
    pub(super) fn is_known(&self) -> bool {
        !self.objects.is_empty() && !self.number && !self.anywhere
    }

    /// Whether addresses with these objects can never meet.
    pub(super) fn apart_from(&self, other: &Objects) -> bool {
        self.is_known() && other.is_known() && self.objects.is_disjoint(&other.objects)
    }

    fn or(mut self, other: Objects) -> Objects {
        self.objects.extend(other.objects);
        self.number |= other.number;
        self.anywhere |= other.anywhere;
        self
    }

    /// What a sum of the two is: one of them is the pointer.
    fn plus(self, other: Objects) -> Objects {
        let unknown = Objects::default();
        match (self.objects.is_empty(), other.objects.is_empty()) {
            (false, true) => self,
            (true, false) => other,
            (false, false) => self.or(other).or(Objects::anywhere()),
            // A circle of additions points where its start does.
            (true, true) if self == unknown || other == unknown => unknown,
            (true, true) => self.or(other),
        }
    }

    /// What a difference is: a pointer less a number, or a number.
    fn minus(self, other: Objects) -> Objects {
        if other.objects.is_empty() {
            self
        } else {
            Objects::number()
        }
    }
}

/// The objects that `address` can point into: the least solution of the definitions it comes from.
pub(super) fn objects_of(lp: &Loop<'_>, address: Value) -> Objects {
    let mut known = BTreeMap::new();
    let mut open = vec![address];
    let mut order = Vec::new();
    while let Some(value) = open.pop() {
        if known.len() >= MAX_DEFINITIONS {
            return Objects::anywhere();
        }
        if known.insert(value, Objects::default()).is_none() {
            order.push(value);
            open.extend(sources(lp, value));
        }
    }
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for &value in order.iter().rev() {
            let now = eval(lp, value, &known);
            changed |= known.insert(value, now.clone()) != Some(now);
        }
        if !changed {
            return known.remove(&address).expect("looked at first");
        }
    }
    Objects::anywhere()
}

/// The values whose objects decide those of `value`.
fn sources(lp: &Loop<'_>, value: Value) -> Vec<Value> {
    match lp.defs[value] {
        Some(Def::Param(block, i)) if !lp.is_entry(block) => {
            lp.jumps_to(block).map(|(_, t)| t.args[i]).collect()
        }
        Some(Def::Inst(..)) if simple(lp, value).is_none() => {
            let (op, args) = lp.op(value).expect("anything else is simple");
            let first = usize::from(op == Opcode::Sel);
            args[first..].to_vec()
        }
        _ => Vec::new(),
    }
}

fn eval(lp: &Loop<'_>, value: Value, known: &BTreeMap<Value, Objects>) -> Objects {
    let mut from = sources(lp, value).into_iter().map(|v| known[&v].clone());
    let op = lp.op(value).map(|(op, _)| op);
    let mut both = |f: fn(Objects, Objects) -> Objects| {
        let (a, b) = (from.next(), from.next());
        f(a.unwrap_or_default(), b.unwrap_or_default())
    };
    match (lp.defs[value], op) {
        (Some(Def::Param(block, _)), _) if !lp.is_entry(block) => {
            from.fold(Objects::default(), Objects::or)
        }
        (Some(Def::Inst(..)), op) => match (simple(lp, value), op) {
            (Some(simple), _) => simple,
            (None, Some(Opcode::Add | Opcode::And | Opcode::Or)) => both(Objects::plus),
            (None, Some(Opcode::Sub)) => both(Objects::minus),
            (None, _) => from.fold(Objects::default(), Objects::or),
        },
        _ => Objects::anywhere(),
    }
}

/// Definitions that are no sums.
fn simple(lp: &Loop<'_>, value: Value) -> Option<Objects> {
    match &lp.inst(value)?.kind {
        InstKind::Const(_) => Some(Objects::number()),
        InstKind::SymbolAddr(symbol, _) => Some(Objects::object(Atom::Symbol(*symbol))),
        InstKind::SlotAddr(slot, _) => Some(Objects::object(Atom::Slot(*slot))),
        InstKind::Op { op, .. } => match op {
            Opcode::Mov | Opcode::Add | Opcode::And | Opcode::Or => None,
            Opcode::Sub | Opcode::Sel => None,
            _ if op.is_pure() && !is_traffic(*op) => Some(Objects::number()),
            _ => Some(Objects::anywhere()),
        },
        InstKind::Call { .. } | InstKind::Launch { .. } => Some(Objects::anywhere()),
    }
}

/// Whether the operation only passes words on.
fn is_traffic(op: Opcode) -> bool {
    op.class() == Class::Lane
        || matches!(op, Opcode::Min | Opcode::Max | Opcode::Minu | Opcode::Maxu)
}
