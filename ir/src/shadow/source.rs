//! Where errors come from: the operations of each line, and units outside.

use crate::program::{Func, Inst, InstKind, Program, SourceFile};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;
use std::collections::BTreeMap;

/// The source of an error: the operations of one kind on one line, or a unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file and the line; `None` for a unit outside of the program.
    pub at: Option<(SourceFile, u32)>,
    /// The operation, or the unit.
    pub what: Origin,
}

/// The kind of operation, or the unit, that makes an error. It prints as its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An operation of the program.
    Operation(Opcode),
    /// A unit outside of it.
    Unit(String),
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Origin::Operation(op) => op.fmt(f),
            Origin::Unit(name) => f.write_str(name),
        }
    }
}

/// All sources of a program, numbered: units first, then by file, line and operation.
#[derive(Clone, Debug)]
pub struct Sources {
    list: Vec<Source>,
    of: EntityMap<Func, EntityMap<Inst, u32>>,
}

impl Sources {
    /// Those of a program beside these units.
    pub fn of(program: &Program, units: &[&str]) -> Sources {
        let of_inst = |func: Func, inst: Inst| {
            let data = &program.funcs[func].insts[inst];
            let InstKind::Op { op, .. } = &data.kind else {
                return None;
            };
            // Operations of a line are numbered by their names.
            Some(((data.pos.file, data.pos.line), op.name(), *op))
        };
        let all = program.funcs.iter();
        let all = all.flat_map(|(func, data)| data.insts.keys().map(move |inst| (func, inst)));
        let mut numbers: BTreeMap<_, u32> = all
            .filter_map(|(func, inst)| Some((of_inst(func, inst)?, 0)))
            .collect();
        let unit = |what: &&str| Source {
            at: None,
            what: Origin::Unit((*what).to_owned()),
        };
        let mut list: Vec<Source> = units.iter().map(unit).collect();
        for (&(at, _, op), number) in &mut numbers {
            *number = list.len() as u32;
            list.push(Source {
                at: Some(at),
                what: Origin::Operation(op),
            });
        }
        let number = |func, inst| of_inst(func, inst).map_or(0, |source| numbers[&source]);
        let numbered = |(func, data): (Func, &crate::program::Function)| {
            data.insts.keys().map(|inst| number(func, inst)).collect()
        };
        Sources {
            of: program.funcs.iter().map(numbered).collect(),
            list,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The source with this number.
    pub fn get(&self, number: u32) -> Option<&Source> {
        self.list.get(number as usize)
    }

    /// All sources, by number.
    pub fn iter(&self) -> std::slice::Iter<'_, Source> {
        self.list.iter()
    }

    /// The number of the source that an operation is.
    pub(super) fn number(&self, func: Func, inst: Inst) -> u32 {
        self.of[func][inst]
    }
}
