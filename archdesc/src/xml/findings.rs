//! What is found wrong in one machine file, gathered until the end: reading goes on after a
//! mistake, with a value that causes no further ones.

use std::cell::RefCell;
use std::collections::BTreeSet;

use crate::diagnostic::{Diagnostic, Span};

/// More mistakes than this are not gathered: the rest of the file is hardly a machine.
const MAX_FINDINGS: usize = 100;

/// The mistakes found so far.
pub(super) struct Findings {
    file: String,
    found: RefCell<Vec<Diagnostic>>,
    suspects: RefCell<BTreeSet<(Span, String)>>,
}

impl Findings {
    /// Nothing found yet in the file of this name.
    pub(super) fn new(file: &str) -> Findings {
        Findings {
            file: file.to_owned(),
            found: RefCell::default(),
            suspects: RefCell::default(),
        }
    }

    /// An error that stands at `span`, to be completed and given to [`push`](Self::push).
    pub(super) fn error(
        &self,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
    ) -> Diagnostic {
        Diagnostic::error(code, &self.file, message).at(span, label)
    }

    /// Keeps a mistake.
    pub(super) fn push(&self, diagnostic: Diagnostic) {
        if !self.is_full() {
            self.found.borrow_mut().push(diagnostic);
        }
    }

    /// Notes that the part `name` of the element at `element` could not be read in full, so that
    /// rules about what the file lacks would blame it twice.
    pub(super) fn suspect(&self, element: Span, name: &str) {
        self.suspects
            .borrow_mut()
            .insert((element, name.to_owned()));
    }

    /// Whether the part `name` of the element at `element` could not be read in full.
    pub(super) fn suspects(&self, element: Span, name: &str) -> bool {
        let key = (element, name.to_owned());
        self.suspects.borrow().contains(&key)
    }

    /// Whether a part with one of these names could not be read in full, in any element.
    pub(super) fn suspects_any(&self, names: &[&str]) -> bool {
        let suspects = self.suspects.borrow();
        suspects
            .iter()
            .any(|(_, name)| names.contains(&name.as_str()))
    }

    /// How many mistakes were found so far.
    pub(super) fn len(&self) -> usize {
        self.found.borrow().len()
    }

    /// Whether further mistakes would not be shown.
    pub(super) fn is_full(&self) -> bool {
        self.len() > MAX_FINDINGS
    }

    /// Whether nothing was found.
    pub(super) fn is_empty(&self) -> bool {
        self.found.borrow().is_empty()
    }

    /// Everything found, in the order of the file.
    pub(super) fn into_sorted(self) -> Vec<Diagnostic> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|d| d.primary.as_ref().map(|label| label.span));
        if found.len() > MAX_FINDINGS {
            found.truncate(MAX_FINDINGS);
            found.push(
                Diagnostic::error("A0109", &self.file, "too many mistakes")
                    .note(format!("only {MAX_FINDINGS} are shown")),
            );
        }
        found
    }
}
