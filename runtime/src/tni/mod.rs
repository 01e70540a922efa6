//! The traversal and intersection unit (SGRT section 3.3, Figures 3 and 4).
//!
//! Rays come in submissions: a ray buffer and a hit buffer in the core's SRAM, and a count. When the
//! last ray of a submission is back, its hits stand in the hit buffer in four runs: shadow hits,
//! shadow misses, other hits, other misses, each in the order of the rays.
//!
//! [`arithmetic`] alone decides what a ray hits. The kinds of a [`Unit`] differ only in how they keep
//! time, and so in when a ray is back: [`Tni`] runs every cycle, [`Estimated`] takes rays one by one,
//! [`Untimed`] answers at once. Time is counted in cycles of the unit's own
//! clock; the memory below the caches is the owner's business: [`Unit::take_request`] and
//! [`Unit::fill`].

pub mod arithmetic;
mod counters;
mod decoded;
mod estimated;
mod fetch;
mod full;
mod function;
mod ist;
mod level2;
mod levels;
mod occupancy;
mod pipe;
mod place;
mod ray_state;
mod replay;
mod ring;
mod submission;
mod tick;
mod trv;
mod unit;
mod untimed;
mod walk;
mod warm;

use self::arithmetic::Ray;
use self::full::Context;
use crate::bvh::NodeRef;
use serde::{Deserialize, Serialize};

pub use counters::{DispatchAccount, TniCounters, UnitCounters};
pub use estimated::Estimated;
pub use fetch::RauCounters;
pub use full::Tni;
pub use function::{Step, Traced, Tracer};
pub use levels::{LevelCounts, Levels};
pub use occupancy::{IstOccupancy, Occupancy, TrvOccupancy};
pub use pipe::{PipeCounters, StallAccount};
pub use place::place_for;
pub use replay::{Event, Logged, RayCost, Visited};
pub use submission::{Buffers, Finished, HitRecord, Runs, SubmitError};
pub use trv::TrvCounters;
pub use unit::Unit;
pub use untimed::{RayCounts, Untimed};
pub use walk::StackCounters;
pub use warm::{Misses, WarmCaches};

pub use srp_archdesc::system::{HIT_BYTES, RAY_BYTES};

/// Number of a resident ray: traversal unit times stacks, plus stack.
type Slot = u16;

/// Where the tree of the scene lies in system memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tree {
    /// The root; `None` for a scene without triangles.
    pub root: Option<NodeRef>,
    /// Address of node 0.
    pub nodes: u32,
    /// Address of triangle record 0.
    pub triangles: u32,
}

/// Which cache of the unit talks to the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Client {
    /// The level-2 cache of the traversal units.
    TrvL2,
    /// The level-1 cache of this intersection unit.
    IstL1(u32),
}

/// A line that is to be read from memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineRequest {
    /// Who reads it.
    pub client: Client,
    /// Its address.
    pub address: u32,
    /// Its size.
    pub bytes: u32,
}

/// The ray at an address of the SRAM.
fn read_ray(sram: &[u8], address: u32) -> Ray {
    let at = address as usize;
    let bytes = &sram[at..at + RAY_BYTES as usize];
    let mut words = [0; 16];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().expect("chunks of 4 bytes"));
    }
    Ray::from_words(words)
}
