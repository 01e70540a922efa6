//! Loops that a pragma asks onto the array, and that are not: errors with their places.

use crate::cli::ErrorFormat;
use crate::diagnostics;
use crate::failure::Failure;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Diagnostic, Messages, Source, Span};
use srp_studies::loops::{self, NotPipelined, Subject};
use srp_toolchain::{Compiled, Session, Warnings};

/// The code of the message, and what turns it off.
const CODE: &str = "C0604";
const HELP: &str = "`-Wno-error=kernel` lets such loops run on the VLIW engine";

/// Fails where a loop under `#pragma srp kernel` is not on the array, unless that is allowed.
///
/// # Errors
///
/// The loops, each with its lines.
pub(crate) fn check(
    compiled: &Compiled,
    arch: &Arch,
    warnings: &Warnings,
    format: ErrorFormat,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let required = compiled.not_pipelined.iter().any(|n| n.required);
    if !required || !warnings.refuses_kernels() {
        return Ok(());
    }
    let subject = Subject::of_program(compiled);
    let report = loops::report(&subject, arch, &loops::Options::default(), session)?;
    let refused = report.not_pipelined.iter().filter(|n| n.required);
    Err(Failure::Reported(show(refused, format)))
}

fn show<'a>(refused: impl Iterator<Item = &'a NotPipelined>, format: ErrorFormat) -> String {
    let mut messages = Messages::default();
    for n in refused {
        let text = std::fs::read_to_string(&n.at.file).unwrap_or_default();
        let what = format!("{} is not on the array: {}", n.kernel, n.reason);
        let message = Diagnostic::error(CODE, &n.at.file, what);
        let place = span(&text, n.reason_at.line, n.reason_at.column);
        let head = span(&text, n.at.line, n.at.column);
        let message = match n.reason_at.file == n.at.file && n.reason_at.line != n.at.line {
            true => message
                .at(place, "this stands in the way")
                .also(head, "of this loop"),
            false => message.at(head, "this loop").note(n.reason_at.to_string()),
        };
        messages.diagnostics.push(message.help(HELP));
        messages.sources.push(Source::new(n.at.file.as_str(), text));
    }
    diagnostics::show(&messages, format)
}

/// The word at a line and column, in characters from 1.
fn span(text: &str, line: u32, column: u32) -> Span {
    let lines = text
        .split_inclusive('\n')
        .take(line.saturating_sub(1) as usize);
    let start: usize = lines.map(str::len).sum();
    let rest = &text[start..];
    let before = rest.chars().take(column.saturating_sub(1) as usize);
    let start = start + before.map(char::len_utf8).sum::<usize>();
    let word = text[start..].chars();
    let word: usize = word
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .map(char::len_utf8)
        .sum();
    Span::new(start as u32, (start + word.max(1)).min(text.len()) as u32)
}
