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
        let group = run / self.one_in;
        (run % self.one_in == self.one_in / 2).then_some(group)
    }
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
}
