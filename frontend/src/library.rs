//! The C library: headers for `#include <…>`, and sources for the names that a program uses and
//! does not define itself, as an archive has them.
//!
//! Function definitions begin in the first column. So the sources need not be parsed to find the
//! one that defines a name.

use crate::ast::{Derived, ExprKind, Item, Spec, Storage, Unit};
use crate::source::Name;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::nearest::nearest;
use srp_kernels::{File, libc};
use std::collections::{BTreeSet, HashSet};

/// The source with the functions of [`Support`](crate::operator::Support).
const SUPPORT: &str = "support.c";

/// The function that computes and detects overflow, for `__builtin_add_overflow` and the like.
pub(crate) const OVERFLOW: &str = "__srp_overflow";

fn source(file: &File) -> Source {
    Source::new(file.path, file.text)
}

/// A header of the library.
pub fn header(name: &str) -> Option<Source> {
    libc::header(name).map(source)
}

/// The text of a file of the library, by the name that messages know it by.
pub fn text(name: &str) -> Option<&'static str> {
    libc::at(name).map(|file| file.text)
}

/// The library sources that a program has been given, and the names that it may still need.
#[derive(Default)]
pub(crate) struct Archive {
    /// Names that the program mentions and does not define.
    mentioned: HashSet<Name>,
    /// Names that the program defines itself, for all of its sources. The library goes by its own
    /// definitions of them.
    pub(crate) owned: HashSet<Name>,
    support: bool,
    taken: BTreeSet<&'static str>,
}

impl Archive {
    /// Collects the names that the sources of a program mention and define; `wanted` are names that it needs
    /// besides.
    pub(crate) fn of(units: &[Unit], wanted: impl Iterator<Item = String>) -> Archive {
        let mut archive = Archive::default();
        archive.mentioned.extend(wanted.map(Name::from));
        for unit in units {
            archive.look_at(unit);
            let functions = unit.items.iter().filter_map(|item| match item {
                Item::Function(function) => {
                    let mut specs = function.specs.list.iter();
                    let internal = specs.any(|(spec, _)| {
                        matches!(spec, Spec::Storage(Storage::Static) | Spec::Inline)
                    });
                    (!internal).then_some(&function.declarator)
                }
                _ => None,
            });
            let objects = unit.items.iter().filter_map(|item| match item {
                Item::Declaration(declaration) => Some(declaration),
                _ => None,
            });
            let objects = objects
                .filter(|declaration| {
                    let mut specs = declaration.specs.list.iter();
                    !specs.any(|(spec, _)| {
                        matches!(
                            spec,
                            Spec::Storage(Storage::Typedef | Storage::Extern | Storage::Static)
                        )
                    })
                })
                .flat_map(|declaration| &declaration.declarators)
                .map(|item| &item.declarator)
                .filter(|declarator| {
                    let first = declarator.derived.first().map(|(step, _)| step);
                    !matches!(first, Some(Derived::Function(_) | Derived::OldStyle(_)))
                });
            let names = functions.chain(objects).filter_map(|d| d.name.as_ref());
            archive.owned.extend(names.map(|(name, _)| name.clone()));
        }
        let owned = &archive.owned;
        archive.mentioned.retain(|name| !owned.contains(name));
        archive
    }

    /// Notes the names that a unit mentions.
    fn look_at(&mut self, unit: &Unit) {
        self.support |= unit.wide;
        for expr in unit.exprs.values() {
            if let ExprKind::Name(name) = &expr.kind {
                self.mentioned.insert(plain(name).into());
                self.mentioned.insert(name.clone());
                if name.starts_with("__builtin_") && name.ends_with("_overflow") {
                    self.mentioned.insert(OVERFLOW.into());
                }
            }
        }
    }

    /// Returns the next source that defines a name that the program mentions. `last` is the unit
    /// parsed from the source before.
    pub(crate) fn next(&mut self, last: Option<&Unit>) -> Option<Source> {
        if let Some(unit) = last {
            self.look_at(unit);
        }
        let wanted = |name: &str| self.mentioned.contains(name);
        let found = libc::SOURCES.iter().find(|file| {
            let support = self.support && file.name == SUPPORT;
            !self.taken.contains(file.name) && (support || defined(file.text).any(wanted))
        })?;
        self.taken.insert(found.name);
        Some(source(found))
    }
}

/// The function that a name stands for: `__builtin_abs` is `abs`.
pub(crate) fn plain(name: &str) -> &str {
    name.strip_prefix("__builtin_").unwrap_or(name)
}

/// The functions that a source of the library defines, and its objects.
fn defined(text: &'static str) -> impl Iterator<Item = &'static str> {
    let lines = text.lines().filter(|line| {
        let first = line.chars().next();
        let static_ = line.starts_with("static ") || line.starts_with("typedef ");
        first.is_some_and(|c| c.is_ascii_alphabetic() || c == '_') && !static_
    });
    lines.filter_map(|line| {
        let end = line.find(['(', ';', '=', '['])?;
        let head = line[..end].trim_end();
        let start = head.rfind(|c: char| !c.is_ascii_alphanumeric() && c != '_')?;
        Some(&head[start + 1..])
    })
}

/// A name that a header declares or defines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub(crate) name: &'static str,
    /// It is a macro.
    is_macro: bool,
    header: &'static File,
}

/// The names that the headers of the library and `srp.h` have for programs.
pub(crate) fn known_names() -> impl Iterator<Item = Known> {
    let srp = srp_kernels::header("srp.h");
    let headers = libc::HEADERS.iter().chain(srp);
    headers.flat_map(|header| {
        let names = header.text.lines().filter_map(|line| {
            let (name, is_macro) = match line.strip_prefix("#define ") {
                Some(rest) => (rest.split(|c| !is_letter(c)).next()?, true),
                None => (declared(line)?, false),
            };
            let known = Known {
                name,
                is_macro,
                header,
            };
            Some(known).filter(|known| !known.name.starts_with('_'))
        });
        // `srp.h` has operations for all, and names for other compilers.
        names.filter(|known| known.header.name != "srp.h" || known.name.starts_with("srp_"))
    })
}

/// The name that a line of a header declares: a function, an object or a type.
fn declared(line: &'static str) -> Option<&'static str> {
    if !line.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        return None;
    }
    let end = match line.starts_with("typedef ") {
        true => line.rfind(';')?,
        false => line.find(['(', ';', '='])?,
    };
    let head = line[..end].trim_end();
    let start = head.rfind(|c| !is_letter(c))?;
    Some(&head[start + 1..]).filter(|name| !name.is_empty())
}

fn is_letter(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Advice to include the header that has a name.
pub(crate) fn header_of(name: &str) -> Option<String> {
    let known = known_names().find(|known| known.name == name)?;
    let include = match known.header.name {
        "srp.h" => "\"srp.h\"".to_owned(),
        header => format!("<{header}>"),
    };
    let verb = if known.is_macro && known.header.name != "srp.h" {
        "defines"
    } else {
        "declares"
    };
    Some(format!("`#include {include}` {verb} it"))
}

/// `did you mean …?` with the header of the product nearest to a name that no file has.
pub(crate) fn nearest_header(name: &str) -> Option<String> {
    let headers = libc::HEADERS.iter().chain(srp_kernels::HEADERS);
    let near = nearest(name, headers.map(|header| header.name))?;
    let near = match libc::header(near) {
        Some(_) => format!("<{near}>"),
        None => format!("\"{near}\""),
    };
    Some(format!("did you mean `{near}`?"))
}

/// True when `srp.h` declares a function of this name.
pub(crate) fn is_intrinsic(name: &str) -> bool {
    let header = srp_kernels::header("srp.h").map_or("", |header| header.text);
    let has = |text: String| header.contains(&text);
    name.starts_with("srp_") && (has(format!(" {name}(")) || has(format!("#define {name} ")))
}
