//! Mistakes in one machine file, gathered until the end: reading goes on after a mistake, with a value that
//! causes no further ones.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Diagnostic, Severity, Span};

/// More mistakes than this are not gathered: the rest of the file is hardly a machine.
const MAX_FINDINGS: usize = 50;

/// The mistakes found so far.
pub(super) struct Findings {
    file: String,
    found: RefCell<Vec<Diagnostic>>,
    /// Parts that could not be read in full: name, and the elements that they are parts of.
    suspects: RefCell<BTreeMap<String, BTreeSet<Span>>>,
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

    /// A warning about what stands at `span`.
    pub(super) fn warning(
        &self,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
    ) -> Diagnostic {
        Diagnostic {
            severity: Severity::Warning,
            ..self.error(code, span, message, label)
        }
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
        let mut suspects = self.suspects.borrow_mut();
        suspects.entry(name.to_owned()).or_default().insert(element);
    }

    /// True if the part `name` of the element at `element` could not be read in full.
    pub(super) fn suspects(&self, element: Span, name: &str) -> bool {
        let suspects = self.suspects.borrow();
        suspects.get(name).is_some_and(|s| s.contains(&element))
    }

    /// True if a part with one of these names could not be read in full, in any element.
    pub(super) fn suspects_any(&self, names: &[&str]) -> bool {
        let suspects = self.suspects.borrow();
        names.iter().any(|&name| suspects.contains_key(name))
    }

    /// Notes that the value at `span` was reported and is to be taken as not given.
    pub(super) fn void(&self, span: Span) {
        self.suspect(span, "");
    }

    /// True if the value at `span` is to be taken as not given.
    pub(super) fn is_void(&self, span: Span) -> bool {
        self.suspects(span, "")
    }

    /// How many mistakes were found so far.
    pub(super) fn len(&self) -> usize {
        self.found.borrow().len()
    }

    /// True if further mistakes would not be shown.
    pub(super) fn is_full(&self) -> bool {
        self.len() > MAX_FINDINGS
    }

    /// True if nothing was found.
    pub(super) fn is_empty(&self) -> bool {
        self.found.borrow().is_empty()
    }

    /// Everything found, in the order of the file.
    pub(super) fn into_sorted(self) -> Vec<Diagnostic> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|d| d.primary.as_ref().map(|label| label.span));
        if found.len() > MAX_FINDINGS {
            found.truncate(MAX_FINDINGS);
            found.push(Diagnostic {
                severity: Severity::Note,
                ..Diagnostic::error(
                    "A0109",
                    &self.file,
                    format!("there are more mistakes; the first {MAX_FINDINGS} found are shown"),
                )
            });
        }
        found
    }
}
