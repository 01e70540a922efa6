//! `srp accuracy --pixel X,Y`: where a pixel parts from binary64, and what follows from it.

use crate::cli::Accuracy as Args;
use crate::failure::Failure;
use crate::talk;
use schemars::JsonSchema;
use serde::Serialize;
use srp_studies::accuracy;
use srp_studies::attribution::Explanation;
use srp_toolchain::Frame;
use srp_toolchain::envelope::{About, Contents};
use std::fmt::Write as _;

/// Contributions that are told.
const MOST_TOLD: usize = 12;

/// Explains a pixel of the scene on the machine as it is.
pub(super) fn run(frame: &Frame, args: &Args, pixel: (u32, u32)) -> Result<(), Failure> {
    let found = accuracy::explain(frame, pixel)?;
    let reference = accuracy::in_reference(frame, pixel);
    talk::print(match args.json {
        true => {
            let about = About::scene(&frame.arch, &frame.scene);
            crate::document::json(about, &document(&found, pixel, reference))?
        }
        false => text(&found, pixel, reference),
    })?;
    Ok(())
}

fn place(at: &str, what: &str) -> String {
    format!("{at} {what}").trim().to_owned()
}

/// The explanation of a pixel. Of a place in the program `at` is `file:line`, and empty outside of it; `what` is the
/// operation or the unit.
#[derive(Serialize, JsonSchema)]
pub(crate) struct PixelDocument {
    /// The pixel's column.
    x: u32,
    /// The pixel's row.
    y: u32,
    /// Its tile.
    tile: u32,
    /// Red, green and blue in levels from 0 to 255.
    value: [f64; 3],
    /// The same by the same program in binary64.
    exact: [f64; 3],
    /// The same by the renderer in binary64, which the picture is held against.
    reference: [f64; 3],
    /// Decisions on its way that binary64 makes otherwise.
    flips: Vec<PixelFlip>,
    /// The first operation that parts from binary64 by more than rounding, and those that hand this on.
    chain: Vec<PixelStep>,
    /// What contributes to the error, the largest first.
    contributions: Vec<PixelContribution>,
}

impl Contents for PixelDocument {
    const FORMAT: &'static str = "srp-pixel";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp accuracy --pixel X,Y --json`";
}

/// A decision that binary64 makes otherwise.
#[derive(Serialize, JsonSchema)]
struct PixelFlip {
    /// The kind of decision.
    kind: &'static str,
    at: String,
    what: String,
    /// The decision in words.
    decision: String,
}

/// An operation on the way to a pixel.
#[derive(Serialize, JsonSchema)]
struct PixelStep {
    at: String,
    what: String,
    /// Its result.
    value: f64,
    /// The same in binary64.
    exact: f64,
    /// The difference in units of the last place.
    ulps: f64,
    /// The effect of the difference on the pixel, in levels.
    effect: f64,
}

/// What an operation or a unit contributes.
#[derive(Serialize, JsonSchema)]
struct PixelContribution {
    at: String,
    what: String,
    /// Levels of red, green and blue.
    levels: [f64; 3],
}

fn document(found: &Explanation, (x, y): (u32, u32), reference: [f64; 3]) -> PixelDocument {
    let flips = found.flips.iter().map(|(at, what, flip)| PixelFlip {
        kind: flip.kind.name(),
        at: at.clone(),
        what: what.clone(),
        decision: flip.what.to_string(),
    });
    let chain = found.chain.iter().map(|step| PixelStep {
        at: step.at.clone(),
        what: step.what.clone(),
        value: f64::from(step.value),
        exact: step.exact,
        ulps: step.ulps,
        effect: step.effect,
    });
    let contributions = found.contributions.iter();
    let contributions = contributions.map(|(at, what, levels)| PixelContribution {
        at: at.clone(),
        what: what.clone(),
        levels: *levels,
    });
    PixelDocument {
        x,
        y,
        tile: found.tile,
        value: found.pixel.value,
        exact: found.pixel.exact,
        reference,
        flips: flips.collect(),
        chain: chain.collect(),
        contributions: contributions.collect(),
    }
}

/// The part of a level that kernels add before a value becomes a byte.
const HALF_LEVEL: f64 = 0.5;

/// Fewer levels, the renderer's own formulas against those of the kernels, no byte shows.
const SEEN: f64 = 0.1;

/// True if the program in binary64 is farther from the renderer in binary64 than the run is from the program, though both
/// decide alike.
fn elsewhere(found: &Explanation, reference: [f64; 3]) -> bool {
    let off = |a: [f64; 3], b: [f64; 3]| {
        let channels = a.into_iter().zip(b).map(|(a, b)| (a - b).abs());
        channels.fold(0.0, f64::max)
    };
    let pixel = &found.pixel;
    let shown = pixel.exact.map(|x| x - HALF_LEVEL);
    let unlike = off(shown, reference) > off(pixel.value, pixel.exact).max(SEEN);
    found.flips.is_empty() && unlike
}

fn text(found: &Explanation, (x, y): (u32, u32), reference: [f64; 3]) -> String {
    let mut text = String::new();
    let rgb = |c: [f64; 3]| format!("{:.3} {:.3} {:.3}", c[0], c[1], c[2]);
    let _ = writeln!(
        text,
        "pixel {x},{y} of tile {}: {} of 255 levels before it becomes bytes",
        found.tile,
        rgb(found.pixel.value),
    );
    let _ = writeln!(
        text,
        "  {} by the same program in binary64, {} by the renderer in binary64",
        rgb(found.pixel.exact),
        rgb(reference)
    );
    let _ = match elsewhere(found, reference) {
        true => writeln!(
            text,
            "  the two differ by more than roundings do, and by more than the half level that is added for the rounding to \
             bytes: the kernels compute something else (an approximation, another formula)"
        ),
        false => Ok(()),
    };
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
