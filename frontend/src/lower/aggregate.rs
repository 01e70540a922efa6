//! Structs and unions as values: copies, initial values, calls.

use super::function::{Lowering, passing, values_of};
use super::leaf::{Access, Leaf, leaves};
use super::place::{Base, Field, Location};
use super::scalar::Scalar;
use crate::ctype::{Type, TypeId};
use crate::typed::{Callee, ExprId, ExprKind, Init, LocalId};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{self, Bits, InstKind, SlotData, Target, Terminator, Value};

/// Scalars that are copied or cleared one by one; more make a loop.
const MAX_UNROLLED: usize = 64;

impl Lowering<'_> {
    /// Where the value of a struct expression is.
    pub(super) fn aggregate(&mut self, e: ExprId) -> Location {
        let body = self.body;
        let expr = &body.exprs[e];
        self.pos = expr.pos;
        match &expr.kind {
            ExprKind::Aggregate(place) => self.location(*place),
            ExprKind::Assign(place, value) => {
                let from = self.aggregate(*value);
                let to = self.location(*place);
                self.copy(to, from, expr.ty);
                to
            }
            ExprKind::Comma(first, second) => {
                self.effect(*first);
                self.aggregate(*second)
            }
            ExprKind::Conditional(c, a, b) => {
                let to = self.temporary(expr.ty);
                let (then, other, join) = (
                    self.new_block(&[]),
                    self.new_block(&[]),
                    self.new_block(&[]),
                );
                self.branch(*c, then, other);
                for (block, value) in [(then, *a), (other, *b)] {
                    self.enter(block);
                    let from = self.aggregate(value);
                    self.copy(to, from, expr.ty);
                    self.jump(join, Vec::new());
                }
                self.enter(join);
                to
            }
            ExprKind::Statements(list, Some(last)) => {
                list.iter().for_each(|&s| self.stmt(s));
                self.aggregate(*last)
            }
            ExprKind::Call(callee, args) => {
                let to = self.temporary_for_result(expr.ty);
                self.call(*callee, args, Some((to, expr.ty)));
                to
            }
            _ => unreachable!("no other expression has a struct type"),
        }
    }

    fn temporary_for_result(&mut self, ty: TypeId) -> Location {
        match values_of(self.checked, ty) {
            Some(_) => self.temporary(ty),
            None => self.temporary_in_memory(ty),
        }
    }

    /// The scalars of a small object.
    fn few_leaves(&self, ty: TypeId) -> Option<Vec<Leaf>> {
        leaves(&self.checked.types, ty, MAX_UNROLLED)
    }

    /// Copies an object.
    pub(super) fn copy(&mut self, to: Location, from: Location, ty: TypeId) {
        if let Some(leaves) = self.few_leaves(ty) {
            // All is read before anything is written, as the two may be one.
            let values: Vec<_> = leaves
                .iter()
                .map(|leaf| self.load(from.plus(leaf.offset), leaf.access))
                .collect();
            for (leaf, value) in leaves.iter().zip(values) {
                self.store(to.plus(leaf.offset), leaf.access, value);
            }
            return;
        }
        let (to_address, from_address) = (self.address(to), self.address(from));
        self.walk(ty, |lowering, offset, access| {
            let source = lowering.op(Opcode::Add, &[from_address, offset]);
            let value = lowering.load(Location::pointer(source, from.global), access);
            let target = lowering.op(Opcode::Add, &[to_address, offset]);
            lowering.store(Location::pointer(target, to.global), access, value);
        });
    }

    /// Sets an object to zero.
    fn clear(&mut self, to: Location, ty: TypeId) {
        if let Some(leaves) = self.few_leaves(ty) {
            for leaf in leaves {
                let zero = self.constant(Bits::zero(leaf.access.ty()));
                self.store(to.plus(leaf.offset), leaf.access, zero);
            }
            return;
        }
        let address = self.address(to);
        self.walk(ty, |lowering, offset, access| {
            let zero = lowering.constant(Bits::zero(access.ty()));
            let target = lowering.op(Opcode::Add, &[address, offset]);
            lowering.store(Location::pointer(target, to.global), access, zero);
        });
    }

    /// A loop over an object of at least one piece, in pieces as large as its alignment allows:
    /// `body` gets the offset.
    fn walk(&mut self, ty: TypeId, mut body: impl FnMut(&mut Self, Value, Access)) {
        let types = &self.checked.types;
        let (access, step) = match types.align(ty) {
            16.. => (Access::Vector, 16),
            4.. => (Access::Word, 4),
            2.. => (Access::Half(false), 2),
            _ => (Access::Byte(false), 1),
        };
        let size = types.size(ty).unwrap_or(0);
        let header = self.new_block(&[Ty::Word]);
        let exit = self.new_block(&[]);
        let start = self.word(0);
        self.jump(header, vec![start]);
        self.enter(header);
        let offset = self.func.blocks[header].params[0];
        body(self, offset, access);
        let step = self.word(step);
        let next = self.op(Opcode::Add, &[offset, step]);
        let size = self.word(size);
        let more = self.op(Opcode::Ltu, &[next, size]);
        self.end(Terminator::Branch {
            cond: more,
            then: Target {
                block: header,
                args: vec![next],
            },
            other: Target {
                block: exit,
                args: Vec::new(),
            },
        });
        self.enter(exit);
    }

    /// Sets a variable to its initial value.
    pub(super) fn init(&mut self, local: LocalId, init: &Init) {
        let ty = self.body.locals[local].ty.ty;
        let to = self.local(local);
        if init.zero {
            self.clear(to, ty);
        }
        for part in &init.parts {
            match part.bits {
                Some(bits) => {
                    let value = self.scalar(part.value);
                    let ty = self.body.exprs[part.value].ty;
                    let field = Field::bits(to.plus(part.offset), ty, bits);
                    self.write(field, value);
                }
                None if self.is_restrict(local) => {
                    let value = self.scalar(part.value).single();
                    let value = self.restrict(local, value);
                    self.write_at(to, ty, Scalar::Single(value));
                }
                None => self.set(to.plus(part.offset), part.value),
            }
        }
    }

    /// Stores the value of any expression.
    pub(super) fn set(&mut self, to: Location, e: ExprId) {
        let ty = self.body.exprs[e].ty;
        if self.is_record(ty) {
            let from = self.aggregate(e);
            self.copy(to, from, ty);
        } else {
            let value = self.scalar(e);
            self.write_at(to, ty, value);
        }
    }

    /// The values that an object passes as.
    pub(super) fn take_values(&mut self, from: Location, ty: TypeId) -> Vec<Value> {
        let leaves = self.few_leaves(ty).unwrap_or_default();
        let values = leaves.iter();
        values
            .map(|leaf| self.load(from.plus(leaf.offset), leaf.access))
            .collect()
    }

    /// Stores the values that an object passes as.
    pub(super) fn put_values(&mut self, to: Location, ty: TypeId, values: &[Value]) {
        let leaves = self.few_leaves(ty).unwrap_or_default();
        for (leaf, &value) in leaves.iter().zip(values) {
            self.store(to.plus(leaf.offset), leaf.access, value);
        }
    }

    /// A call; where its struct result goes, if it has one. The other result, if there is one.
    pub(super) fn call(
        &mut self,
        callee: Callee,
        args: &[ExprId],
        result: Option<(Location, TypeId)>,
    ) -> Option<Scalar> {
        let pos = self.pos;
        let ty = match callee {
            Callee::Function(function) => self.checked.functions[function].ty,
            Callee::Pointer(pointer) => {
                let ty = self.body.exprs[pointer].ty;
                self.checked.types.pointee(ty).map_or(ty, |to| to.ty)
            }
        };
        let passing = passing(self.checked, ty);
        let target = match callee {
            Callee::Pointer(pointer) => Some(self.value(pointer)),
            Callee::Function(_) => None,
        };
        let mut values = Vec::new();
        if let (true, Some((to, _))) = (passing.result_by_address, result) {
            values.push(self.address(to));
        }
        let fixed = match self.checked.types.get(ty) {
            Type::Function(signature) if signature.open && target.is_some() => args.len(),
            Type::Function(signature) => signature.params.len().min(args.len()),
            _ => args.len(),
        };
        let (fixed, more) = args.split_at(fixed);
        fixed
            .iter()
            .for_each(|&arg| self.argument(arg, &mut values));
        if passing.variadic {
            // A function that is called without being known to take `...` may get too few.
            while values.len() + 1 < passing.params.len() {
                values.push(self.word(0));
            }
            let list = self.arguments_in_memory(more);
            values.push(list);
        } else {
            more.iter().for_each(|&arg| self.effect(arg));
        }
        self.pos = pos;
        if target.is_none() {
            values = self.as_passed(values, &passing.params);
        }
        let callee = match (callee, target) {
            (Callee::Function(function), _) => program::Callee::Func(self.symbols.func(function)),
            (_, target) => {
                let target = target.expect("the address of an indirect call was computed");
                program::Callee::Indirect(target, passing.results.clone())
            }
        };
        let kind = InstKind::Call {
            callee,
            args: values,
        };
        let inst = self.func.append(self.block, kind, &passing.results, pos);
        let results = self.func.insts[inst].results.clone();
        match result {
            Some((to, ty)) if !passing.result_by_address => {
                self.put_values(to, ty, &results);
                None
            }
            _ => Scalar::of(&results),
        }
    }

    /// The values that one argument passes as.
    fn argument(&mut self, arg: ExprId, values: &mut Vec<Value>) {
        let ty = self.body.exprs[arg].ty;
        if !self.is_record(ty) {
            values.extend(self.scalar(arg).values());
            return;
        }
        let from = self.aggregate(arg);
        if values_of(self.checked, ty).is_some() {
            values.extend(self.take_values(from, ty));
        } else {
            let copy = self.temporary_in_memory(ty);
            self.copy(copy, from, ty);
            values.push(self.address(copy));
        }
    }

    /// Arguments that `...` stands for: one after another in memory, each at a multiple of its
    /// alignment and of a word. Their address.
    fn arguments_in_memory(&mut self, args: &[ExprId]) -> Value {
        if args.is_empty() {
            return self.word(0);
        }
        let types = &self.checked.types;
        let (mut end, mut align) = (0u32, 4);
        let mut offsets = Vec::new();
        for &arg in args {
            let ty = self.body.exprs[arg].ty;
            let own = types.align(ty).max(4);
            align = align.max(own);
            let offset = end.next_multiple_of(own);
            offsets.push(offset);
            end = offset + types.size(ty).unwrap_or(0).next_multiple_of(4);
        }
        let room = SlotData::temporary(end, align.min(16));
        let slot = self.func.slots.push(room);
        let room = Location {
            base: Base::Slot(slot),
            offset: 0,
            global: false,
        };
        for (&arg, offset) in args.iter().zip(offsets) {
            self.set(room.plus(offset), arg);
        }
        self.address(room)
    }

    /// Converts arguments for a function that may have been called without a declaration: arguments
    /// that are missing or of another kind become zero.
    fn as_passed(&mut self, values: Vec<Value>, types: &[Ty]) -> Vec<Value> {
        let mut values = values.into_iter();
        let passed = types.iter().map(|&ty| match values.next() {
            Some(value) if self.func.values[value] == ty => value,
            _ => self.constant(Bits::zero(ty)),
        });
        passed.collect()
    }

    /// Ends the function without a value that anyone may use.
    pub(super) fn return_zeros(&mut self) {
        let zeros = self.func.results.clone();
        let zeros = zeros.into_iter().map(|ty| self.constant(Bits::zero(ty)));
        let zeros = zeros.collect();
        self.end(Terminator::Return(zeros));
    }

    /// Ends the function with the value of an expression.
    pub(super) fn return_value(&mut self, e: ExprId) {
        let ty = self.result;
        if !self.is_record(ty) {
            let value = self.scalar(e);
            self.end(Terminator::Return(value.values()));
            return;
        }
        let from = self.aggregate(e);
        let values = match self.result_address {
            Some(address) => {
                self.copy(Location::pointer(address, false), from, ty);
                Vec::new()
            }
            None => self.take_values(from, ty),
        };
        self.end(Terminator::Return(values));
    }

    /// True if a type is a struct or union.
    pub(super) fn is_record(&self, ty: TypeId) -> bool {
        matches!(self.checked.types.get(ty), Type::Record(_))
    }
}
