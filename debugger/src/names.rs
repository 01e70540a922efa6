//! Names in expressions: variables, objects, registers, and counts that stand for the place.

use crate::evaluate::{At, Named, word};
use crate::expression::{Expression, Operand};
use crate::session::Session;
use crate::show::FrameOf;
use srp_archdesc::isa::Ty;
use srp_ir::dre::scheduled::DataSymbol;

/// A name that stands for the place.
#[derive(Clone, Copy, Debug)]
enum Count {
    Iteration,
    Cycle,
    Core,
}

impl Count {
    fn named(name: &str) -> Option<Count> {
        match name {
            "iteration" => Some(Count::Iteration),
            "cycle" => Some(Count::Cycle),
            "core" => Some(Count::Core),
            _ => None,
        }
    }
}

impl Session<'_> {
    pub(crate) fn by_name(&self, at: &At, name: &str) -> Result<Named, String> {
        if let Some(variable) = self.local(&at.spot, name) {
            return Ok(Named::Typed(self.variable(at, variable)));
        }
        if let Some(symbol) = self.symbol(name) {
            return Ok(match self.described().objects.get(&symbol.name) {
                Some(&ty) => Named::Typed(self.in_memory(at, symbol.address, ty)),
                None => Named::Words(at.core, symbol.address),
            });
        }
        if let Some(found) = self.register(at.core, name, None) {
            return found;
        }
        let count = match (Count::named(name), at.of) {
            (Some(Count::Iteration), FrameOf::Iteration(iteration)) => iteration as u32,
            (Some(Count::Iteration), FrameOf::Call(_)) => {
                return Err("there is no iteration here: no loop is on the array".to_owned());
            }
            (Some(Count::Cycle), _) => self.cycle() as u32,
            (Some(Count::Core), _) => at.core,
            (None, _) => return Err(self.not_here(name)),
        };
        Ok(Named::Plain(Ty::Word, word(count)))
    }

    /// Says of a name that has a value elsewhere where that is.
    fn not_here(&self, name: &str) -> String {
        let mut variables = self.described().variables.iter();
        let declared = variables.find(|variable| variable.name == name);
        let declared = declared.map_or(String::new(), |v| {
            let place = self.code.variables.place(v.from);
            format!(": it is declared at {place}, and goes to line {}", v.to)
        });
        format!("`{name}` cannot be named here{declared}")
    }

    /// An object by its name; one inside a function, whose name goes before it, by its own too.
    fn symbol(&self, name: &str) -> Option<&DataSymbol> {
        let exact = self.symbols.iter().find(|symbol| symbol.name == name);
        let ends = |symbol: &&DataSymbol| {
            let own = symbol.name.rsplit_once('.').map(|(_, own)| own);
            own == Some(name) && Count::named(name).is_none()
        };
        exact.or_else(|| self.symbols.iter().find(ends))
    }

    /// A register by its name, or one of a file by its index.
    pub(crate) fn register(
        &self,
        core: u32,
        name: &str,
        index: Option<i64>,
    ) -> Option<Result<Named, String>> {
        let mut stores = self.spec.stores.iter().zip(&self.names.stores);
        let (store, _) = stores.find(|(_, known)| *known == name)?;
        let index = match index {
            None if store.size > 1 => {
                let why = format!("`{name}` has {} registers: write {name}[0]", store.size);
                return Some(Err(why));
            }
            index => index.unwrap_or(0),
        };
        if !(0..i64::from(store.size)).contains(&index) {
            return Some(Err(format!(
                "`{name}` has registers 0 to {}",
                store.size - 1
            )));
        }
        let snapshot = self.cores[core as usize].get().snapshot();
        let cell = snapshot.cells.get(store.base as usize + index as usize)?;
        Some(Ok(Named::Plain(store.ty, *cell)))
    }

    pub(crate) fn is_object_or_store(&self, name: &str) -> bool {
        self.symbols.iter().any(|symbol| symbol.name == name)
            || self.names.stores.iter().any(|store| store == name)
    }

    /// The first name of an expression that has a value nowhere: no variable, object, register or count has the name.
    pub(crate) fn unknown_name<'e>(&self, expression: &'e Expression) -> Option<&'e str> {
        let right = expression.right.as_ref().map(|(_, operand)| operand);
        let mut operands = std::iter::once(&expression.left).chain(right);
        operands.find_map(|operand| self.unknown_in(operand))
    }

    fn unknown_in<'e>(&self, operand: &'e Operand) -> Option<&'e str> {
        match operand {
            Operand::Integer(_) | Operand::Real(_) => None,
            Operand::At(inner) | Operand::Of(inner) => self.unknown_in(inner),
            Operand::Element(of, index) => self.unknown_in(of).or_else(|| self.unknown_in(index)),
            Operand::Member(inner, _) => {
                let dotted = operand.dotted();
                match dotted.is_some_and(|name| self.is_object_or_store(&name)) {
                    true => None,
                    false => self.unknown_in(inner),
                }
            }
            Operand::Name(name) => {
                let is_known = Count::named(name).is_some()
                    || self.is_object_or_store(name)
                    || self.symbol(name).is_some()
                    || self.described().variables.iter().any(|v| v.name == *name)
                    || self.code.knows(name);
                (!is_known).then_some(name)
            }
        }
    }
}
