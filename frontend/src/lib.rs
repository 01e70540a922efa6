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
pub mod bytes;
pub mod check;
mod classify;
pub mod ctype;
mod described;
pub mod interface;
mod lex;
pub mod library;
mod literal;
pub mod lower;
pub mod message;
mod operator;
mod options;
pub mod parse;
mod preprocess;
pub mod source;
pub mod token;
mod trouble;
pub mod typed;

pub use check::check;
pub use described::{WithDescription, compile_described};
pub use lower::lower;
pub use options::{Include, Included, Options, precision_macros};
pub use parse::parse;

use message::Messages;
use source::SourceMap;
use srp_archdesc::diagnostic::{Diagnostic, Source};
use srp_ir::Program;

/// A checked program with the texts and messages that it was made with.
pub(crate) struct Compilation {
    map: SourceMap,
    messages: Messages,
    checked: typed::Checked,
}

/// Compiles sources to one program, with warnings; or says all that is wrong with them.
pub fn compile(
    sources: &[Source],
    options: &Options<'_>,
) -> Result<(Program, Vec<Diagnostic>), Vec<Diagnostic>> {
    let Compilation {
        messages, checked, ..
    } = interface::compilation(sources, options)?;
    Ok((lower(&checked, options), messages.into_list()))
}
