//! The limits that a picture has to keep to, and the settings that are worth having.

use super::compare::Difference;
use super::probe::Leaks;
use super::trial::Trial;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// One figure and its bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Bound {
    figure: Figure,
    bound: f64,
}

/// The limits that can be asked of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Figure {
    /// dB over the pixels on which decisions agree, at least.
    Psnr,
    /// Mean of FLIP, at most.
    Flip,
    /// Rays let through on edges, at most.
    Leaks,
    /// Pixels that are off by more than eight levels, at most.
    Pixels,
}

impl Figure {
    const ALL: [(Figure, &'static str); 4] = [
        (Figure::Psnr, "psnr"),
        (Figure::Flip, "flip"),
        (Figure::Leaks, "leaks"),
        (Figure::Pixels, "pixels"),
    ];
}

/// Everything that is asked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Target(Vec<Bound>);

impl Target {
    /// The target of a text like `psnr=45,leaks=0`.
    ///
    /// # Errors
    ///
    /// A sentence about the part that names no figure, or has no number.
    pub fn parse(text: &str) -> Result<Target, String> {
        let bounds = text.split(',').map(|part| {
            let (name, bound) = part.split_once('=').unwrap_or((part, ""));
            let known = Figure::ALL.iter().find(|(_, n)| *n == name.trim());
            let bound = bound.trim().parse().ok().filter(|b: &f64| b.is_finite());
            match (known, bound) {
                (Some(&(figure, _)), Some(bound)) => Ok(Bound { figure, bound }),
                _ => Err(format!(
                    "`{part}` is none of psnr=DB, flip=MEAN, leaks=N, pixels=N"
                )),
            }
        });
        bounds.collect::<Result<_, _>>().map(Target)
    }

    /// True if a trial keeps to it.
    pub fn met_by(&self, trial: &Trial) -> bool {
        self.met_by_picture(&trial.all) && self.met_by_leaks(trial.leaks)
    }

    /// True if a picture keeps to what is asked of it.
    pub(super) fn met_by_picture(&self, picture: &Difference) -> bool {
        self.0.iter().all(|b| match b.figure {
            Figure::Psnr => picture.psnr.is_none_or(|psnr| psnr >= b.bound),
            Figure::Flip => picture.flip <= b.bound,
            Figure::Pixels => f64::from(picture.beyond_8) <= b.bound,
            Figure::Leaks => true,
        })
    }

    /// The PSNR that is asked for, if any is.
    pub(super) fn least_psnr(&self) -> Option<f64> {
        let asked = self.0.iter().filter(|b| b.figure == Figure::Psnr);
        asked.map(|b| b.bound).reduce(f64::max)
    }

    /// True if aimed rays keep to what is asked of them.
    pub(super) fn met_by_leaks(&self, leaks: Leaks) -> bool {
        let mut asked = self.0.iter().filter(|b| b.figure == Figure::Leaks);
        asked.all(|b| f64::from(leaks.leaks) <= b.bound)
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, b) in self.0.iter().enumerate() {
            let name = Figure::ALL.iter().find(|(figure, _)| *figure == b.figure);
            let name = name.map_or("", |(_, name)| name);
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{name}={}", b.bound)?;
        }
        Ok(())
    }
}

/// Cycles of a trial over those of another, 1 where they differ by no more than the noise.
pub fn relative_cycles(trial: &Trial, base: &Trial, noise: f64) -> f64 {
    let ratio = trial.costs.frame_cycles as f64 / base.costs.frame_cycles.max(1) as f64;
    match (ratio - 1.0).abs() <= noise {
        true => 1.0,
        false => ratio,
    }
}

/// Cycles, area and energy of a trial over those of another.
pub(super) fn relative_costs(trial: &Trial, base: &Trial, noise: f64) -> [f64; 3] {
    let (a, b) = (&trial.costs, &base.costs);
    let cycles = relative_cycles(trial, base, noise);
    [cycles, a.area / b.area, a.energy / b.energy]
}

/// The cost of a trial relative to another's: the product of its cycles, energy and area over the other's.
pub(super) fn relative_cost(trial: &Trial, base: &Trial, noise: f64) -> f64 {
    relative_costs(trial, base, noise).iter().product()
}

/// PSNR as a number that can be compared: a picture without a wrong byte is better than any.
pub(super) fn quality(trial: &Trial) -> f64 {
    trial.all.psnr.unwrap_or(f64::INFINITY)
}

/// The trials with the same light beside which no other is at least as good in picture and cost and better in one.
pub fn front(trials: &[Trial], cost: impl Fn(&Trial) -> f64) -> Vec<usize> {
    let better = |a: &Trial, b: &Trial| {
        let (qa, qb, ca, cb) = (quality(a), quality(b), cost(a), cost(b));
        qa >= qb && ca <= cb && (qa > qb || ca < cb)
    };
    let alike: Vec<usize> = (0..trials.len())
        .filter(|&i| !trials[i].is_sampling() && !trials[i].not_exercised)
        .collect();
    let stays = |i: &usize| !alike.iter().any(|&j| better(&trials[j], &trials[*i]));
    alike.iter().copied().filter(stays).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(psnr: Option<f64>, cycles: u64) -> Trial {
        let mut trial = Trial::empty();
        trial.all.psnr = psnr;
        trial.costs.frame_cycles = cycles;
        trial
    }

    #[test]
    fn targets_are_read_and_kept_to() {
        let target = Target::parse("psnr=45, leaks=0").expect("a target");
        assert_eq!(target.to_string(), "psnr=45,leaks=0");
        assert!(target.met_by(&trial(None, 1)));
        assert!(target.met_by(&trial(Some(45.0), 1)));
        assert!(!target.met_by(&trial(Some(44.9), 1)));
        let mut leaking = trial(None, 1);
        leaking.leaks.leaks = 1;
        assert!(!target.met_by(&leaking));
        assert!(Target::parse("psnr").is_err());
        assert!(Target::parse("beauty=1").is_err());
        assert!(Target::parse("psnr=nan").is_err());
    }

    #[test]
    fn what_is_dominated_is_not_on_the_front() {
        let trials = [
            trial(None, 10),
            trial(Some(40.0), 8),
            trial(Some(39.0), 9),
            trial(Some(20.0), 8),
            trial(Some(10.0), 1),
        ];
        let cycles = |t: &Trial| t.costs.frame_cycles as f64;
        assert_eq!(front(&trials, cycles), [0, 1, 4]);
    }
}
