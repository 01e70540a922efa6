//! Any text is a file of cameras, a plan of a sweep, or two reports that are compared, by its first byte; or it is refused
//! with messages that can be shown. A line of hyphens stands between the reports.

use srp_archdesc::diagnostic::Source;
use srp_studies::sweep::{Plan, PlanFile};
use srp_studies::{Error, comparison};
use srp_toolchain::scene::Views;
use std::path::Path;

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let [kind, text @ ..] = data else {
        return;
    };
    let text = String::from_utf8_lossy(text);
    let done = match kind {
        0 => cameras(&text),
        1 => plan(&text),
        _ => reports(&text),
    };
    if let Err(error) = done {
        error.to_string();
    }
}

fn cameras(text: &str) -> Result<(), Error> {
    let views = Views::of(Source::new("cameras.json", text), "a")?;
    for number in 0..3 {
        views.camera(number)?;
    }
    Ok(())
}

fn plan(text: &str) -> Result<(), Error> {
    let plan = PlanFile::parse("plan.toml", text, Path::new(""))?;
    let again = PlanFile::parse("again.toml", &plan.to_toml(), Path::new(""))?;
    assert_eq!(again.to_toml(), plan.to_toml());
    // A machine that it names is of the disk.
    Plan::of(PlanFile {
        machine: None,
        ..plan
    })
    .map(drop)
}

fn reports(text: &str) -> Result<(), Error> {
    let (old, new) = text.split_once("\n---\n").unwrap_or((text, text));
    let [old, new] =
        [("old.json", old), ("new.json", new)].map(|(name, text)| Source::new(name, text));
    comparison::compare(&old, &new).map(drop)
}
