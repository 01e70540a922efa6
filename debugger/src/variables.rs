//! Variables, by the operations that make their values.
//!
//! Values have no names in the intermediate form: passes would have to carry them along. But before the passes every
//! variable is in slots, and what is stored there is made by an operation with a place in the source. After the passes,
//! the operation at that place still makes the variable's value, wherever it runs. Counters that no operation makes any
//! more are known from the division of the program.

use crate::stored::{Stored, insts};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Opcode;
use srp_ir::described::Described;
use srp_ir::program::{Bits, Func, Function, InstKind, Pos, Program, Slot};
use srp_ir::split::Counter;
use std::collections::{BTreeMap, BTreeSet};

/// The number of a [`Piece`].
pub(crate) type Name = u32;

/// The variables of a program, and the operations that make their values.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    /// By the place of an operation, as `file:line:column`.
    at: BTreeMap<String, Operations>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) described: Described,
    /// The names of the files.
    pub(crate) files: Vec<String>,
    /// The counters of each kernel, by its name.
    pub(crate) counters: BTreeMap<String, Vec<Counter>>,
    /// The places of the steps of `for` loops.
    steps: BTreeSet<String>,
}

/// A variable, or a part of one that is a value by itself.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) name: String,
    /// Its variable, by its number in [`Described::variables`].
    pub(crate) variable: Option<usize>,
    /// The function whose variable it is.
    pub(crate) function: String,
    /// Its size in bytes.
    pub(crate) size: u32,
    /// Where it is in its variable.
    pub(crate) offset: u32,
    /// The one constant that it ever gets.
    pub(crate) constant: Option<Bits>,
    /// It lies in memory.
    pub(crate) in_memory: bool,
    pub(crate) set: Set,
}

/// How a piece is set.
#[derive(Clone, Debug, Default)]
pub(crate) struct Set {
    /// How many places of the source set it.
    pub(crate) stores: usize,
    /// Those where the value is that of an operation, by the operation's place.
    pub(crate) by: BTreeMap<String, By>,
    /// Constants, copies and arguments are stored once, and before all else.
    pub(crate) others_come_first: bool,
}

/// An operation that makes a piece's value.
#[derive(Clone, Debug)]
pub(crate) struct By {
    /// Nothing else sets the piece in the innermost loop, or in the function where there is none.
    pub(crate) is_alone: bool,
    /// Not every iteration, or not every call, comes to it.
    pub(crate) is_conditional: bool,
    /// The value comes from what the piece was before.
    pub(crate) accumulates: bool,
    /// It is in a loop.
    pub(crate) is_in_loop: bool,
    /// The place of the innermost loop, where that may run on the array.
    pub(crate) of_loop: Option<String>,
}

impl Set {
    /// The reason for which control code cannot tell the value from its operations.
    pub(crate) fn doubt(&self) -> Option<&'static str> {
        if self.stores <= 1 {
            return None;
        }
        if self.by.values().any(|by| !by.is_alone) {
            return Some("several places set it, and what the compiler made of them is not known");
        }
        if self.by.values().any(|by| by.is_conditional) {
            return Some("a condition decides whether it changes, and operations may run before");
        }
        let why = "it also gets constants or copies, which no operation makes";
        (!self.others_come_first).then_some(why)
    }
}

/// The operations at a place, before the passes.
#[derive(Clone, Debug, Default)]
struct Operations {
    /// Those whose value variables get, with the constant operand.
    named: BTreeMap<Opcode, (Vec<Name>, Option<u32>)>,
    /// The others.
    others: BTreeSet<Opcode>,
}

impl Variables {
    /// The names of a program as the front end makes it, before any pass.
    pub fn of(program: &Program) -> Variables {
        Variables::with(program, Described::default(), BTreeMap::new())
    }

    /// The same, with types and scopes, and with the counters of the kernels.
    pub fn with(
        program: &Program,
        described: Described,
        counters: BTreeMap<String, Vec<Counter>>,
    ) -> Variables {
        let mut variables = Variables {
            files: program.files.values().cloned().collect(),
            counters,
            ..Variables::default()
        };
        let places = described.steps.iter().map(|&pos| variables.place(pos));
        variables.steps = places.collect();
        let mut numbers = BTreeMap::new();
        for (func, function) in program.funcs.iter() {
            variables.add(func, function, &mut numbers);
        }
        for (number, variable) in described.variables.iter().enumerate() {
            for &(slot, offset) in &variable.slots {
                if let Some(&piece) = numbers.get(&(variable.func, slot)) {
                    let piece: &mut Piece = &mut variables.pieces[piece as usize];
                    piece.variable = Some(number);
                    piece.offset = offset;
                    piece.name.clone_from(&variable.name);
                }
            }
        }
        variables
            .at
            .retain(|_, operations| !operations.named.is_empty());
        variables.described = described;
        variables
    }

    /// A place as positions of simulators have it.
    pub(crate) fn place(&self, pos: Pos) -> String {
        let file = self.files.get(pos.file.index()).map_or("", String::as_str);
        format!("{file}:{}:{}", pos.line, pos.column)
    }

    /// The variable that gets the value of this operation at a place.
    pub fn name(&self, place: &str, opcode: Opcode) -> Option<&str> {
        let first = *self.names(place, opcode).first()?;
        Some(&self.pieces[first as usize].name)
    }

    /// The pieces that get the value of this operation at a place.
    pub(crate) fn names(&self, place: &str, opcode: Opcode) -> &[Name] {
        self.operation(place, opcode)
            .map_or(&[], |(names, _)| names)
    }

    /// The constant operand of this operation at a place, before the passes.
    pub(crate) fn constant_operand(&self, place: &str, opcode: Opcode) -> Option<u32> {
        self.operation(place, opcode)?.1
    }

    fn operation(&self, place: &str, opcode: Opcode) -> Option<&(Vec<Name>, Option<u32>)> {
        let operations = self.at.get(place)?;
        let named = &operations.named;
        let exact = named.get(&opcode);
        // Several operations may have become one, which makes the value of the last.
        let fused = || match named.len() {
            1 if !operations.others.contains(&opcode) => named.values().next(),
            _ => None,
        };
        exact.or_else(fused)
    }

    /// True if the place is in the step of a `for` loop.
    pub(crate) fn is_step(&self, place: &str) -> bool {
        self.steps.contains(place)
    }

    fn add(&mut self, func: Func, function: &Function, numbers: &mut BTreeMap<(Func, Slot), Name>) {
        let stored = Stored::of(function);
        for (slot, data) in function.slots.iter() {
            if data.is_temporary() {
                continue;
            }
            numbers.insert((func, slot), self.pieces.len() as Name);
            let piece = Piece {
                name: data.name.clone(),
                function: function.name.clone(),
                size: data.size,
                offset: 0,
                variable: None,
                constant: stored.constant(slot),
                in_memory: stored.escaped.contains(&slot),
                set: self.set(&stored, slot),
            };
            self.pieces.push(piece);
        }
        for inst in insts(function) {
            let data = &function.insts[inst];
            let (InstKind::Op { op, args, .. }, Some(result)) = (&data.kind, data.results.first())
            else {
                continue;
            };
            if data.pos.line == 0 {
                continue;
            }
            let place = self.place(data.pos);
            let operations = self.at.entry(place).or_default();
            let slots = stored.slots.get(result).into_iter().flatten();
            let names: Vec<Name> = slots
                .filter_map(|slot| numbers.get(&(func, *slot)).copied())
                .collect();
            if names.is_empty() {
                operations.others.insert(*op);
                continue;
            }
            let constant = args.iter().find_map(|arg| match stored.constants.get(arg) {
                Some(Bits::Word(word)) => Some(*word),
                _ => None,
            });
            operations.named.insert(*op, (names, constant));
        }
    }

    /// How a slot is set.
    fn set(&self, stored: &Stored<'_>, slot: Slot) -> Set {
        let all = stored.stores.get(&slot).map_or(&[][..], Vec::as_slice);
        let by_operation = all.iter().filter_map(|store| {
            let pos = stored.maker(store)?;
            let by = By {
                is_alone: stored.is_alone(store, all),
                is_conditional: stored.is_conditional(store),
                accumulates: stored.reads(store.value, slot),
                is_in_loop: stored.is_in_loop(store),
                of_loop: stored.loop_of(store).map(|pos| self.place(pos)),
            };
            Some((self.place(pos), by))
        });
        let others = all.iter().filter(|store| stored.maker(store).is_none());
        Set {
            stores: all.len(),
            by: by_operation.collect(),
            others_come_first: { others }.all(|store| stored.comes_first(store, all)),
        }
    }
}
