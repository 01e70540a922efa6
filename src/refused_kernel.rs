//! Loops that a pragma asks onto the array, and that are not: errors with their places, or warnings
//! where the machine computes in software, which few loops have room for.

use crate::cli::ErrorFormat;
use crate::failure::Failure;
use crate::{diagnostics, files, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Diagnostic, Messages, Source, Span};
use srp_studies::loops::{self, NotPipelined, Subject};
use srp_toolchain::{Compiled, Session, Warnings};
use std::fmt::Write;

/// The code of the message, and what makes it a warning.
const CODE: &str = "C0604";
const HELP: &str = "`-Wno-error=kernel` lets such loops run on the VLIW engine";

/// Says which loops under `#pragma srp kernel` are not on the array, and fails unless that is allowed. It is on a
/// machine that lacks units: whoever took them out has less to compute with, and no other machine.
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
    if !compiled.not_pipelined.iter().any(|n| n.required) {
        return Ok(());
    }
    let subject = Subject::of_program(compiled);
    let report = loops::report(&subject, arch, &loops::Options::default(), session)?;
    let refused = report.not_pipelined.iter().filter(|n| n.required);
    let missing = arch.srp.in_software();
    if missing.is_empty() && warnings.refuses_kernels() {
        let messages = messages(refused, Diagnostic::error, HELP);
        return Err(Failure::Reported(diagnostics::show(&messages, format)));
    }
    let mut help = "it runs on the VLIW engine".to_owned();
    if !missing.is_empty() {
        let missing: Vec<String> = missing.iter().map(|class| format!("`{class}`")).collect();
        write!(help, "; no unit of the machine runs {}", missing.join(", ")).expect("to a string");
    }
    let messages = messages(refused, Diagnostic::warning, &help);
    talk::say_all(&diagnostics::show(&messages, format));
    Ok(())
}

/// A message for each loop.
fn messages<'a>(
    refused: impl Iterator<Item = &'a NotPipelined>,
    severity: fn(&'static str, &str, String) -> Diagnostic,
    help: &str,
) -> Messages {
    let mut messages = Messages::default();
    for n in refused {
        let text = files::source_text(&n.at.file);
        let what = format!("{} is not on the array: {}", n.kernel, n.reason);
        let message = severity(CODE, &n.at.file, what);
        let place = Span::of_word(&text, n.reason_at.line, n.reason_at.column);
        let head = Span::of_word(&text, n.at.line, n.at.column);
        let message = match n.reason_at.file == n.at.file && n.reason_at.line != n.at.line {
            true => message
                .at(place, "this stands in the way")
                .also(head, "of this loop"),
            false => message.at(head, "this loop").note(n.reason_at.to_string()),
        };
        messages.diagnostics.push(message.help(help));
        messages.sources.push(Source::new(n.at.file.as_str(), text));
    }
    messages
}
