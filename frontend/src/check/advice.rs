//! Advice where a name has no meaning: the header that has it, or the name that was probably meant.

use super::{Checker, Symbol, Tag};
use crate::ctype::{RecordId, Type, TypeTable};
use crate::library;
use srp_archdesc::nearest::nearest;

/// Letters of the shortest names that are taken for misspelt: any name of one letter is one edit from any other.
const SHORTEST: usize = 3;

/// `did you mean …?` with the nearest of some names.
fn did_you_mean<'c>(name: &str, names: impl IntoIterator<Item = &'c str>) -> Option<String> {
    if name.len() < SHORTEST {
        return None;
    }
    let long = names.into_iter().filter(|known| known.len() >= SHORTEST);
    let near = nearest(name, long).filter(|near| *near != name)?;
    Some(format!("did you mean `{near}`?"))
}

impl Checker<'_> {
    /// Advice about a value that is not declared.
    pub(super) fn advice_for_name(&self, name: &str) -> Option<String> {
        self.advice_among(name, |symbol| !matches!(symbol, Symbol::Typedef(_)))
    }

    /// Advice about a function that is called and not declared.
    pub(super) fn advice_for_function(&self, name: &str) -> Option<String> {
        self.advice_among(name, |symbol| matches!(symbol, Symbol::Function(_)))
    }

    fn advice_among(&self, name: &str, wanted: impl Fn(&Symbol) -> bool) -> Option<String> {
        // What is an operation is told so.
        if name.starts_with("__") {
            return None;
        }
        if let Some(header) = library::header_of(name) {
            return Some(header);
        }
        let known = self.names(wanted);
        let macros = self.sources.macros.iter().map(|name| &**name);
        let macros = macros.filter(|name| !name.ends_with("_H"));
        // What belongs to the program comes before what it could include.
        did_you_mean(name, known.into_iter().chain(macros))
            .or_else(|| did_you_mean(name, library::known_names().map(|known| known.name)))
    }

    /// Advice about a type that is not declared.
    pub(super) fn advice_for_type(&self, name: &str) -> Option<String> {
        let types = self.names(|symbol| matches!(symbol, Symbol::Typedef(_)));
        library::header_of(name).or_else(|| did_you_mean(name, types))
    }

    /// Advice about a struct or union of which nothing but the tag is known.
    pub(super) fn advice_for_record(&self, record: RecordId) -> Option<String> {
        let record = &self.types.records[record];
        let name = record.tag.as_deref()?;
        let union = record.union;
        let mut tags = Vec::new();
        for scope in self.scopes.iter().rev() {
            let here = scope.tags.iter().filter_map(|(tag, (kind, _))| match kind {
                Tag::Record(other) => {
                    let other = &self.types.records[*other];
                    (other.fields.is_some() && other.union == union).then_some(&**tag)
                }
                _ => None,
            });
            let start = tags.len();
            tags.extend(here);
            tags[start..].sort_unstable();
        }
        let kind = if union { "union" } else { "struct" };
        let near = (name.len() >= SHORTEST)
            .then(|| nearest(name, tags))
            .flatten();
        Some(format!("did you mean `{kind} {}`?", near?))
    }

    /// Advice about a member that a record does not have.
    pub(super) fn advice_for_member(&self, record: RecordId, name: &str) -> Option<String> {
        let mut members = Vec::new();
        members_of(&self.types, record, &mut members);
        did_you_mean(name, members)
    }

    /// Names in scope, the innermost first.
    fn names(&self, wanted: impl Fn(&Symbol) -> bool) -> Vec<&str> {
        let mut names = Vec::new();
        for scope in self.scopes.iter().rev() {
            let start = names.len();
            let here = scope.names.iter().filter(|(_, (symbol, _))| wanted(symbol));
            let here = here.map(|(name, _)| &**name);
            names.extend(here.filter(|name| !name.starts_with("__")));
            names[start..].sort_unstable();
        }
        names
    }
}

/// The members of a record, those of its anonymous ones included.
fn members_of<'t>(types: &'t TypeTable, record: RecordId, names: &mut Vec<&'t str>) {
    for field in types.records[record].fields.iter().flatten() {
        match (&field.name, types.get(field.ty.ty)) {
            (Some(name), _) => names.push(name),
            (None, Type::Record(inner)) => members_of(types, *inner, names),
            (None, _) => {}
        }
    }
}
