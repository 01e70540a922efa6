//! The limits that the results of a kernel have to keep to.

use super::Measure;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// A figure that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Figure {
    /// Bits lost on average, at most.
    Bits,
    /// Units in the last place, at most.
    Ulp,
    /// Relative error, at most.
    Relative,
    /// Absolute error, at most.
    Absolute,
}

impl Figure {
    const ALL: [(Figure, &'static str); 4] = [
        (Figure::Bits, "bits"),
        (Figure::Ulp, "ulp"),
        (Figure::Relative, "relative"),
        (Figure::Absolute, "absolute"),
    ];
}

/// Bounds of figures, all of which hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Target(Vec<(Figure, f64)>);

impl Target {
    /// The target of a text like `ulp=4,relative=1e-5`.
    ///
    /// # Errors
    ///
    /// A sentence about the part that names no figure, or has no number.
    pub fn parse(text: &str) -> Result<Target, String> {
        let bounds = text.split(',').map(|part| {
            let (name, bound) = part.split_once('=').unwrap_or((part, ""));
            let known = Figure::ALL.iter().find(|(_, n)| *n == name.trim());
            let bound = bound.trim().parse().ok().filter(|b: &f64| b.is_finite());
            known
                .map(|(figure, _)| *figure)
                .zip(bound)
                .ok_or_else(|| format!("`{part}` is none of bits=N, ulp=N, relative=N, absolute=N"))
        });
        bounds.collect::<Result<_, _>>().map(Target)
    }

    /// True if results keep to it.
    pub fn met_by(&self, measure: &Measure) -> bool {
        self.0.iter().all(|&(figure, bound)| match figure {
            Figure::Bits => measure.bits <= bound,
            Figure::Ulp => measure.ulps.is_some_and(|ulps| ulps <= bound),
            Figure::Relative => measure.not_finite == 0 && measure.relative <= bound,
            Figure::Absolute => measure.not_finite == 0 && measure.absolute <= bound,
        })
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (figure, bound)) in self.0.iter().enumerate() {
            let name = Figure::ALL.iter().find(|(known, _)| known == figure);
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{}={bound}", name.map_or("", |(_, name)| name))?;
        }
        Ok(())
    }
}
