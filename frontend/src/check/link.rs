//! Linkage: one name, one thing, in all sources.

use super::{Checker, Symbol};
use crate::ast;
use crate::ctype::{Difference, Record, Type, TypeId};
use crate::library;
use crate::message::{IMPLICIT_FUNCTION, REDECLARED, UNDEFINED};
use crate::source::Name;
use crate::typed::*;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity::EntityMap;
use std::collections::{BTreeMap, BTreeSet};

/// A definition: where, in which source, and whether it is more than tentative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Definition {
    pub(super) span: Span,
    pub(super) unit: usize,
    pub(super) full: bool,
}

/// Objects and functions with linkage: their names, definitions and first uses.
#[derive(Debug, Default)]
pub(super) struct Externals {
    /// Names with external linkage.
    pub(super) names: BTreeMap<Name, Symbol>,
    pub(super) objects: BTreeMap<ObjectId, Definition>,
    pub(super) functions: BTreeMap<FunctionId, Definition>,
    /// First use of each.
    used_objects: BTreeMap<ObjectId, Span>,
    used_functions: BTreeMap<FunctionId, Span>,
    /// How many operands around are not evaluated: what they name needs no definition.
    unevaluated: u32,
}

impl Externals {
    pub(super) fn use_object(&mut self, object: ObjectId, span: Span) {
        if self.unevaluated == 0 {
            self.used_objects.entry(object).or_insert(span);
        }
    }

    pub(super) fn use_function(&mut self, function: FunctionId, span: Span) {
        if self.unevaluated == 0 {
            self.used_functions.entry(function).or_insert(span);
        }
    }
}

/// Functions of the standard headers that are declared, and that the library does not have.
const NOT_IN_LIBRARY: [&str; 3] = ["atof", "strtod", "strtof"];

impl Checker<'_> {
    /// An operand whose type alone counts.
    pub(super) fn unevaluated(&mut self, e: ast::ExprId) -> super::Operand {
        self.externals.unevaluated += 1;
        let operand = self.quietly(|checker| checker.operand(e));
        self.externals.unevaluated -= 1;
        operand
    }

    /// Notes a definition; a second one is an error.
    pub(super) fn define(&mut self, symbol: Symbol, name: &str, definition: Definition) {
        let before = match symbol {
            Symbol::Object(object) => self.externals.objects.get(&object),
            Symbol::Function(function) => self.externals.functions.get(&function),
            _ => None,
        };
        let mut definition = definition;
        if let Some(before) = before.copied() {
            if before.full && definition.full || before.unit != definition.unit {
                let text = format!("`{name}` is defined a second time");
                let message = self.sources.error(REDECLARED, definition.span, text, "");
                let message = self.sources.also(message, before.span, "defined here");
                self.messages.push(message);
                return;
            }
            if before.full {
                definition = before;
            }
        }
        match symbol {
            Symbol::Object(object) => {
                self.externals.objects.insert(object, definition);
                self.objects[object].defined = true;
            }
            Symbol::Function(function) => {
                self.externals.functions.insert(function, definition);
            }
            _ => {}
        }
    }

    /// At the end of a source: its tentative definitions are complete.
    pub(super) fn end_of_unit(&mut self) {
        let here = self.externals.objects.iter();
        let here: Vec<_> = here
            .filter(|(_, definition)| definition.unit == self.number)
            .map(|(object, definition)| (*object, definition.span))
            .collect();
        for (object, span) in here {
            let ty = self.objects[object].ty.ty;
            if !self.is_error(ty) {
                self.complete(ty, span, "an object");
            }
        }
    }

    /// Reports names that are used and never defined, and makes names unique.
    pub(super) fn link(&mut self) {
        let mut missing = Vec::new();
        for (object, span) in std::mem::take(&mut self.externals.used_objects) {
            if !self.objects[object].defined {
                missing.push((span, self.objects[object].name.clone()));
            }
        }
        for (function, span) in std::mem::take(&mut self.externals.used_functions) {
            let defined = self.externals.functions.contains_key(&function);
            if !defined && !self.is_error(self.functions[function].ty) {
                missing.push((span, self.functions[function].name.clone()));
            }
        }
        missing.sort();
        for (span, name) in missing {
            if let Some(advice) = self.implicit.remove(&span) {
                let text = format!("the function `{name}` is neither declared nor defined");
                let mut message = self.sources.error(UNDEFINED, span, text, "");
                message.help = match NOT_IN_LIBRARY.contains(&name.as_str()) {
                    true => Some("this C library has no such function".to_owned()),
                    false => advice,
                };
                self.messages.replace(IMPLICIT_FUNCTION, message);
                continue;
            }
            let text = format!("`{name}` is used but defined in no source");
            let help = match name.as_str() {
                name if NOT_IN_LIBRARY.contains(&name) => "this C library has no such function",
                name if library::is_intrinsic(name) => "`#include \"srp.h\"` declares it",
                _ => {
                    self.error(UNDEFINED, span, text, "");
                    continue;
                }
            };
            self.error_help(UNDEFINED, span, text, help);
        }
        self.check_main();
        let external_objects = self.external_ids(|symbol| match symbol {
            Symbol::Object(object) => Some(object),
            _ => None,
        });
        unique(&mut self.objects, &external_objects, |o| &mut o.name);
        let external_functions = self.external_ids(|symbol| match symbol {
            Symbol::Function(function) => Some(function),
            _ => None,
        });
        unique(&mut self.functions, &external_functions, |f| &mut f.name);
    }

    fn external_ids<T: Ord>(&self, pick: impl Fn(Symbol) -> Option<T>) -> BTreeSet<T> {
        let symbols = self.externals.names.values();
        symbols.filter_map(|&symbol| pick(symbol)).collect()
    }

    fn check_main(&mut self) {
        let Some(&Symbol::Function(main)) = self.externals.names.get("main") else {
            return;
        };
        let ty = self.functions[main].ty;
        let definition = self.externals.functions.get(&main).copied();
        let (Some(definition), Type::Function(signature)) = (definition, self.types.get(ty)) else {
            return;
        };
        let known = self.types.known;
        let counts = |&ty: &TypeId| self.types.is_integer(ty) && !self.types.is_wide(ty);
        let points = |&ty: &TypeId| self.types.pointee(ty).is_some();
        let params = match signature.params.as_slice() {
            [] => true,
            [count] => counts(count),
            [count, rest @ ..] => rest.len() <= 2 && counts(count) && rest.iter().all(points),
        };
        let result = signature.result == known.int || signature.result == known.void;
        if !result || !params || signature.variadic {
            let text = "`main` takes nothing, or a count and strings, and returns an `int`";
            let help = "write `int main(void)`";
            self.error_help(REDECLARED, definition.span, text, help);
        }
    }

    /// Returns the composite type of a name's two declarations; reports an error if they are not
    /// compatible.
    pub(super) fn same_declaration(
        &mut self,
        name: &str,
        old: TypeId,
        new: TypeId,
        span: Span,
        before: Span,
    ) -> TypeId {
        if self.is_error(old) || self.is_error(new) {
            return old;
        }
        if !self.types.compatible(old, new) {
            let text = format!(
                "`{name}` is declared as {} here and as {} before",
                self.show(new),
                self.show(old)
            );
            let mut message = self.sources.error(REDECLARED, span, text, "");
            if before != Span::default() {
                message = self.sources.also(message, before, "declared here");
            }
            if let Some(difference) = self.types.difference(old, new) {
                message = message.note(self.difference(difference));
            }
            self.messages.push(message);
            // What uses the name by either declaration is no further mistake.
            return self.types.known.error;
        }
        match self.types.get(old) {
            Type::Array(_, None) => new,
            // One defined in the old style stays as it takes its arguments.
            Type::Function(signature) if signature.open && signature.params.is_empty() => new,
            _ => old,
        }
    }
}

impl Checker<'_> {
    /// Tells where two records of one tag differ.
    fn difference(&self, difference: Difference) -> String {
        let (old, new) = difference.records;
        let name = self.types.record_name(new);
        let [old, new] = [old, new].map(|record| &self.types.records[record]);
        let place = self.sources.show(old.span);
        let Some(number) = difference.member else {
            return format!("{name} is laid out otherwise at {place}");
        };
        let member = |record: &Record| {
            let field = record.fields.as_ref()?.get(number)?;
            let mut text = self
                .types
                .declares(field.ty, field.name.as_deref().unwrap_or(""));
            if let Some(bits) = field.bits {
                text += &format!(" : {}", bits.width);
            }
            Some(format!("`{text}`"))
        };
        let ordinal = number + 1;
        match (member(new), member(old)) {
            (Some(new), Some(old)) if new == old => {
                format!(
                    "member {ordinal} of {name}, {new}, is another type or lies elsewhere at {place}"
                )
            }
            (Some(new), Some(old)) => {
                format!("member {ordinal} of {name} is {new} here and {old} at {place}")
            }
            (Some(new), None) => {
                format!("{name} has a member {ordinal}, {new}, here and none at {place}")
            }
            (None, old) => {
                let old = old.unwrap_or_default();
                format!("{name} has no member {ordinal} here and {old} at {place}")
            }
        }
    }
}

/// Gives a number to names that are taken; those of `external` stay as they are.
fn unique<K: srp_archdesc::entity::Entity, V>(
    items: &mut EntityMap<K, V>,
    external: &BTreeSet<K>,
    name: impl Fn(&mut V) -> &mut String,
) {
    let mut taken = BTreeSet::new();
    for (key, item) in items.iter_mut() {
        if external.contains(&key) {
            taken.insert(name(item).clone());
        }
    }
    let mut next: BTreeMap<String, u32> = BTreeMap::new();
    for (key, item) in items.iter_mut() {
        if external.contains(&key) {
            continue;
        }
        let base = name(item).clone();
        let mut candidate = base.clone();
        while !taken.insert(candidate.clone()) {
            let number = next.entry(base.clone()).or_insert(1);
            *number += 1;
            candidate = format!("{base}.{number}");
        }
        *name(item) = candidate;
    }
}
