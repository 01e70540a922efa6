//! Which objects an address can point into.
//!
//! Pointer arithmetic stays inside the object that it starts from (C17 6.5.6), so an address made by
//! adding something to the address of a global points into that global, whatever was added. What a
//! `restrict` pointer points to counts as an object of its own in the loops in its scope. Integers may
//! hold distances between objects, though, which lead from one to another.

use super::places::Def;
use super::shape::Loop;
use crate::pass::restrict_number;
use crate::program::{InstKind, Slot, Symbol, Value};
use srp_archdesc::isa::{Class, Opcode};
use std::collections::{BTreeMap, BTreeSet};

/// How many definitions of one address are looked at.
const MAX_DEFINITIONS: usize = 256;

/// How often they are gone through until nothing changes.
const MAX_ROUNDS: usize = 32;

/// Something that an address can point into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Object {
    Symbol(Symbol),
    Slot(Slot),
    /// What this `restrict` pointer points to.
    Restrict(u32),
    /// Whatever this word, which came from elsewhere, points to: it may be any other object, or
    /// the word may be no pointer.
    Unknown(Value),
}

/// What a word can be as an address. Nothing at all: not known yet, in a circle of definitions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Objects {
    /// Objects that it can point into.
    objects: BTreeSet<Object>,
    /// It can also be a number.
    number: bool,
    /// It can also point anywhere.
    anywhere: bool,
    /// It can also be the distance from one object to another.
    across: bool,
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

    fn object(object: Object) -> Objects {
        Objects {
            objects: BTreeSet::from([object]),
            ..Objects::default()
        }
    }

    fn points(&self) -> bool {
        !self.objects.is_empty() && !self.number && !self.anywhere && !self.across
    }

    fn unknown(&self) -> impl Iterator<Item = Value> + '_ {
        self.objects.iter().filter_map(|object| match object {
            Object::Unknown(value) => Some(*value),
            _ => None,
        })
    }

    /// Whether it points into objects that are known and nowhere else.
    pub(super) fn is_known(&self) -> bool {
        self.points() && self.unknown().next().is_none()
    }

    /// Whether addresses with these objects can never meet.
    pub(super) fn apart_from(&self, other: &Objects) -> bool {
        self.is_known() && other.is_known() && self.objects.is_disjoint(&other.objects)
    }

    /// Whether they could never meet if the pointers from outside the loop that they start from were
    /// `restrict`.
    pub(super) fn could_be_apart_from(&self, lp: &Loop<'_>, other: &Objects) -> bool {
        let outside = |objects: &Objects| objects.unknown().all(|value| !lp.is_inside(value));
        self.points()
            && other.points()
            && outside(self)
            && outside(other)
            && self.objects.is_disjoint(&other.objects)
    }

    /// Whether there is an object among them for sure.
    fn has_object(&self) -> bool {
        self.objects
            .iter()
            .any(|object| !matches!(object, Object::Unknown(_)))
    }

    fn or(mut self, other: Objects) -> Objects {
        self.objects.extend(other.objects);
        self.number |= other.number;
        self.anywhere |= other.anywhere;
        self.across |= other.across;
        self
    }

    /// What a sum of the two is: one of them is the pointer.
    fn plus(self, other: Objects) -> Objects {
        let unknown = Objects::default();
        match (self.has_object(), other.has_object()) {
            _ if self.across || other.across => self.or(other),
            (true, false) => self,
            (false, true) => other,
            (true, true) => self.or(other).or(Objects::anywhere()),
            // A circle of additions points where its start does.
            (false, false) if self == unknown || other == unknown => unknown,
            (false, false) if self.is_number() => other,
            (false, false) if other.is_number() => self,
            (false, false) => self.or(other),
        }
    }

    fn is_number(&self) -> bool {
        *self == Objects::number()
    }

    /// What a difference is: a pointer less a number, or a number.
    fn minus(self, other: Objects) -> Objects {
        if !other.has_object() {
            return self.or(Objects {
                across: other.across,
                ..Objects::default()
            });
        }
        let leads = |objects: &Objects| objects.has_object() || objects.is_number();
        Objects {
            number: true,
            across: leads(&self) && self.objects != other.objects,
            ..Objects::default()
        }
    }
}

/// The objects that `address` can point into, where the `restrict` pointers of these numbers are in
/// scope: the least solution of the definitions it comes from.
pub(super) fn objects_of(lp: &Loop<'_>, restrict: &[u32], address: Value) -> Objects {
    let mut known = BTreeMap::new();
    let mut open = vec![address];
    let mut order = Vec::new();
    while let Some(value) = open.pop() {
        if known.len() >= MAX_DEFINITIONS {
            return Objects::anywhere();
        }
        if known.insert(value, Objects::default()).is_none() {
            order.push(value);
            open.extend(sources(lp, restrict, value));
        }
    }
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for &value in order.iter().rev() {
            let now = eval(lp, restrict, value, &known);
            changed |= known.insert(value, now.clone()) != Some(now);
        }
        if !changed {
            return known.remove(&address).expect("looked at first");
        }
    }
    Objects::anywhere()
}

/// The values whose objects decide those of `value`.
fn sources(lp: &Loop<'_>, restrict: &[u32], value: Value) -> Vec<Value> {
    match lp.def(value) {
        Some(Def::Param(block, i)) if !lp.is_entry(block) => {
            lp.jumps_to(block).map(|(_, t)| t.args[i]).collect()
        }
        Some(Def::Inst(..)) if simple(lp, restrict, value).is_none() => {
            let (op, args) = lp.op(value).expect("anything else is simple");
            let first = usize::from(op == Opcode::Sel);
            args[first..].to_vec()
        }
        _ => Vec::new(),
    }
}

fn eval(
    lp: &Loop<'_>,
    restrict: &[u32],
    value: Value,
    known: &BTreeMap<Value, Objects>,
) -> Objects {
    let mut from = sources(lp, restrict, value)
        .into_iter()
        .map(|v| known[&v].clone());
    let op = lp.op(value).map(|(op, _)| op);
    let mut both = |f: fn(Objects, Objects) -> Objects| {
        let (a, b) = (from.next(), from.next());
        f(a.unwrap_or_default(), b.unwrap_or_default())
    };
    match (lp.def(value), op) {
        (Some(Def::Param(block, _)), _) if !lp.is_entry(block) => {
            from.fold(Objects::default(), Objects::or)
        }
        (Some(Def::Inst(..)), op) => match (simple(lp, restrict, value), op) {
            (Some(simple), _) => simple,
            (None, Some(Opcode::Add | Opcode::And | Opcode::Or)) => both(Objects::plus),
            (None, Some(Opcode::Sub)) => both(Objects::minus),
            (None, _) => from.fold(Objects::default(), Objects::or),
        },
        _ => Objects::object(Object::Unknown(value)),
    }
}

/// Definitions that are no sums.
fn simple(lp: &Loop<'_>, restrict: &[u32], value: Value) -> Option<Objects> {
    let kind = &lp.inst(value)?.kind;
    let unknown = Objects::object(Object::Unknown(value));
    match kind {
        InstKind::Const(_) => Some(Objects::number()),
        InstKind::SymbolAddr(symbol, _) => Some(Objects::object(Object::Symbol(*symbol))),
        InstKind::SlotAddr(slot, _) => Some(Objects::object(Object::Slot(*slot))),
        InstKind::Op { op, .. } => match op {
            Opcode::Mov => restrict_number(kind)
                .filter(|number| restrict.contains(number))
                .map(|number| Objects::object(Object::Restrict(number))),
            Opcode::Add | Opcode::And | Opcode::Or => None,
            Opcode::Sub | Opcode::Sel => None,
            _ if op.is_pure() && !is_traffic(*op) => Some(Objects::number()),
            _ => Some(unknown),
        },
        InstKind::Call { .. } | InstKind::Launch { .. } => Some(unknown),
    }
}

/// Whether the operation only passes words on.
fn is_traffic(op: Opcode) -> bool {
    op.class() == Class::Lane
        || matches!(op, Opcode::Min | Opcode::Max | Opcode::Minu | Opcode::Maxu)
}
