//! Attributions and explanations in words.

use super::{Attribution, Explanation, FlipKind};
use std::fmt::Write;

/// Flips of each kind that are told.
const MOST_FLIPS: usize = 5;

/// The name of a source: its place and its operation, or a unit.
fn name(at: &str, what: &str) -> String {
    match at.is_empty() {
        true => what.to_owned(),
        false => format!("{at} {what}"),
    }
}

impl Attribution {
    /// The name of a source.
    pub fn name(&self, source: usize) -> String {
        let source = self.sources.get(source);
        source.map_or(String::new(), |source| name(&source.at, &source.what))
    }

    /// How many of the largest shares make up this part of the squared error, from 0 to 1.
    pub fn sources_of(&self, part: f64) -> usize {
        let mut sum = 0.0;
        let enough = |&source: &usize| {
            sum += self.sources[source].squared;
            sum >= part * self.squared_error
        };
        let found = self.ranking.iter().position(enough);
        found.map_or(self.ranking.len(), |i| i + 1)
    }

    /// Squared error of the pixels that were looked into, as decibels against the full range.
    pub fn decibels(&self) -> f64 {
        let channels = 3 * self.pixels.iter().flatten().count();
        10.0 * (255.0 * 255.0 * channels as f64 / self.squared_error).log10()
    }

    /// The largest `most` sources, the flips by kind, and what made numbers that are not finite.
    pub fn text(&self, most: usize) -> String {
        let mut text = String::new();
        let _ = writeln!(
            text,
            "error before the rounding to bytes: {:.1} dB; {} sources make 95 % of it",
            self.decibels(),
            self.sources_of(0.95)
        );
        for &i in self.ranking.iter().take(most) {
            let source = &self.sources[i];
            let share = 100.0 * source.squared / self.squared_error;
            let _ = writeln!(
                text,
                "  {share:6.2} %  {:<40} most of {} pixels, {} flips",
                self.name(i),
                source.pixels,
                source.flips
            );
        }
        for kind in FlipKind::ALL {
            let of: Vec<_> = self.flips.iter().filter(|flip| flip.kind == kind).collect();
            let _ = writeln!(text, "{} {} flipped", of.len(), kind.name());
            for flip in of.iter().take(MOST_FLIPS) {
                let because: Vec<String> =
                    flip.because.iter().map(|c| self.name(c.source)).collect();
                let place = flip
                    .pixel
                    .map_or(String::new(), |(x, y)| format!("{x},{y}: "));
                let _ = writeln!(
                    text,
                    "  {place}{} takes {} because of {}",
                    self.name(flip.source),
                    flip.what,
                    because.join(", ")
                );
            }
        }
        for made in &self.non_finite {
            let place = made
                .pixel
                .map_or(String::new(), |(x, y)| format!(", first at {x},{y}"));
            let _ = writeln!(
                text,
                "{} gives {} from finite numbers {} times{place}",
                self.name(made.source),
                made.value,
                made.count
            );
        }
        text
    }
}

impl Explanation {
    /// The pixel, where binary32 parts from binary64 and what follows, and what contributes.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let levels = |c: [f64; 3]| format!("{:.6} {:.6} {:.6}", c[0], c[1], c[2]);
        let channel = ["red", "green", "blue"][self.channel];
        let _ = writeln!(text, "value  {}", levels(self.pixel.value));
        let _ = writeln!(text, "exact  {}", levels(self.pixel.exact));
        let error = self.pixel.error();
        let _ = writeln!(
            text,
            "error  {:.3e} {:.3e} {:.3e}, most in {channel}",
            error[0], error[1], error[2]
        );
        for (at, what, flip) in &self.flips {
            let _ = writeln!(
                text,
                "flip   {}: {} takes {}",
                flip.kind.name(),
                name(at, what),
                flip.what
            );
        }
        let _ = writeln!(text, "the first that parts, and what follows:");
        for step in &self.chain {
            let _ = writeln!(
                text,
                "  {:<36} {:>15} not {:<22} {:>9.1} ulp, {:+.3e} in {channel}",
                name(&step.at, &step.what),
                step.value,
                step.exact,
                step.ulps,
                step.effect
            );
        }
        let _ = writeln!(text, "contributions:");
        for (at, what, error) in self.contributions.iter().take(12) {
            let _ = writeln!(
                text,
                "  {:<36} {:+.3e}",
                name(at, what),
                error[self.channel]
            );
        }
        text
    }
}
