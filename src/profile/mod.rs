//! Profiles as text, JSON, and a page: functions, loops, and the source with the cycles of each line.

mod drawing;
mod flame;
mod frame;
mod listing;
mod page;
mod text;

use crate::failure::Failure;
use crate::{document, files};
use listing::Listing;
use schemars::JsonSchema;
use serde::Serialize;
use srp_studies::comparison::PROFILE;
use srp_studies::profile::{Advice, Parts, Profile};
use srp_toolchain::envelope::{About, Contents};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A file that a profile goes to, in the form that its name asks for.
pub(crate) struct Target {
    path: PathBuf,
}

/// A profile as JSON.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Document<'a> {
    #[serde(flatten)]
    profile: &'a Profile,
    /// The text of each file that has lines in it, so that two profiles can be told apart line by line.
    sources: BTreeMap<&'a str, String>,
}

impl Contents for Document<'_> {
    const FORMAT: &'static str = PROFILE.format;
    const VERSION: u32 = PROFILE.version;
    const WRITTEN_BY: &'static str = PROFILE.written_by;
}

impl Target {
    /// A file of this name, which can be written.
    pub(crate) fn to(path: &Option<PathBuf>) -> Result<Option<Target>, Failure> {
        let Some(path) = path else {
            return Ok(None);
        };
        files::check_writable(path)?;
        Ok(Some(Target { path: path.clone() }))
    }

    /// Writes a profile of what `title` names and a document has as its subject.
    pub(crate) fn write(
        &self,
        title: &str,
        about: About,
        profile: &Profile,
    ) -> Result<(), Failure> {
        let extension = self.path.extension().and_then(|e| e.to_str());
        let text = match extension {
            Some("json") => {
                let document = Document {
                    profile,
                    sources: sources(profile),
                };
                document::json(about, &document)?
            }
            Some("html") => page::page(title, profile, &Listing::of(profile)),
            _ => text::text(title, profile, &Listing::of(profile)),
        };
        files::write(Path::new(&self.path), text.as_bytes())
    }
}

/// The text of each file that has lines in a profile.
fn sources(profile: &Profile) -> BTreeMap<&str, String> {
    let lines = profile.lines.iter().filter(|l| l.line > 0);
    let files: BTreeSet<&str> = lines.map(|l| l.file.as_str()).collect();
    let text = |file| (file, files::source_text(file));
    files.into_iter().map(text).collect()
}

/// The parts in the order of [`Parts::named`]: the class, which is its colour, and words.
const PARTS: [(&str, &str); Parts::COUNT] = [
    ("p-vliw", "VLIW bundles with operations"),
    (
        "p-empty",
        "VLIW bundles without: results or branches are waited for",
    ),
    ("p-array", "loops on the array"),
    ("p-switch", "changes between VLIW engine and array"),
    ("p-memory", "the core stands still for its data cache"),
    ("p-texture", "the core stands still for its texture cache"),
    (
        "p-code",
        "the core stands still for a bundle that is not in its instruction cache",
    ),
    ("p-code", "the core stands still for the contexts of a loop"),
    ("p-banks", "the core stands still for banks of its SRAM"),
    (
        "p-wait",
        "the core waits for a port, in a frame for the T&I unit",
    ),
];

/// A part of the cycles in words, by its name.
fn in_words(part: &str) -> &'static str {
    let mut all = PARTS.iter().zip(Parts::default().named());
    all.find(|(_, (name, _))| *name == part)
        .map_or("", |((_, words), _)| words)
}

/// The class of the largest part, the first of those that are as large.
fn class_of(parts: &Parts) -> &'static str {
    let named = parts.named();
    let largest = (0..named.len()).max_by_key(|&i| (named[i].1, named.len() - i));
    PARTS[largest.unwrap_or(0)].0
}

/// True if the energy of lines is known: that of a frame.
fn has_energy(profile: &Profile) -> bool {
    let frame = profile.frame.as_ref();
    frame.is_some_and(|frame| !frame.energy_of_lines.is_empty())
}

/// An energy in µJ, nothing where there is none.
fn microjoules(mj: f64) -> String {
    match mj > 0.0 {
        true => format!("{:.2}", 1e3 * mj),
        false => String::new(),
    }
}

/// The id of a line.
fn anchor(line: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    format!("line-{}", line.chars().map(plain).collect::<String>())
}

/// The arguments that try an advice, for the command that was given.
fn tried(advice: &Advice) -> String {
    format!("try it with {}", advice.arguments().join(" "))
}

/// Cycles as a part of others, in per cent.
fn percent(cycles: u64, of: u64) -> String {
    format!("{:.1}", 100.0 * cycles as f64 / of.max(1) as f64)
}

/// The largest costs of single lines: line, part, and cycles.
fn largest(profile: &Profile) -> Vec<(String, &'static str, u64)> {
    let lines = profile.lines.iter().filter(|l| l.line > 0);
    let mut costs: Vec<(String, &'static str, u64)> = lines
        .flat_map(|l| {
            let name = format!("{}:{}", l.file, l.line);
            (l.parts.named().into_iter()).map(move |(part, cycles)| (name.clone(), part, cycles))
        })
        .filter(|(.., cycles)| *cycles > 0)
        .collect();
    costs.sort_by(|a, b| b.2.cmp(&a.2).then_with(|| a.0.cmp(&b.0)));
    costs.truncate(LARGEST);
    costs
}

/// Single costs that are told first.
const LARGEST: usize = 6;

/// The parts that a profile has any cycles in, so that others need no column.
fn columns(parts: &Parts) -> Vec<usize> {
    let named = parts.named();
    (0..named.len()).filter(|&i| named[i].1 > 0).collect()
}
