//! Measuring a part of the rays, and how far what is measured can be trusted.
//!
//! Whole packets are taken, in runs of neighbours, because neighbours share what the caches hold:
//! of every N runs the one in the middle. The runs' cycles a ray are the sample; from their spread
//! comes the confidence interval.

use crate::survey::Random;

/// Most packets of a run.
pub const MAX_RUN: u64 = 256;

/// Runs that a sample should have.
const RUNS: u64 = 48;

/// Which packets are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    one_in: u64,
    run: u64,
    seed: Option<u64>,
}

impl Sampling {
    /// One run in `one_in` ≥ 1, of about `packets` packets in all.
    pub fn new(one_in: u64, packets: u64) -> Sampling {
        let one_in = one_in.max(1);
        Sampling {
            one_in,
            run: (packets / (one_in * RUNS)).clamp(1, MAX_RUN),
            seed: None,
        }
    }

    /// The same with a run at random of every `one_in`, instead of the one in the middle.
    pub fn seeded(self, seed: u64) -> Sampling {
        Sampling {
            seed: Some(seed),
            ..self
        }
    }

    /// The run that packet `n` is measured in, counted from 0; `None` where it is left out.
    pub fn run_of(&self, packet: u64) -> Option<u64> {
        let run = packet / self.run;
        let group = run / self.one_in;
        let taken = match self.seed {
            None => self.one_in / 2,
            Some(seed) => {
                let mut random = Random::new(seed ^ group.wrapping_mul(0x9e37_79b9_7f4a_7c15));
                random.below(self.one_in as usize) as u64
            }
        };
        (run % self.one_in == taken).then_some(group)
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
        let random = Sampling::new(4, 4 * 48 * 3).seeded(7);
        let taken: Vec<u64> = (0..2400).filter_map(|p| random.run_of(p)).collect();
        assert_eq!(taken.len(), 600);
        assert!(
            taken
                .chunks(3)
                .enumerate()
                .all(|(i, run)| run == [i as u64; 3])
        );
        assert_ne!(
            random.run_of(6).is_some(),
            random.seeded(9).run_of(6).is_some()
        );
        let all = Sampling::new(1, 100);
        assert!((0..100).all(|p| all.run_of(p).is_some()));
    }
}
