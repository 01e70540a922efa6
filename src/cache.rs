//! `srp cache`: what is kept from one run to the next.

use crate::cli::CacheAction;
use crate::failure::Failure;
use crate::talk::{self, CONSOLE};
use srp_toolchain::cache::{Cache, Counts, Found, Kind, Place};
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
            let text = counts.map(|counts| match json {
                true => json_of(&counts),
                false => text_of(&counts),
            });
            talk::print(text.unwrap_or_default())?;
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

fn json_of(counts: &Counts) -> String {
    let kinds: serde_json::Map<_, _> = Kind::ALL
        .into_iter()
        .map(|kind| {
            let found = counts.kinds.get(&kind).copied().unwrap_or_default();
            let value = serde_json::json!({ "entries": found.entries, "bytes": found.bytes });
            (kind.name().to_owned(), value)
        })
        .collect();
    let value = serde_json::json!({
        "folder": counts.folder.display().to_string(),
        "limit": counts.limit,
        "kinds": kinds,
    });
    format!("{value:#}\n")
}
