//! One function: its state while it is lowered, and what all parts of the lowering emit with.

use super::Symbols;
use super::place::Part;
use crate::ctype::{Type, TypeId};
use crate::options::Options;
use crate::typed::{self, Body, Checked, LocalId, StmtKind, Variable};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::structure::Special;
use srp_ir::program::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Scalars that a struct may have to pass as its members.
pub(super) const MAX_PASSED: usize = 16;

/// Names of kernels, each used once, and numbers of `restrict` pointers.
#[derive(Default)]
pub(super) struct KernelNames {
    names: BTreeSet<String>,
    /// The last number.
    restrict: u32,
}

impl KernelNames {
    /// A name after that of a function.
    pub(super) fn after(&mut self, function: &str) -> String {
        let base = function.replace('.', "_");
        let mut name = base.clone();
        let mut number = 1;
        while !self.names.insert(name.clone()) {
            number += 1;
            name = format!("{base}_{number}");
        }
        name
    }
}

/// The operations that compute functions.
pub(super) type Units = BTreeMap<Special, Opcode>;

/// What pragmas before a loop say of units.
pub(super) struct Wish {
    /// The instructions that were made for the loop.
    pub(super) insts: Range<usize>,
    pub(super) units: Units,
}

/// Where a variable is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Storage {
    /// One slot, laid out as C says.
    Slot(Slot),
    /// One slot for each scalar: an index into [`Lowering::split`].
    Split(usize),
}

/// A loop or `switch` around the current statement.
pub(super) struct Breakable {
    /// Where `break` goes.
    pub(super) exit: Block,
    /// True if it is a loop.
    pub(super) is_loop: bool,
    /// Where `continue` goes, once one is seen.
    pub(super) next: Option<Block>,
}

/// A function being lowered.
pub(super) struct Lowering<'a> {
    pub(super) checked: &'a Checked,
    pub(super) symbols: &'a Symbols,
    pub(super) body: &'a Body,
    pub(super) auto_kernel: bool,
    pub(super) func: Function,
    /// Where code goes.
    pub(super) block: Block,
    /// Blocks in the order in which code was put into them.
    order: Vec<Block>,
    /// The position of the code being made.
    pub(super) pos: Pos,
    pub(super) storage: EntityMap<LocalId, Storage>,
    /// Variables and temporaries that are one slot for each scalar.
    pub(super) split: Vec<Vec<Part>>,
    pub(super) breakables: Vec<Breakable>,
    /// For each loop around: whether a loop is inside it.
    pub(super) has_inner: Vec<bool>,
    /// Label blocks of the `switch` statements around.
    pub(super) labels: Vec<Vec<Block>>,
    /// The C type of the result.
    pub(super) result: TypeId,
    /// Where a large struct result goes.
    pub(super) result_address: Option<Value>,
    /// The address of the arguments that `...` stands for.
    pub(super) variadic: Option<Value>,
    /// Blocks of the labels for `goto`, once one is named.
    pub(super) targets: Vec<Option<Block>>,
    /// The constant *true* of a block.
    guard: Option<(Block, Value)>,
    kernels: &'a mut KernelNames,
    /// The numbers of the `restrict` pointers in scope that the loops of this function may count on.
    pub(super) restrict: Vec<u32>,
    /// The variables that loops around call independent, with their numbers.
    pub(super) independent: Vec<(Variable, u32)>,
    /// What pragmas of the loops so far say of units, inner loops first.
    pub(super) wishes: Vec<Wish>,
}

/// How a function passes values.
pub(super) struct Passing {
    pub(super) params: Vec<Ty>,
    pub(super) results: Vec<Ty>,
    /// The first parameter is the address for the result.
    pub(super) result_by_address: bool,
    /// The last parameter is the address of the arguments that `...` stands for.
    pub(super) variadic: bool,
}

/// The slots of each variable of a function, with the offsets of what they have.
pub(crate) type Places = Vec<Vec<(Slot, u32)>>;

/// Lowers one function. Beside it stand what pragmas of its loops say of units, and where its variables are.
pub(super) fn lower(
    checked: &Checked,
    symbols: &Symbols,
    function: &typed::Function,
    body: &Body,
    options: &Options<'_>,
    kernels: &mut KernelNames,
) -> (Function, Vec<Wish>, Places) {
    let passing = passing(checked, function.ty);
    let func = Function::new(
        &function.name,
        &passing.params,
        passing.results.clone(),
        function.pos,
    );
    let result = match checked.types.get(function.ty) {
        Type::Function(signature) => signature.result,
        _ => checked.types.known.void,
    };
    let mut lowering = Lowering {
        checked,
        symbols,
        body,
        // The loops of the library are short and irregular: not worth the switch.
        auto_kernel: options.auto_kernel && !function.optional,
        block: func.entry(),
        order: vec![func.entry()],
        func,
        pos: function.pos,
        storage: EntityMap::new(),
        split: Vec::new(),
        breakables: Vec::new(),
        has_inner: Vec::new(),
        labels: Vec::new(),
        result,
        result_address: None,
        variadic: None,
        targets: vec![None; body.labels],
        guard: None,
        kernels,
        restrict: Vec::new(),
        independent: Vec::new(),
        wishes: Vec::new(),
    };
    lowering.func.noinline = function.noinline;
    lowering.locals();
    let places = lowering.places();
    lowering.params(&passing);
    if let Some(root) = body.root {
        lowering.stmt(root);
    }
    lowering.return_zeros();
    lay_out(&mut lowering.func, lowering.order);
    (lowering.func, lowering.wishes, places)
}

/// How a function of this type passes its values.
pub(super) fn passing(checked: &Checked, ty: TypeId) -> Passing {
    let mut passing = Passing {
        params: Vec::new(),
        results: Vec::new(),
        result_by_address: false,
        variadic: false,
    };
    let Type::Function(signature) = checked.types.get(ty) else {
        return passing;
    };
    match values_of(checked, signature.result) {
        Some(types) => passing.results = types,
        None => {
            passing.result_by_address = true;
            passing.params.push(Ty::Word);
        }
    }
    for &param in &signature.params {
        let types = values_of(checked, param);
        passing.params.extend(types.unwrap_or(vec![Ty::Word]));
    }
    if signature.variadic {
        passing.variadic = true;
        passing.params.push(Ty::Word);
    }
    passing
}

/// The values that a C value passes as; `None` for a struct that passes by address.
pub(super) fn values_of(checked: &Checked, ty: TypeId) -> Option<Vec<Ty>> {
    Some(match checked.types.get(ty) {
        Type::Void => Vec::new(),
        Type::Vector(_) => vec![Ty::Vec],
        Type::Record(_) => {
            let leaves = super::leaf::leaves(&checked.types, ty, MAX_PASSED)?;
            leaves.iter().map(|leaf| leaf.access.ty()).collect()
        }
        _ if checked.types.is_wide(ty) => vec![Ty::Word; 2],
        _ => vec![Ty::Word],
    })
}

/// Lays out the blocks that are reached, in the order in which code was put into them: blocks are
/// made before what comes between them.
fn lay_out(func: &mut Function, order: Vec<Block>) {
    let mut reached = BTreeSet::from([func.entry()]);
    let mut work = vec![func.entry()];
    while let Some(block) = work.pop() {
        for target in func.blocks[block].end.targets() {
            if reached.insert(target.block) {
                work.push(target.block);
            }
        }
    }
    func.layout = order;
    func.layout.retain(|block| reached.contains(block));
}

impl Lowering<'_> {
    /// Gives every variable its slots.
    fn locals(&mut self) {
        for local in self.body.locals.values() {
            let storage = match self.split_slots(local.ty.ty, Some(&local.name)) {
                Some(parts) if !local.in_memory => {
                    self.split.push(parts);
                    Storage::Split(self.split.len() - 1)
                }
                _ => Storage::Slot(self.aligned_slot(local.ty.ty, &local.name, local.align)),
            };
            self.storage.push(storage);
        }
    }

    /// Where the variables are.
    fn places(&self) -> Places {
        let slots = |storage: &Storage| match *storage {
            Storage::Slot(slot) => vec![(slot, 0)],
            Storage::Split(parts) => {
                let parts = self.split[parts].iter();
                parts.map(|part| (part.slot, part.offset)).collect()
            }
        };
        self.storage.values().map(slots).collect()
    }

    /// A slot for a value of a type.
    pub(super) fn temporary_slot(&mut self, ty: TypeId) -> Slot {
        let types = &self.checked.types;
        let size = types.size(ty).unwrap_or(0);
        let slot = SlotData::temporary(size, types.align(ty));
        self.func.slots.push(slot)
    }

    /// A slot for an object of a type with at least this alignment.
    fn aligned_slot(&mut self, ty: TypeId, name: &str, align: u32) -> Slot {
        self.func.slots.push(SlotData {
            name: name.to_owned(),
            size: self.checked.types.size(ty).unwrap_or(0),
            align: self.checked.types.align(ty).max(align),
        })
    }

    /// Stores the parameters where the variables are.
    fn params(&mut self, passing: &Passing) {
        let mut values = self.func.blocks[self.block].params.clone().into_iter();
        if passing.result_by_address {
            self.result_address = values.next();
        }
        for &local in &self.body.params {
            let ty = self.body.locals[local].ty.ty;
            match values_of(self.checked, ty) {
                Some(types) => {
                    let mut values: Vec<_> = values.by_ref().take(types.len()).collect();
                    if let [value] = &mut values[..] {
                        *value = self.restrict(local, *value);
                        *value = self.narrow(ty, *value);
                    }
                    let location = self.local(local);
                    self.put_values(location, ty, &values);
                }
                None => {
                    // The copy is this function's: it lives where the caller made it.
                    let Some(address) = values.next() else {
                        continue;
                    };
                    let from = super::place::Location::pointer(address, false);
                    let to = self.local(local);
                    self.copy(to, from, ty);
                }
            }
        }
        if passing.variadic {
            self.variadic = values.next();
        }
    }

    /// The value that a variable begins with, which is known as its own if it is a `restrict`
    /// pointer. Not in loops, where it would be another in each iteration, and not in functions
    /// without loops, which would only be harder to simplify.
    pub(super) fn restrict(&mut self, local: LocalId, value: Value) -> Value {
        if !self.is_restrict(local) || !self.has_inner.is_empty() || !self.has_loops() {
            return value;
        }
        self.kernels.restrict += 1;
        self.restrict.push(self.kernels.restrict);
        self.op_imm(Opcode::Mov, &[value], self.kernels.restrict as i32)
    }

    /// A parameter of a narrow type, which callers bring extended: extended once more where there are loops, since what
    /// may come of that tells how far a counter goes.
    fn narrow(&mut self, ty: TypeId, value: Value) -> Value {
        match *self.checked.types.get(ty) {
            Type::Int(int) if int.size() < 4 && self.has_loops() => self.cut(value, int),
            _ => value,
        }
    }

    fn has_loops(&self) -> bool {
        let is_loop = |s: &typed::Stmt| matches!(s.kind, StmtKind::Loop(_));
        self.body.stmts.values().any(is_loop)
    }

    /// Numbers the independent variables of a loop, whose body follows.
    pub(super) fn number(&mut self, group: &[Variable]) -> Vec<u32> {
        let mut numbers = Vec::new();
        for &variable in group {
            self.kernels.restrict += 1;
            self.independent.push((variable, self.kernels.restrict));
            numbers.push(self.kernels.restrict);
        }
        numbers
    }

    /// An address by a variable, known as that where a loop around calls the variable independent.
    pub(super) fn by(&mut self, variable: Variable, mut address: Value) -> Value {
        for i in 0..self.independent.len() {
            let (independent, number) = self.independent[i];
            if independent == variable {
                address = self.op_imm(Opcode::Mov, &[address], number as i32);
            }
        }
        address
    }

    /// True when a loop around calls a variable independent.
    pub(super) fn is_independent(&self, variable: Variable) -> bool {
        self.independent.iter().any(|&(other, _)| other == variable)
    }

    /// True if a variable is a `restrict` pointer.
    pub(super) fn is_restrict(&self, local: LocalId) -> bool {
        let ty = self.body.locals[local].ty;
        ty.quals.restrict && matches!(self.checked.types.get(ty.ty), Type::Pointer(_))
    }

    /// A name for a kernel in this function.
    pub(super) fn kernel_name(&mut self) -> String {
        self.kernels.after(&self.func.name)
    }

    /// A name for a loop with loops inside it, until one of those gives it its own.
    pub(super) fn nest_name(&mut self) -> String {
        self.kernels.after(&format!("{}_nest", self.func.name))
    }

    /// Appends an operation that has a result.
    pub(super) fn op(&mut self, op: Opcode, args: &[Value]) -> Value {
        self.op_imm(op, args, 0)
    }

    /// Appends an operation that has a result and an immediate.
    pub(super) fn op_imm(&mut self, op: Opcode, args: &[Value], imm: i32) -> Value {
        let made = self.func.append_op(self.block, op, args, imm, self.pos);
        made.expect("only opcodes with a result come here")
    }

    /// Appends an operation without a result.
    pub(super) fn effect_op(&mut self, op: Opcode, args: &[Value], imm: i32) {
        self.func.append_op(self.block, op, args, imm, self.pos);
    }

    /// Appends an instruction with one result.
    pub(super) fn inst(&mut self, kind: InstKind, ty: Ty) -> Value {
        let inst = self.func.append(self.block, kind, &[ty], self.pos);
        self.func.insts[inst].results[0]
    }

    /// Appends a constant.
    pub(super) fn constant(&mut self, bits: Bits) -> Value {
        self.func.append_const(self.block, bits, self.pos)
    }

    /// Appends a word constant.
    pub(super) fn word(&mut self, bits: u32) -> Value {
        self.constant(Bits::Word(bits))
    }

    /// The guard of an operation without condition.
    pub(super) fn always(&mut self) -> Value {
        match self.guard {
            Some((block, value)) if block == self.block => value,
            _ => {
                let value = self.constant(Bits::Pred(true));
                self.guard = Some((self.block, value));
                value
            }
        }
    }

    /// Ends the current block, and continues in a new one that nothing reaches yet.
    pub(super) fn end(&mut self, end: Terminator) {
        let block = &mut self.func.blocks[self.block];
        block.end = end;
        block.end_pos = self.pos;
        let next = self.func.add_block();
        self.enter(next);
    }

    /// Ends the current block by a jump, and goes on in another.
    pub(super) fn jump(&mut self, block: Block, args: Vec<Value>) {
        self.end(Terminator::Jump(Target { block, args }));
    }

    /// Goes on in a block.
    pub(super) fn enter(&mut self, block: Block) {
        self.block = block;
        self.order.push(block);
    }

    /// A new block with parameters.
    pub(super) fn new_block(&mut self, params: &[Ty]) -> Block {
        let block = self.func.add_block();
        for &ty in params {
            self.func.add_param(block, ty);
        }
        block
    }
}
