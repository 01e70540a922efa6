//! Proofs that an address points into one object, by which accesses of two objects may change places.
//!
//! A proof goes from the address back to where its parts come from. What it needs on the way becomes a
//! goal; a goal that comes up again, in a loop, holds if all others do, for it then holds of every value
//! that an execution computes before the next. Pointer arithmetic stays inside the object that it starts
//! from (C17 6.5.6), so of the two parts of a sum one has to point into the object, and the other must be
//! a number: neither an address that is taken in this function nor the distance of two of them.

use crate::flow::Cfg;
use crate::pass::Object;
use crate::program::{Function, InstKind, Value};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Opcode};
use std::collections::BTreeSet;

/// The definitions of a function's values.
pub(super) struct Proof<'a> {
    defs: EntityMap<Value, Def<'a>>,
}

enum Def<'a> {
    /// A value that the function is given.
    Given,
    Inst(&'a InstKind),
    /// What the ways to a block bring.
    Either(Vec<Value>),
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Goal {
    Into(Value),
    Number(Value),
}

/// What can be found in a value.
#[derive(Default)]
struct Origins {
    objects: Vec<Object>,
    /// It has parts that come from elsewhere.
    elsewhere: bool,
}

impl<'a> Proof<'a> {
    pub(super) fn of(func: &'a Function) -> Proof<'a> {
        let mut defs: EntityMap<Value, Def<'a>> =
            func.values.values().map(|_| Def::Given).collect();
        for &block in &Cfg::of(func).order {
            for &inst in &func.blocks[block].insts {
                for &result in &func.insts[inst].results {
                    defs[result] = Def::Inst(&func.insts[inst].kind);
                }
            }
            for target in func.blocks[block].end.targets() {
                for (&param, &arg) in func.blocks[target.block].params.iter().zip(&target.args) {
                    match &mut defs[param] {
                        Def::Either(values) => values.push(arg),
                        def => *def = Def::Either(vec![arg]),
                    }
                }
            }
        }
        Proof { defs }
    }

    /// True if `address` certainly points into `object`, or never gets a value.
    pub(super) fn points_into(&self, address: Value, object: Object) -> bool {
        self.holds(Goal::Into(address), object)
    }

    fn holds(&self, goal: Goal, object: Object) -> bool {
        let mut known = BTreeSet::new();
        let mut open = vec![goal];
        while let Some(goal) = open.pop() {
            if !known.insert(goal) {
                continue;
            }
            let holds = match goal {
                Goal::Into(value) => self.into(value, object, &mut open),
                Goal::Number(value) => self.number(value, &mut open),
            };
            if !holds {
                return false;
            }
        }
        true
    }

    /// Adds what has to hold so that a value points into an object; false if nothing would do.
    fn into(&self, value: Value, object: Object, open: &mut Vec<Goal>) -> bool {
        let kind = match self.defs.get(value) {
            Some(Def::Inst(kind)) => kind,
            Some(Def::Either(values)) => {
                open.extend(values.iter().copied().map(Goal::Into));
                return true;
            }
            Some(Def::Given) | None => return false,
        };
        match kind {
            InstKind::SymbolAddr(symbol, _) => object == Object::Symbol(*symbol),
            InstKind::SlotAddr(slot, _) => object == Object::Slot(*slot),
            InstKind::Op { op, args, .. } => match op {
                Opcode::Mov => {
                    open.push(Goal::Into(args[0]));
                    true
                }
                Opcode::Sel => {
                    open.extend([Goal::Into(args[1]), Goal::Into(args[2])]);
                    true
                }
                Opcode::Add | Opcode::And | Opcode::Or => {
                    let second = self.holds(Goal::Number(args[0]), object);
                    let (base, rest) = if second { (1, 0) } else { (0, 1) };
                    open.extend([Goal::Into(args[base]), Goal::Number(args[rest])]);
                    true
                }
                Opcode::Sub => {
                    open.extend([Goal::Into(args[0]), Goal::Number(args[1])]);
                    true
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Adds what has to hold so that a value is a number; false if nothing would do. Values that come
    /// from elsewhere are numbers where an address is added to them.
    fn number(&self, value: Value, open: &mut Vec<Goal>) -> bool {
        let kind = match self.defs.get(value) {
            Some(Def::Inst(kind)) => kind,
            Some(Def::Either(values)) => {
                open.extend(values.iter().copied().map(Goal::Number));
                return true;
            }
            Some(Def::Given) | None => return true,
        };
        match kind {
            InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => false,
            InstKind::Op { op, args, .. } => {
                let parts = match op {
                    Opcode::Mov => &args[..1],
                    Opcode::Sel => &args[1..],
                    Opcode::Sub if self.is_distance(args[0], args[1]) => &[],
                    Opcode::Add | Opcode::And | Opcode::Or | Opcode::Sub => &args[..],
                    _ => &[],
                };
                open.extend(parts.iter().copied().map(Goal::Number));
                true
            }
            _ => true,
        }
    }

    /// True if two values point into one object: the difference counts its bytes.
    fn is_distance(&self, left: Value, right: Value) -> bool {
        let (left, right) = (self.origins(left), self.origins(right));
        match right.objects[..] {
            [object] if !right.elsewhere => left.elsewhere || left.objects.contains(&object),
            _ => false,
        }
    }

    /// The objects whose addresses are parts of a value.
    fn origins(&self, value: Value) -> Origins {
        let mut origins = Origins::default();
        let mut known = BTreeSet::new();
        let mut open = vec![value];
        while let Some(value) = open.pop() {
            if !known.insert(value) {
                continue;
            }
            let kind = match self.defs.get(value) {
                Some(Def::Inst(kind)) => kind,
                Some(Def::Either(values)) => {
                    open.extend(values);
                    continue;
                }
                Some(Def::Given) | None => {
                    origins.elsewhere = true;
                    continue;
                }
            };
            let mut found = |object| {
                if !origins.objects.contains(&object) {
                    origins.objects.push(object);
                }
            };
            match kind {
                InstKind::Const(_) => {}
                InstKind::SymbolAddr(symbol, _) => found(Object::Symbol(*symbol)),
                InstKind::SlotAddr(slot, _) => found(Object::Slot(*slot)),
                InstKind::Op { op, args, .. } => match op {
                    Opcode::Mov => open.push(args[0]),
                    Opcode::Sel => open.extend(&args[1..]),
                    Opcode::Add | Opcode::And | Opcode::Or | Opcode::Sub => open.extend(args),
                    _ if op.is_pure() && op.class() != Class::Lane => {}
                    _ => origins.elsewhere = true,
                },
                InstKind::Call { .. } | InstKind::Launch { .. } => origins.elsewhere = true,
            }
        }
        origins
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Func, Global, Symbol};
    use srp_archdesc::entity::Entity;

    const PROGRAM: &str = "\
main fn0
g0 a size 64 align 16
g1 b size 64 align 16
fn0 main(v0: w, v1: w) -> (w, w, w, w, w) {
bb0:
  v2 = symbol g0
  v3 = symbol g1
  v4 = const 4
  v5 = add v2, v0
  v6 = sub v3, v2
  v7 = add v2, v6
  v8 = sub v5, v2
  v9 = add v8, v3
  v10 = lt v0, v1
  v11 = sel v10, v2, v3
  jump bb1(v2, v2)
bb1(v12: w, v13: w):
  v14 = add v12, v4
  v15 = lt v14, v1
  br v15, bb1(v14, v3), bb2
bb2:
  ret v7, v9, v11, v12, v13
}
";

    #[test]
    fn claims_are_proved_or_refused() {
        let program = crate::text::read(PROGRAM).expect("it is a program");
        let proof = Proof::of(&program.funcs[Func::new(0)]);
        let object = |n| Object::Symbol(Symbol::Global(Global::new(n)));
        let proved = |value| [0, 1].map(|n| proof.points_into(Value::new(value), object(n)));
        assert_eq!(proved(0), [false, false], "what the function is given");
        assert_eq!(proved(5), [true, false], "an address and a number");
        assert_eq!(proved(7), [false, false], "the distance of two objects");
        assert_eq!(proved(9), [false, true], "the distance within one object");
        assert_eq!(proved(11), [false, false], "one of two objects");
        assert_eq!(proved(12), [true, false], "what a loop counts up");
        assert_eq!(proved(13), [false, false], "two objects in turn");
    }
}
