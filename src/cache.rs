//! `srp cache`: what is kept from one run to the next.

use crate::cli::CacheAction;
use crate::document;
use crate::failure::Failure;
use crate::talk::{self, CONSOLE};
use schemars::JsonSchema;
use serde::Serialize;
use srp_toolchain::cache::{Cache, Counts, Found, Kind, Place};
use srp_toolchain::envelope::{About, Contents};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Runs `srp cache`; 1 where entries were damaged.
pub(crate) fn run(action: CacheAction) -> Result<i32, Failure> {
    let place = Place::of_user();
    if place == Place::Temporary {
        return Err(Failure::message(
            "there is no cache: neither SRP_CACHE nor XDG_CACHE_HOME nor HOME says where it is",
        ));
    }
    let cache = Cache::at(place);
    match action {
        CacheAction::Show { json } => {
            let counts = cache.counts(&CONSOLE);
            if let Some(counts) = counts {
                talk::print(match json {
                    true => document::json(About::default(), &Document::of(&counts))?,
                    false => text_of(&counts),
                })?;
            }
        }
        CacheAction::Clean => {
            let removed = cache.clean(&CONSOLE).unwrap_or_default();
            talk::say(format_args!("removed {}", in_words(removed)));
        }
        CacheAction::Verify => {
            let (whole, damaged) = cache.verify(&CONSOLE).unwrap_or_default();
            for (path, damage) in &damaged {
                talk::say(format_args!("removed {}: {damage}", path.display()));
            }
            let count = damaged.len();
            talk::say(format_args!("{} whole, {count} damaged", in_words(whole)));
            return Ok(i32::from(!damaged.is_empty()));
        }
    }
    Ok(0)
}

fn in_words(found: Found) -> String {
    format!("{} entries, {}", found.entries, bytes(found.bytes))
}

fn bytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn text_of(counts: &Counts) -> String {
    let mut text = format!("{}\n", counts.folder.display());
    let mut all = Found::default();
    for kind in Kind::ALL {
        let found = counts.kinds.get(&kind).copied().unwrap_or_default();
        all.entries += found.entries;
        all.bytes += found.bytes;
        let (name, entries, size) = (kind.name(), found.entries, bytes(found.bytes));
        writeln!(text, "  {name:<12} {entries:>7} entries {size:>11}").expect("a string has room");
    }
    let (entries, size, limit) = (all.entries, bytes(all.bytes), bytes(counts.limit));
    writeln!(
        text,
        "  {:<12} {entries:>7} entries {size:>11} of {limit} (SRP_CACHE_LIMIT)",
        "all"
    )
    .expect("a string has room");
    text
}

/// What is kept.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Document {
    /// The folder.
    folder: String,
    /// Bytes that it may have.
    limit: u64,
    /// By what is kept.
    kinds: BTreeMap<&'static str, Kept>,
}

impl Contents for Document {
    const FORMAT: &'static str = "srp-cache";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp cache show --json`";
}

/// The entries of a kind.
#[derive(Serialize, JsonSchema)]
struct Kept {
    /// How many there are.
    entries: u64,
    /// Their bytes.
    bytes: u64,
}

impl Document {
    fn of(counts: &Counts) -> Document {
        let kept = |kind: Kind| {
            let found = counts.kinds.get(&kind).copied().unwrap_or_default();
            let kept = Kept {
                entries: found.entries,
                bytes: found.bytes,
            };
            (kind.name(), kept)
        };
        Document {
            folder: counts.folder.display().to_string(),
            limit: counts.limit,
            kinds: Kind::ALL.into_iter().map(kept).collect(),
        }
    }
}
