//! What the user wants to hear: which warnings, in which form.

use crate::cli::{self, ErrorFormat};
use crate::failure::Failure;
use crate::talk;
use serde_json::{Value, json};
use srp_archdesc::diagnostic::{Diagnostic, Label, Severity, Source, render, tally};
use srp_frontend::message::{warning_name, warning_names};

/// What `-W` says about one warning.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Level {
    Off,
    Warn,
    Error,
}

/// The messages after `-W`: some left out, some errors; each warning says how it is called.
pub(crate) fn chosen(messages: Vec<Diagnostic>, args: &cli::Source) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    for mut message in messages {
        let name = warning_name(message.code);
        if let (true, Some(name)) = (message.severity != Severity::Error, name) {
            match level(&args.warnings, name) {
                Level::Off => continue,
                Level::Error if message.severity == Severity::Warning => {
                    message.severity = Severity::Error;
                }
                _ => {}
            }
        }
        out.push(message);
    }
    out
}

fn level(wishes: &[String], name: &str) -> Level {
    let mut level = Level::Warn;
    for wish in wishes {
        match wish.as_str() {
            "none" => level = Level::Off,
            "all" | "extra" if level == Level::Off => level = Level::Warn,
            "error" if level == Level::Warn => level = Level::Error,
            "no-error" if level == Level::Error => level = Level::Warn,
            wish if wish == name && level == Level::Off => level = Level::Warn,
            wish if wish.strip_prefix("no-error=") == Some(name) => level = Level::Warn,
            wish if wish.strip_prefix("no-") == Some(name) => level = Level::Off,
            wish if wish.strip_prefix("error=") == Some(name) => level = Level::Error,
            _ => {}
        }
    }
    level
}

/// Whether every `-W` names something.
pub(crate) fn check_names(args: &cli::Source) -> Result<(), Failure> {
    for wish in &args.warnings {
        let general = ["all", "extra", "none", "error", "no-error"];
        let bare = wish.strip_prefix("no-").unwrap_or(wish);
        let bare = bare.strip_prefix("error=").unwrap_or(bare);
        if !general.contains(&wish.as_str()) && !warning_names().any(|name| name == bare) {
            let names: Vec<_> = warning_names().collect();
            return Err(Failure::Message(format!(
                "`-W {wish}` names no warning; there are all, none, error and {}",
                names.join(", ")
            )));
        }
    }
    Ok(())
}

/// Messages as the command line wants them.
pub(crate) fn show(
    messages: &[Diagnostic],
    format: ErrorFormat,
    text: &dyn Fn(&str) -> Option<String>,
) -> String {
    match format {
        ErrorFormat::Human => {
            let mut out = srp_frontend::message::render_all(messages, text, talk::colour());
            out.push_str(&tally(messages));
            out
        }
        ErrorFormat::Json => {
            let lines = messages.iter().map(|message| {
                let source = Source::new(
                    message.file.as_str(),
                    text(&message.file).unwrap_or_default(),
                );
                format!("{}\n", as_json(message, &source))
            });
            lines.collect()
        }
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
