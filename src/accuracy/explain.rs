//! `srp accuracy --pixel X,Y`: where a pixel parts from binary64, and what follows from it.

use crate::cli::Accuracy as Args;
use crate::failure::Failure;
use crate::talk;
use serde_json::json;
use srp_studies::accuracy;
use srp_studies::attribution::Explanation;
use srp_toolchain::Frame;
use std::fmt::Write as _;

/// Contributions that are told.
const MOST_TOLD: usize = 12;

/// Explains a pixel of the scene on the machine as it is.
pub(super) fn run(frame: &Frame, args: &Args, pixel: (u32, u32)) -> Result<(), Failure> {
    let found = accuracy::explain(frame, pixel)?;
    talk::print(match args.json {
        true => serde_json::to_string_pretty(&members(&found, pixel))
            .map(|text| text + "\n")
            .map_err(Failure::message)?,
        false => text(&found, pixel),
    })?;
    Ok(())
}

fn place(at: &str, what: &str) -> String {
    format!("{at} {what}").trim().to_owned()
}

fn members(found: &Explanation, (x, y): (u32, u32)) -> serde_json::Value {
    let flips = found.flips.iter().map(|(at, what, flip)| {
        json!({ "kind": flip.kind.name(), "at": at, "what": what, "decision": flip.what })
    });
    let chain = found.chain.iter().map(|s| {
        json!({ "at": s.at, "what": s.what, "value": f64::from(s.value), "exact": s.exact,
                "ulps": s.ulps, "effect": s.effect })
    });
    let contributions = (found.contributions.iter())
        .map(|(at, what, error)| json!({ "at": at, "what": what, "levels": error }));
    json!({
        "x": x, "y": y, "tile": found.tile,
        "value": found.pixel.value, "exact": found.pixel.exact,
        "flips": flips.collect::<Vec<_>>(),
        "chain": chain.collect::<Vec<_>>(),
        "contributions": contributions.collect::<Vec<_>>(),
    })
}

fn text(found: &Explanation, (x, y): (u32, u32)) -> String {
    let mut text = String::new();
    let rgb = |c: [f64; 3]| format!("{:.3} {:.3} {:.3}", c[0], c[1], c[2]);
    let _ = writeln!(
        text,
        "pixel {x},{y} of tile {}: {} of 255 levels, {} in binary64",
        found.tile,
        rgb(found.pixel.value),
        rgb(found.pixel.exact)
    );
    let _ = match found.flips.is_empty() {
        true => writeln!(text, "every decision on its way falls as in binary64"),
        false => writeln!(text, "decisions on its way that binary64 makes otherwise:"),
    };
    for (at, what, flip) in &found.flips {
        let _ = writeln!(
            text,
            "  {}: {}: {}",
            flip.kind.name(),
            place(at, what),
            flip.what
        );
    }
    if found.chain.is_empty() {
        text += "no operation parts from binary64 by more than rounding\n";
    } else {
        text += "the first operation that parts from binary64, and what hands it on:\n";
        let _ = writeln!(
            text,
            "  {:>16} {:>22} {:>12} {:>10}  operation",
            "value", "binary64", "ulp", "levels"
        );
    }
    for s in &found.chain {
        let _ = writeln!(
            text,
            "  {:>16} {:>22} {:>12.1} {:>10.2e}  {}",
            s.value,
            s.exact,
            s.ulps,
            s.effect,
            place(&s.at, &s.what)
        );
    }
    text += "what contributes to its error, in levels of red, green and blue:\n";
    for (at, what, error) in found.contributions.iter().take(MOST_TOLD) {
        let [r, g, b] = error;
        let _ = writeln!(
            text,
            "  {r:>10.2e} {g:>10.2e} {b:>10.2e}  {}",
            place(at, what)
        );
    }
    text
}
