//! C to [`Program`](srp_ir::Program).
pub mod ast;
mod classify;
mod lex;
mod literal;
pub mod message;
pub mod parse;
mod preprocess;
pub mod source;
pub mod token;

use srp_archdesc::diagnostic::Source;

/// A file that a source asks for with `#include`.
#[derive(Clone, Copy, Debug)]
pub struct Include<'a> {
    /// The name as written.
    pub name: &'a str,
    /// The name of the file that asks.
    pub from: &'a str,
    /// Written `<name>`, not `"name"`.
    pub system: bool,
}

/// What the caller decides.
#[derive(Clone)]
pub struct Options<'a> {
    /// Macros defined before each source: name and body.
    pub defines: Vec<(String, String)>,
    /// Finds included files.
    pub resolve: &'a dyn Fn(&Include<'_>) -> Option<Source>,
    /// Marks innermost loops as kernels where no pragma does.
    pub auto_kernel: bool,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            defines: Vec::new(),
            resolve: &|_| None,
            auto_kernel: true,
        }
    }
}
