//! Measuring a part of the rays, and how far what is measured can be trusted.
//!
//! Whole packets are taken, in runs of neighbours, because neighbours share what the caches hold:
//! of every N runs the one in the middle. The runs' cycles a ray are the sample; from their spread
//! comes the confidence interval.

/// Most packets of a run.
pub const MAX_RUN: u64 = 256;

/// Runs that a sample should have.
const RUNS: u64 = 48;

/// Which packets are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    one_in: u64,
    run: u64,
}

impl Sampling {
    /// One run in `one_in` ≥ 1, of about `packets` packets in all.
    pub fn new(one_in: u64, packets: u64) -> Sampling {
        let one_in = one_in.max(1);
        Sampling {
            one_in,
            run: (packets / (one_in * RUNS)).clamp(1, MAX_RUN),
        }
    }

    /// The run that packet `n` is measured in, counted from 0; `None` where it is left out.
    pub fn run_of(&self, packet: u64) -> Option<u64> {
        let run = packet / self.run;
        (run % self.one_in == self.one_in / 2).then_some(run / self.one_in)
    }
}

/// Half the width of the 95 % confidence interval of a mean, over the mean; `None` of fewer than
/// two values.
pub(crate) fn relative_error(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    if values.len() < 2 || mean <= 0.0 {
        return None;
    }
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    // Student's t at 97.5 %, by its expansion in 1/degrees of freedom.
    let nu = n - 1.0;
    let z = 1.959_964;
    let t = z
        + (z * z * z + z) / (4.0 * nu)
        + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * nu * nu);
    Some(t * (variance / n).sqrt() / mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_runs_by_a_fixed_rule() {
        let sampling = Sampling::new(4, 4 * 48 * 3);
        let taken: Vec<u64> = (0..24).filter(|&p| sampling.run_of(p).is_some()).collect();
        assert_eq!(taken, [6, 7, 8, 18, 19, 20]);
        assert_eq!(sampling.run_of(18), Some(1));
        let all = Sampling::new(1, 100);
        assert!((0..100).all(|p| all.run_of(p).is_some()));
    }

    #[test]
    fn intervals_hold_the_mean_in_19_of_20_cases() {
        let mut state = 1u32;
        let mut unit = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / 4_294_967_296.0
        };
        let mut inside = 0;
        for _ in 0..2000 {
            // Sums of four even numbers are nearly normal; their mean is 3.
            let values: Vec<f64> = (0..12)
                .map(|_| 1.0 + unit() + unit() + unit() + unit())
                .collect();
            let mean = values.iter().sum::<f64>() / 12.0;
            let error = relative_error(&values).expect("12 values") * mean;
            inside += u32::from((mean - 3.0).abs() <= error);
        }
        assert!((1860..=1940).contains(&inside), "{inside}");
        assert_eq!(relative_error(&[1.0]), None);
    }
}
