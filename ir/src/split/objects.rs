//! Which objects an address can point into.
//!
//! Pointer arithmetic stays inside the object that it starts from (C17 6.5.6), so an address made by
//! adding something to the address of a global points into that global, whatever was added. What a
//! `restrict` pointer points to counts as an object of its own in the loops in its scope. Integers may
//! hold distances between objects, though, which lead from one to another.

use super::places::Def;
use super::shape::Loop;
use crate::pass::restrict_number;
use crate::program::{InstKind, KernelMark, Slot, Symbol, Value};
use srp_archdesc::isa::{Class, Effect, Opcode};
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
    /// The target of this `restrict` pointer.
    Restrict(u32),
    /// Whatever this word, which came from elsewhere, points to: it may be any other object, or
    /// the word may be no pointer.
    Unknown(Value),
    /// The same of a word that the function was given or has loaded, and that is based on no `restrict` pointer.
    Given(Value),
}

/// The possible targets of a word as an address. Empty: not known yet, in a cycle of definitions.
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
    /// The numbers of the independent variables by all of which it is surely reached. None where
    /// nothing is known yet, or for what is no address.
    variables: Option<BTreeSet<u32>>,
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
            variables: Some(BTreeSet::new()),
            ..Objects::default()
        }
    }

    fn object(object: Object) -> Objects {
        Objects {
            objects: BTreeSet::from([object]),
            variables: Some(BTreeSet::new()),
            ..Objects::default()
        }
    }

    /// True if it points into objects and can be nothing else.
    pub(super) fn points(&self) -> bool {
        !self.objects.is_empty() && !self.number && !self.anywhere && !self.across
    }

    fn unknown(&self) -> impl Iterator<Item = Value> + '_ {
        self.objects.iter().filter_map(|object| match object {
            Object::Unknown(value) | Object::Given(value) => Some(*value),
            _ => None,
        })
    }

    /// True if it points only into known objects.
    pub(super) fn is_known(&self) -> bool {
        self.points() && self.unknown().next().is_none()
    }

    /// True if accesses with these objects, one of which writes, can never meet.
    pub(super) fn apart_from(&self, other: &Objects) -> bool {
        let all = |is: fn(&Object) -> bool| {
            let (one, two) = (self.objects.iter().all(is), other.objects.iter().all(is));
            (one, two)
        };
        let known = all(|o| !matches!(o, Object::Unknown(_) | Object::Given(_)));
        let restrict = all(|o| matches!(o, Object::Restrict(_)));
        let given = all(|o| matches!(o, Object::Given(_)));
        self.points()
            && other.points()
            && (known == (true, true) && self.objects.is_disjoint(&other.objects)
                || restrict.0 && given.1
                || given.0 && restrict.1)
    }

    /// True if they could never meet if the pointers from outside the loop that they start from
    /// were `restrict`.
    pub(super) fn could_be_apart_from(&self, lp: &Loop<'_>, other: &Objects) -> bool {
        let outside = |objects: &Objects| objects.unknown().all(|value| !lp.is_inside(value));
        self.points()
            && other.points()
            && outside(self)
            && outside(other)
            && self.objects.is_disjoint(&other.objects)
    }

    /// True if both point into one object, which is the same in all iterations.
    pub(super) fn same_as(&self, lp: &Loop<'_>, other: &Objects) -> bool {
        self.points()
            && self.objects.len() == 1
            && self.objects == other.objects
            && other.points()
            && self.unknown().all(|value| !lp.is_inside(value))
    }

    /// True if it contains an object for certain.
    fn has_object(&self) -> bool {
        self.objects
            .iter()
            .any(|object| !matches!(object, Object::Unknown(_) | Object::Given(_)))
    }

    fn or(mut self, other: Objects) -> Objects {
        self.objects.extend(other.objects);
        self.number |= other.number;
        self.anywhere |= other.anywhere;
        self.across |= other.across;
        self.variables = match (self.variables, other.variables) {
            (Some(one), Some(other)) => Some(&one & &other),
            (one, other) => one.or(other),
        };
        self
    }

    /// The numbers of the independent variables by which it is surely reached.
    pub(super) fn variables(&self) -> BTreeSet<u32> {
        self.variables.clone().unwrap_or_default()
    }

    /// The same, reached by an independent variable.
    fn by(mut self, variable: u32) -> Objects {
        if self != Objects::default() {
            self.variables.get_or_insert_default().insert(variable);
        }
        self
    }

    /// Returns the targets of a sum of the two: one of them is the pointer.
    fn plus(self, other: Objects) -> Objects {
        let unknown = Objects::default();
        let variables = match (&self.variables, &other.variables) {
            (Some(one), Some(other)) => Some(one | other),
            (one, other) => one.as_ref().or(other.as_ref()).cloned(),
        };
        let sum = match (self.has_object(), other.has_object()) {
            _ if self.across || other.across => self.or(other),
            (true, false) => self,
            (false, true) => other,
            (true, true) => self.or(other).or(Objects::anywhere()),
            // A circle of additions points where its start does.
            (false, false) if self == unknown || other == unknown => unknown,
            (false, false) if self.is_number() => other,
            (false, false) if other.is_number() => self,
            (false, false) => self.or(other),
        };
        match sum == Objects::default() {
            true => sum,
            false => Objects { variables, ..sum },
        }
    }

    fn is_number(&self) -> bool {
        *self == Objects::number()
    }

    /// Returns the targets of a difference: a pointer less a number, or a number.
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

/// The objects that `address` can point into, in the scope of the `restrict` pointers of this
/// mark: the least solution of the definitions it comes from.
pub(super) fn objects_of(lp: &Loop<'_>, mark: &KernelMark, address: Value) -> Objects {
    let mut known = BTreeMap::new();
    let mut open = vec![address];
    let mut order = Vec::new();
    while let Some(value) = open.pop() {
        if known.len() >= MAX_DEFINITIONS {
            return Objects::anywhere();
        }
        if known.insert(value, Objects::default()).is_none() {
            order.push(value);
            open.extend(sources(lp, mark, value));
        }
    }
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for &value in order.iter().rev() {
            let now = eval(lp, mark, value, &known);
            changed |= known.insert(value, now.clone()) != Some(now);
        }
        if !changed {
            return known.remove(&address).expect("looked at first");
        }
    }
    Objects::anywhere()
}

/// The values whose objects decide those of `value`.
fn sources(lp: &Loop<'_>, mark: &KernelMark, value: Value) -> Vec<Value> {
    match lp.def(value) {
        Some(Def::Param(block, i)) if !lp.is_entry(block) => {
            lp.jumps_to(block).map(|(_, t)| t.args[i]).collect()
        }
        Some(Def::Inst(..)) if simple(lp, mark, value).is_none() => {
            let (op, args) = lp.op(value).expect("anything else is simple");
            let first = usize::from(op == Opcode::Sel);
            args[first..].to_vec()
        }
        _ => Vec::new(),
    }
}

fn eval(
    lp: &Loop<'_>,
    mark: &KernelMark,
    value: Value,
    known: &BTreeMap<Value, Objects>,
) -> Objects {
    let mut from = sources(lp, mark, value)
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
        (Some(Def::Inst(..)), op) => match (simple(lp, mark, value), op) {
            (Some(simple), _) => simple,
            (None, Some(Opcode::Add | Opcode::And | Opcode::Or)) => both(Objects::plus),
            (None, Some(Opcode::Sub)) => both(Objects::minus),
            (None, _) => {
                let all = from.fold(Objects::default(), Objects::or);
                let number = lp.inst(value).and_then(|inst| restrict_number(&inst.kind));
                let is_listed = |n: &u32| mark.independence.groups.iter().any(|g| g.contains(n));
                match number.filter(is_listed) {
                    Some(number) => all.by(number),
                    None => all,
                }
            }
        },
        (Some(Def::Param(..)), _) => Objects::object(Object::Given(value)),
        _ => Objects::object(Object::Unknown(value)),
    }
}

/// Definitions that are no sums.
fn simple(lp: &Loop<'_>, mark: &KernelMark, value: Value) -> Option<Objects> {
    let kind = &lp.inst(value)?.kind;
    let unknown = Objects::object(Object::Unknown(value));
    match kind {
        InstKind::Const(_) => Some(Objects::number()),
        InstKind::SymbolAddr(symbol, _) => Some(Objects::object(Object::Symbol(*symbol))),
        InstKind::SlotAddr(slot, _) => Some(Objects::object(Object::Slot(*slot))),
        InstKind::Op { op, .. } => match op {
            Opcode::Mov => restrict_number(kind)
                .filter(|number| mark.restrict.contains(number))
                .map(|number| Objects::object(Object::Restrict(number))),
            Opcode::Add | Opcode::And | Opcode::Or => None,
            Opcode::Sub | Opcode::Sel => None,
            _ if op.info().effect == Effect::Load && lp.restrict_stays() => {
                Some(Objects::object(Object::Given(value)))
            }
            _ if op.is_pure() && !is_traffic(*op) => Some(Objects::number()),
            _ => Some(unknown),
        },
        InstKind::Call { .. } | InstKind::Launch { .. } => Some(unknown),
    }
}

/// True if the operation only passes words on.
fn is_traffic(op: Opcode) -> bool {
    op.class() == Class::Lane
        || matches!(op, Opcode::Min | Opcode::Max | Opcode::Minu | Opcode::Maxu)
}
