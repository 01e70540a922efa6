//! Messages about C in the form that the command line asks for.

use crate::cli::ErrorFormat;
use crate::failure::Failure;
use crate::talk;
use serde_json::{Value, json};
use srp_archdesc::diagnostic::{Diagnostic, Label, Messages, Source, render};
use srp_toolchain::Error;

/// Messages as the command line wants them.
pub(crate) fn show(messages: &Messages, format: ErrorFormat) -> String {
    match format {
        ErrorFormat::Human => messages.render(talk::colour()),
        ErrorFormat::Json => {
            let lines = messages.diagnostics.iter().map(|message| {
                let source = Source::new(message.file.as_str(), messages.text(&message.file));
                format!("{}\n", as_json(message, &source))
            });
            lines.collect()
        }
    }
}

/// The failure of an error, whose messages are in the form that is wanted.
pub(crate) fn failure(error: Error, format: ErrorFormat) -> Failure {
    match error {
        Error::Messages(messages) => Failure::Reported(show(&messages, format)),
        error => error.into(),
    }
}

/// A message in the shape of rustc's, which editors know.
fn as_json(message: &Diagnostic, source: &Source) -> Value {
    let primary = message
        .primary
        .iter()
        .map(|label| span(label, source, true));
    let secondary = message
        .secondary
        .iter()
        .map(|label| span(label, source, false));
    let child = |level: &str, text: &str| {
        json!({
            "message": text, "code": null, "level": level, "spans": [], "children": [],
            "rendered": null,
        })
    };
    let notes = message.notes.iter().map(|text| child("note", text));
    let help = message.help.iter().map(|text| child("help", text));
    json!({
        "$message_type": "diagnostic",
        "message": message.message,
        "code": { "code": message.code, "explanation": null },
        "level": message.severity.to_string(),
        "spans": primary.chain(secondary).collect::<Vec<_>>(),
        "children": notes.chain(help).collect::<Vec<_>>(),
        "rendered": format!("{}\n\n", render(message, &source.text, false)),
    })
}

fn span(label: &Label, source: &Source, primary: bool) -> Value {
    let (start, end) = (label.span.start, label.span.end.max(label.span.start));
    let (line, column) = source.line_column(start);
    let (last_line, last_column) = source.line_column(end);
    let shown = source.text.lines().nth(line as usize - 1).unwrap_or("");
    let to = if last_line == line {
        last_column
    } else {
        shown.chars().count() as u32 + 1
    };
    let text = (!label.text.is_empty()).then_some(label.text.as_str());
    json!({
        "file_name": source.name, "byte_start": start, "byte_end": end,
        "line_start": line, "line_end": last_line,
        "column_start": column, "column_end": last_column,
        "is_primary": primary,
        "text": [{ "text": shown, "highlight_start": column, "highlight_end": to }],
        "label": text, "suggested_replacement": null, "suggestion_applicability": null,
        "expansion": null,
    })
}
