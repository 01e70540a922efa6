//! Comparisons that the shadows decide otherwise, and their consequences.

use super::arithmetic::Marked;
use super::{Decision, Flip, Mark, Meaning, Shadows};

/// A comparison that the shadows decide otherwise.
#[derive(Clone, Debug)]
pub(super) struct Dispute {
    pub(super) flip: Flip,
    /// True if it has had a consequence.
    settled: bool,
}

impl Shadows<'_> {
    /// The mark of the outcome of a comparison.
    #[inline]
    pub(super) fn compare(
        &mut self,
        source: u32,
        args: [Marked; 2],
        outcome: bool,
        holds: impl Fn(f64, f64) -> bool,
    ) -> Mark {
        if args.iter().all(|(_, mark)| mark.node_of() == 0) {
            return Mark::PLAIN;
        }
        let shadows = args.map(|arg| self.shadow(arg));
        if holds(shadows[0], shadows[1]) == outcome {
            return Mark::PLAIN;
        }
        let nodes = args.map(|(_, mark)| mark.node_of());
        self.disputes.push(Dispute {
            flip: Flip {
                decision: Decision::Comparison,
                source,
                tag: self.tape.tag(nodes),
                values: args.map(|(value, _)| value),
                shadows,
                nodes,
            },
            settled: false,
        });
        Mark::dispute(self.disputes.len() - 1)
    }

    /// Returns a word of truth values as the shadows have it.
    pub(super) fn truth(word: u32, mark: Mark, all: u32) -> u32 {
        match mark.meaning() {
            Meaning::Dispute(_) => word ^ all,
            _ => word,
        }
    }

    /// The mark of a truth value made of others: in dispute where the shadows have another.
    pub(super) fn decided(real: u32, shadow: u32, marks: &[Mark]) -> Mark {
        let disputed = |mark: &&Mark| matches!(mark.meaning(), Meaning::Dispute(_));
        match real == shadow {
            true => Mark::PLAIN,
            false => marks.iter().find(disputed).copied().unwrap_or_default(),
        }
    }

    /// Something comes of a truth value, or of an integer that was a float.
    #[inline]
    pub(super) fn settle(&mut self, mark: Mark) {
        match mark.meaning() {
            Meaning::Plain | Meaning::Node(_) | Meaning::Mantissa(_) => {}
            Meaning::Dispute(index) => {
                let dispute = &mut self.disputes[index as usize];
                if !std::mem::replace(&mut dispute.settled, true) {
                    self.flips.push(dispute.flip.clone());
                }
            }
            Meaning::Bytes(index) => self.settle_bytes(index),
        }
    }
}
