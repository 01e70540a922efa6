//! The checked program to SSA.
//!
//! Every variable becomes stack slots, read and written where it is used; turning those into
//! values is the business of the passes. A variable whose address nobody takes becomes one slot
//! for each scalar in it, each as wide as a word or vector, so that the passes can promote them
//! all; any other is one slot, laid out as C says.
//!
//! Loops are rotated: the condition is tested before the loop and again at its bottom, so that
//! the body of an innermost loop is one stretch of code once conditionals in it are gone.
//!
//! Structs of few members pass as their members, in order, as parameters and results. Larger ones
//! pass as the address of a copy that belongs to the callee; for a large result the caller
//! passes the address of room for it before the parameters.

mod aggregate;
mod condition;
mod control;
mod expr;
mod function;
mod leaf;
mod place;
mod reach;
mod scalar;
mod start;
mod units;
mod vector;

use crate::options::Options;
use crate::typed::{Address, Checked, FunctionId, ObjectId};
use function::KernelNames;
pub(crate) use function::Places;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::program::{Func, Global, GlobalData, Program, Reloc, Symbol};

/// Where the things of a checked program are in the program.
struct Symbols {
    objects: EntityMap<ObjectId, Option<Global>>,
    functions: EntityMap<FunctionId, Option<Func>>,
}

impl Symbols {
    fn object(&self, object: ObjectId) -> Symbol {
        Symbol::Global(self.objects[object].expect("what is used was found to be reached"))
    }

    fn func(&self, function: FunctionId) -> Func {
        self.functions[function].expect("what is used was found to be reached")
    }

    fn address(&self, address: Address) -> Symbol {
        match address {
            Address::Object(object) => self.object(object),
            Address::Function(function) => Symbol::Func(self.func(function)),
        }
    }
}

/// Lowers a checked program. Functions and objects of one source that nothing uses are left out.
pub fn lower(checked: &Checked, options: &Options<'_>) -> Program {
    lower_with_places(checked, options).0
}

/// Where the variables of each function are.
pub(crate) type PlacesOf = Vec<(Func, FunctionId, Places)>;

/// [`lower`], with the slots of all variables.
pub(crate) fn lower_with_places(checked: &Checked, options: &Options<'_>) -> (Program, PlacesOf) {
    let symbols = number(checked, options);
    let mut program = Program {
        files: checked.files.clone(),
        ..Program::default()
    };
    for (id, object) in checked.objects.iter() {
        if symbols.objects[id].is_none() {
            continue;
        }
        let relocs = object.image.addresses.iter();
        let relocs = relocs.map(|&(offset, address, addend)| Reloc {
            offset,
            symbol: symbols.address(address),
            addend,
        });
        program.globals.push(GlobalData {
            name: object.name.clone(),
            // An initial value may go on in a member of unknown length.
            size: (checked.types.size(object.ty.ty).unwrap_or(0))
                .max(object.image.bytes.len() as u32),
            align: checked.types.align(object.ty.ty).max(object.align),
            init: object.image.bytes.clone(),
            relocs: relocs.collect(),
            pos: object.pos,
        });
    }
    let mut kernels = KernelNames::default();
    let mut wishes = EntityMap::new();
    let mut places = Vec::new();
    for (id, function) in checked.functions.iter() {
        let (Some(func), Some(body)) = (symbols.functions[id], &function.body) else {
            continue;
        };
        if function.name == "main" && !function.internal {
            program.main = Some(func);
        }
        let lowered = function::lower(checked, &symbols, function, body, options, &mut kernels);
        program.funcs.push(lowered.0);
        places.push((func, id, lowered.2));
        wishes.push(units::Wishes {
            loops: lowered.1,
            fixed: function.optional && function.name != "sqrtf",
        });
    }
    units::choose(&mut program, &wishes, options, &mut kernels);
    start::with_arguments(&mut program);
    (program, places)
}

/// Numbers everything reached from the functions that other sources know.
fn number(checked: &Checked, options: &Options<'_>) -> Symbols {
    let reached = reach::of(checked, &options.software().collect());
    let mut next = 0;
    let mut symbols = Symbols {
        objects: EntityMap::new(),
        functions: EntityMap::new(),
    };
    for object in checked.objects.keys() {
        let global = reached.objects.contains(&object).then(|| Global::new(next));
        next += usize::from(global.is_some());
        symbols.objects.push(global);
    }
    next = 0;
    for function in checked.functions.keys() {
        let func = reached
            .functions
            .contains(&function)
            .then(|| Func::new(next));
        next += usize::from(func.is_some());
        symbols.functions.push(func);
    }
    symbols
}
