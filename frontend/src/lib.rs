//! C to [`Program`]: the compiler's front end.
//!
//! ```text
//! text ──preprocess──▶ tokens ──classify──▶ tokens ──grammar──▶ Unit ──check──▶ Checked ──lower──▶ Program
//! ```
//!
//! * [`parse`](mod@parse) makes a syntax tree ([`ast::Unit`]) of a source file. The lexer and
//!   preprocessor are written by hand, so that every token knows where the user wrote it; the
//!   grammar is LALRPOP's, with error recovery. Which identifiers name types is found between
//!   the two, by a reader of declarations, because a generated parser asks for its next token
//!   before the last one has had its effect.
//! * [`check`](mod@check) resolves names and types over all sources together, and makes every
//!   conversion explicit ([`typed::Checked`]). It alone knows the rules of C.
//! * [`lower`](mod@lower) makes SSA of that. It cannot fail: what it cannot lower was refused.
//!
//! All three report to [`message::Messages`], each message with a code and a place; a mistake in
//! one function does not hide those in the next. Files are the caller's business: [`Options`]
//! has the function that finds included ones.
//!
//! The language is C11 with 32-bit `long` and pointers, without variable-length arrays, complex
//! numbers, atomics and threads, which are refused by name; with the common GNU extensions, vectors
//! of four lanes (`float4`, `int4`), the qualifier `__srp_global` for what lies in system memory,
//! and the operations of the opcode table as functions `__srp_…`. `double` is software: see
//! [`Options::double_is_float`]. The [`library`] gives what a program uses and does not define.

pub mod ast;
pub mod check;
mod classify;
pub mod ctype;
mod lex;
pub mod library;
mod literal;
pub mod lower;
pub mod message;
mod operator;
pub mod parse;
mod preprocess;
pub mod source;
pub mod token;
pub mod typed;

pub use check::check;
pub use lower::lower;
pub use parse::parse;

use library::Archive;
use message::Messages;
use source::SourceMap;
use srp_archdesc::diagnostic::{Diagnostic, Source};
use srp_ir::Program;

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
    /// Finds included files. The name of the source it gives is shown in messages, and the same
    /// for the same file.
    pub resolve: &'a dyn Fn(&Include<'_>) -> Option<Source>,
    /// Marks innermost loops as kernels where no pragma does.
    pub auto_kernel: bool,
    /// `double` means `float`; each place where it does is told.
    pub double_is_float: bool,
    /// Floating constants without suffix are floats; each is told.
    pub single_constants: bool,
}

impl Default for Options<'_> {
    /// No macros, no included files, innermost loops marked.
    fn default() -> Self {
        Options {
            defines: Vec::new(),
            resolve: &|_| None,
            auto_kernel: true,
            double_is_float: false,
            single_constants: false,
        }
    }
}

impl std::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("defines", &self.defines)
            .field("auto_kernel", &self.auto_kernel)
            .finish_non_exhaustive()
    }
}

/// Compiles sources to one program, with warnings; or says all that is wrong with them.
pub fn compile(
    sources: &[Source],
    options: &Options<'_>,
) -> Result<(Program, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut map = SourceMap::new();
    let mut messages = Messages::new();
    let units: Vec<_> = sources
        .iter()
        .map(|source| parse(source, options, &mut map, &mut messages))
        .collect();
    let mut archive = Archive::of(&units);
    let mut library: Vec<ast::Unit> = Vec::new();
    while let Some(source) = archive.next(library.last()) {
        library.push(parse(&source, options, &mut map, &mut messages));
    }
    let program = check::Sources {
        units: &units,
        library: &library,
        owned: &archive.owned,
        map: &map,
    };
    let checked = check(&program, options, &mut messages);
    match checked {
        Some(checked) => Ok((lower(&checked, options), messages.into_list())),
        None => Err(messages.into_list()),
    }
}
