//! The traffic between SRP and T&I unit: submissions of rays, and their hits in four runs.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::ops::{Index, IndexMut};

use super::arithmetic::{ANY_HIT, Hit};
use super::{HIT_BYTES, RAY_BYTES};

/// Buffers of a submission: rays in the SRAM, and where their hits go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Buffers {
    /// Address of the ray buffer.
    pub rays: u32,
    /// Address of the hit buffer.
    pub hits: u32,
    /// Number of rays.
    pub count: u32,
}

/// A submission that is finished and was taken out of the unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// Lengths of the runs in the hit buffer.
    pub runs: Runs,
    /// The hits, as they stand there.
    pub hits: Vec<HitRecord>,
}

/// Why a submission cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SubmitError {
    /// As many as there are ray buffers are in the unit: later.
    Busy,
    /// The ray or hit buffer is not inside the SRAM, or not aligned to 4 bytes.
    OutOfBounds {
        /// The buffer's address.
        address: u32,
        /// Its size.
        bytes: u32,
    },
}

/// Hits of a submission, by run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Runs {
    /// Rays with the any-hit flag that hit something.
    pub shadow_hits: u32,
    /// Rays with the any-hit flag that did not.
    pub shadow_misses: u32,
    /// Other rays that hit something.
    pub other_hits: u32,
    /// Other rays that did not.
    pub other_misses: u32,
}

/// A finished ray as it is written to the hit buffer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HitRecord {
    /// The hit.
    pub hit: Hit,
    /// Index of the ray in its buffer.
    pub ray: u32,
    /// Flags of the ray.
    pub flags: u32,
}

impl HitRecord {
    /// The 6 words of the record (`srp_hit` in `kernels/scene.h`).
    pub fn words(&self) -> [u32; 6] {
        let Hit { t, u, v, primitive } = self.hit;
        let [t, u, v] = [t, u, v].map(f32::to_bits);
        [t, u, v, primitive, self.ray, self.flags]
    }

    /// The record of 6 words.
    pub fn from_words(words: [u32; 6]) -> HitRecord {
        let [t, u, v] = [words[0], words[1], words[2]].map(f32::from_bits);
        HitRecord {
            hit: Hit {
                t,
                u,
                v,
                primitive: words[3],
            },
            ray: words[4],
            flags: words[5],
        }
    }

    /// The run it belongs to, from 0.
    fn run(&self) -> usize {
        let shadow = self.flags & ANY_HIT != 0;
        2 * usize::from(!shadow) + usize::from(!self.hit.is_hit())
    }
}

/// A submission in the unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Submission {
    pub(super) buffers: Buffers,
    /// How many of its rays have been dispatched.
    pub(super) dispatched: u32,
    /// Those that are back, in the order of their return.
    pub(super) records: Vec<HitRecord>,
}

impl Submission {
    /// True if all its rays are back.
    pub(super) fn is_complete(&self) -> bool {
        self.records.len() == self.buffers.count as usize
    }

    /// Gives the answer to one of its rays.
    pub(super) fn answer(&mut self, ray: u32, hit: Hit, flags: u32) {
        self.dispatched += 1;
        self.records.push(HitRecord { hit, ray, flags });
    }

    /// Writes the hits to their buffer, in four runs.
    pub(super) fn write_hits(&mut self, sram: &mut [u8]) {
        self.records.sort_by_key(|r| (r.run(), r.ray));
        let words = self.records.iter().flat_map(HitRecord::words);
        let buffer = sram[self.buffers.hits as usize..].chunks_exact_mut(4);
        for (bytes, word) in buffer.zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
    }

    /// Lengths of the runs.
    pub(super) fn runs(&self) -> Runs {
        let mut counts = [0; 4];
        for record in &self.records {
            counts[record.run()] += 1;
        }
        let [shadow_hits, shadow_misses, other_hits, other_misses] = counts;
        Runs {
            shadow_hits,
            shadow_misses,
            other_hits,
            other_misses,
        }
    }
}

/// The submissions in a unit, oldest first; a finished one stays until it is taken.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Queue {
    /// How many there may be at once.
    room: usize,
    submissions: VecDeque<Submission>,
    /// Submissions that were taken before the first.
    taken: u64,
}

impl Queue {
    /// An empty queue with room for `room` ≥ 1 submissions.
    pub(super) fn new(room: u32) -> Queue {
        Queue {
            room: room.max(1) as usize,
            submissions: VecDeque::new(),
            taken: 0,
        }
    }

    /// A submission that is to be [pushed](Self::push), whose buffers lie in an SRAM of `sram_bytes`.
    pub(super) fn admit(
        &self,
        buffers: Buffers,
        sram_bytes: usize,
    ) -> Result<Submission, SubmitError> {
        if self.submissions.len() == self.room {
            return Err(SubmitError::Busy);
        }
        for (address, size) in [(buffers.rays, RAY_BYTES), (buffers.hits, HIT_BYTES)] {
            let bytes = u64::from(size) * u64::from(buffers.count);
            if u64::from(address) + bytes > sram_bytes as u64 || !address.is_multiple_of(4) {
                let bytes = bytes.try_into().unwrap_or(u32::MAX);
                return Err(SubmitError::OutOfBounds { address, bytes });
            }
        }
        Ok(Submission {
            buffers,
            dispatched: 0,
            records: Vec::with_capacity(buffers.count as usize),
        })
    }

    /// Puts a submission behind the others.
    pub(super) fn push(&mut self, submission: Submission) -> &Submission {
        self.submissions.push_back_mut(submission)
    }

    /// Takes the oldest submission, where it is complete.
    pub(super) fn take_finished(&mut self) -> Option<Finished> {
        let submission = self.submissions.pop_front_if(|s| s.is_complete())?;
        self.taken += 1;
        Some(Finished {
            runs: submission.runs(),
            hits: submission.records,
        })
    }

    /// Submissions that were taken so far.
    #[inline]
    pub(super) fn taken(&self) -> u64 {
        self.taken
    }

    /// How many there are.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.submissions.len()
    }

    /// How many of them are complete.
    pub(super) fn complete(&self) -> usize {
        self.submissions.iter().filter(|s| s.is_complete()).count()
    }

    /// True if all are complete.
    #[inline]
    pub(super) fn is_complete(&self) -> bool {
        self.submissions.iter().all(Submission::is_complete)
    }

    /// The submission with so many before it.
    #[inline]
    pub(super) fn get(&self, order: usize) -> Option<&Submission> {
        self.submissions.get(order)
    }
}

impl Index<usize> for Queue {
    type Output = Submission;

    #[inline]
    fn index(&self, order: usize) -> &Submission {
        &self.submissions[order]
    }
}

impl IndexMut<usize> for Queue {
    #[inline]
    fn index_mut(&mut self, order: usize) -> &mut Submission {
        &mut self.submissions[order]
    }
}
