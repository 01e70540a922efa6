//! What passes between SRP and T&I unit: submissions of rays, and their hits in four runs.

use super::arithmetic::{ANY_HIT, Hit};
use super::{HIT_BYTES, RAY_BYTES};

/// Why a submission cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitRecord {
    /// What was hit.
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
#[derive(Clone, Debug)]
pub(super) struct Submission {
    /// Address of the ray buffer.
    pub(super) rays: u32,
    /// Address of the hit buffer.
    pub(super) hits: u32,
    /// Number of rays.
    pub(super) count: u32,
    /// How many of them have been dispatched.
    pub(super) dispatched: u32,
    /// Those that are back, in the order of their return.
    pub(super) records: Vec<HitRecord>,
}

impl Submission {
    /// A submission whose buffers lie in an SRAM of `sram_bytes`.
    pub(super) fn within(
        rays: u32,
        hits: u32,
        count: u32,
        sram_bytes: usize,
    ) -> Result<Submission, SubmitError> {
        for (address, size) in [(rays, RAY_BYTES), (hits, HIT_BYTES)] {
            let bytes = u64::from(size) * u64::from(count);
            if u64::from(address) + bytes > sram_bytes as u64 || !address.is_multiple_of(4) {
                let bytes = bytes.try_into().unwrap_or(u32::MAX);
                return Err(SubmitError::OutOfBounds { address, bytes });
            }
        }
        Ok(Submission {
            rays,
            hits,
            count,
            dispatched: 0,
            records: Vec::with_capacity(count as usize),
        })
    }

    /// Whether all its rays are back.
    pub(super) fn is_complete(&self) -> bool {
        self.records.len() == self.count as usize
    }

    /// Writes the hits to their buffer, in four runs.
    pub(super) fn write_hits(&mut self, sram: &mut [u8]) {
        self.records.sort_by_key(|r| (r.run(), r.ray));
        let words = self.records.iter().flat_map(HitRecord::words);
        let buffer = sram[self.hits as usize..].chunks_exact_mut(4);
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
