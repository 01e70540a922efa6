//! `srp diff`: what got slower and faster between two runs.

use crate::cli::Diff;
use crate::count::count;
use crate::failure::Failure;
use crate::files::Kind;
use crate::{document, files, report, talk};
use srp_archdesc::diagnostic::Source;
use srp_studies::comparison::{self, Change, Comparison, FRAME, PROFILE, Section};
use srp_studies::loops::Report;
use srp_toolchain::envelope::{self, About, Contents, Expected};
use std::fmt::Write;
use std::path::Path;

/// Changes that are shown of each section, slower and faster.
const SHOWN: usize = 8;

/// Runs `srp diff`: 1 where the second run is slower.
pub(crate) fn run(args: &Diff) -> Result<i32, Failure> {
    let [old, new] = [read(&args.old)?, read(&args.new)?];
    let formats = [FRAME, PROFILE, Expected::of::<Report>()];
    let [first, second] = [
        envelope::read(&old, &formats)?,
        envelope::read(&new, &formats)?,
    ];
    envelope::of_one_format((&old, &first), (&new, &second))?;
    if first.format == Report::FORMAT {
        return report::compare(&old, &new, args.json);
    }
    let comparison = comparison::compare(&old, &new)?;
    talk::print(match args.json {
        true => document::json(About::default(), &comparison)?,
        false => text(&comparison, if args.all { usize::MAX } else { SHOWN }),
    })?;
    Ok(i32::from(comparison.is_slower(args.tolerance)))
}

/// A document that is compared.
fn read(path: &Path) -> Result<Source, Failure> {
    let text = files::read_text(path, Kind::Report)?;
    Ok(Source::new(path.display().to_string(), text))
}

/// A comparison as text, with so many changes of each section.
fn text(comparison: &Comparison, shown: usize) -> String {
    let mut out = String::new();
    write_text(&mut out, comparison, shown).expect("writing to a string cannot fail");
    out
}

fn write_text(out: &mut String, c: &Comparison, shown: usize) -> std::fmt::Result {
    let [old, new] = &c.machines;
    if old != new {
        let [old, new] = report::machines_in_words(&c.machines);
        writeln!(out, "machine: {old} → {new}")?;
    }
    for note in &c.notes {
        writeln!(out, "note: {note}")?;
    }
    let cycles = &c.cycles;
    writeln!(out, "{}: {} cycles", cycles.what, arrow(cycles))?;
    for figure in c.figures.iter().filter(|f| f.difference() != 0.0) {
        writeln!(out, "{}: {}", figure.what, arrow(figure))?;
    }
    for section in &c.sections {
        write_section(out, section, shown)?;
    }
    Ok(())
}

fn write_section(out: &mut String, section: &Section, shown: usize) -> std::fmt::Result {
    if section.changes.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{}", section.name)?;
    let changes = &section.changes;
    // What grew is at the front, what shrank at the end.
    let shown = shown.min(changes.len());
    let grown = changes.iter().filter(|c| c.difference() >= 0.0).count();
    let first = grown.min(shown);
    let last = (changes.len() - grown).min(shown);
    let rows = || (changes[..first].iter()).chain(&changes[changes.len() - last..]);
    let wide = |of: &dyn Fn(&Change) -> usize| rows().map(of).max().unwrap_or(0);
    let name = wide(&|c| c.what.chars().count());
    let [old, new, by] = [
        wide(&|c| side(c.old).chars().count()),
        wide(&|c| side(c.new).chars().count()),
        wide(&|c| signed(c.difference()).chars().count()),
    ];
    for c in rows() {
        let (from, to, more) = (side(c.old), side(c.new), signed(c.difference()));
        let unit = section.unit;
        write!(
            out,
            "  {:name$}  {from:>old$} → {to:>new$}  {more:>by$} {unit}",
            c.what
        )?;
        writeln!(out, "{}", percent(c))?;
        if !c.why.is_empty() {
            writeln!(out, "  {:name$}    {}", "", c.why.join(", "))?;
        }
    }
    let hidden = changes.len() - first - last;
    if hidden > 0 {
        writeln!(
            out,
            "  and {}: --all",
            count(hidden as u64, "smaller change")
        )?;
    }
    Ok(())
}

/// Both figures, and by how much they differ.
fn arrow(change: &Change) -> String {
    let (old, new) = (side(change.old), side(change.new));
    format!("{old} → {new}{}", percent(change))
}

fn side(figure: Option<f64>) -> String {
    figure.map_or("-".to_owned(), figure_text)
}

/// A figure: whole numbers in groups of three digits, others with six significant digits.
fn figure_text(figure: f64) -> String {
    if figure.fract() != 0.0 {
        let digits = 5 - (figure.abs().log10().floor() as i32).clamp(-6, 5);
        return format!("{figure:.*}", digits as usize);
    }
    let digits = format!("{:.0}", figure.abs());
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

fn signed(difference: f64) -> String {
    let sign = match difference {
        d if d > 0.0 => "+",
        d if d < 0.0 => "−",
        _ => "",
    };
    format!("{sign}{}", figure_text(difference.abs()))
}

/// By how much a figure differs, as a part of the first.
fn percent(change: &Change) -> String {
    match (change.old, change.new) {
        (Some(old), Some(_)) if old != 0.0 => {
            format!(" ({:+.1} %)", 100.0 * change.difference() / old)
        }
        _ => String::new(),
    }
}
