//! Names of variables, by the operations that make their values.
//!
//! Values have no names in the intermediate form: passes would have to carry them along. But before the passes every
//! variable is a slot, and what is stored there is made by an operation with a place in the source. After the passes,
//! the operation at that place still makes the variable's value, wherever it runs.

use srp_archdesc::isa::{Effect, Opcode};
use srp_ir::program::{Function, InstKind, Pos, Program, Value};
use std::collections::{BTreeMap, BTreeSet};

/// The names of variables.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    /// By the place of an operation, as `file:line:column`.
    at: BTreeMap<String, Operations>,
}

/// The operations at a place, before the passes.
#[derive(Clone, Debug, Default)]
struct Operations {
    /// Those whose value a variable gets.
    named: BTreeMap<Opcode, String>,
    /// The others.
    others: BTreeSet<Opcode>,
}

impl Variables {
    /// The names of a program as the front end makes it, before any pass.
    pub fn of(program: &Program) -> Variables {
        let mut at: BTreeMap<String, Operations> = BTreeMap::new();
        for function in program.funcs.values() {
            for (pos, opcode, name) in operations(function) {
                let file = program.files.get(pos.file).map_or("", String::as_str);
                let place = format!("{file}:{}:{}", pos.line, pos.column);
                let operations = at.entry(place).or_default();
                match name {
                    Some(name) => {
                        operations.named.insert(opcode, name);
                    }
                    None => {
                        operations.others.insert(opcode);
                    }
                }
            }
        }
        at.retain(|_, operations| !operations.named.is_empty());
        Variables { at }
    }

    /// The variable that gets the value of this operation at a place.
    pub fn name(&self, place: &str, opcode: Opcode) -> Option<&str> {
        let operations = self.at.get(place)?;
        let named = &operations.named;
        let exact = named.get(&opcode);
        // Several operations may have become one, which makes the value of the last.
        let fused = || match named.len() {
            1 if !operations.others.contains(&opcode) => named.values().next(),
            _ => None,
        };
        exact.or_else(fused).map(String::as_str)
    }
}

/// The operations of a function with their places, and the variables that get their values.
fn operations(function: &Function) -> Vec<(Pos, Opcode, Option<String>)> {
    let insts = || {
        let blocks = function.layout.iter();
        let insts = blocks.flat_map(|&block| &function.blocks[block].insts);
        insts.map(|&inst| &function.insts[inst])
    };
    let mut slots: BTreeMap<Value, &str> = BTreeMap::new();
    let mut stored: BTreeMap<Value, &str> = BTreeMap::new();
    for inst in insts() {
        match &inst.kind {
            InstKind::SlotAddr(slot, 0) => {
                let name = function.slots[*slot].name.as_str();
                slots.extend(inst.results.iter().map(|&value| (value, name)));
            }
            InstKind::Op { op, args, .. } if op.info().effect == Effect::Store => {
                if let [_, address, value] = args[..]
                    && let Some(name) = slots.get(&address)
                {
                    stored.insert(value, name);
                }
            }
            _ => {}
        }
    }
    let of_inst = |inst: &srp_ir::program::InstData| {
        let InstKind::Op { op, .. } = inst.kind else {
            return None;
        };
        let name = stored.get(inst.results.first()?);
        let name = name.filter(|name| !name.starts_with("temporary"));
        (inst.pos.line > 0).then(|| (inst.pos, op, name.map(|&name| name.to_owned())))
    };
    insts().filter_map(of_inst).collect()
}
