//! The tiles of a frame, handed out to its cores.

use std::sync::Arc;

use super::tags::Tags;

/// A tile for a certain core.
#[derive(Clone, Debug)]
pub(super) struct Errand {
    pub(super) tile: u32,
    /// What the core's caches hold when it takes the tile; none: what they happen to.
    pub(super) find: Option<Arc<Tags>>,
}

/// Tiles that wait for cores.
#[derive(Clone, Debug)]
pub(super) enum TileQueue {
    /// All tiles, to whoever asks, in their order.
    Common {
        /// The next.
        next: u32,
        /// Their number.
        count: u32,
    },
    /// Some tiles, dealt out beforehand.
    Dealt {
        /// Of each core those that are left, the next at the end, each with its place among all.
        left: Vec<Vec<(u32, Errand)>>,
        /// Their number.
        count: u32,
    },
}

impl TileQueue {
    /// These tiles for each core.
    pub(super) fn dealt(errands: Vec<Vec<Errand>>) -> TileQueue {
        let mut count = 0;
        let places = |core: Vec<Errand>| {
            let first = count;
            count += core.len() as u32;
            let mut left: Vec<_> = (first..).zip(core).collect();
            left.reverse();
            left
        };
        let left = errands.into_iter().map(places).collect();
        TileQueue::Dealt { left, count }
    }

    /// The next tile for a core, with its place among all.
    pub(super) fn take(&mut self, core: u32) -> Option<(u32, Errand)> {
        match self {
            TileQueue::Common { next, count } => {
                let tile = Some(*next).filter(|next| next < count)?;
                *next += 1;
                Some((tile, Errand { tile, find: None }))
            }
            TileQueue::Dealt { left, .. } => left.get_mut(core as usize)?.pop(),
        }
    }

    /// Tiles handed out so far.
    pub(super) fn taken(&self) -> u32 {
        match self {
            TileQueue::Common { next, .. } => *next,
            TileQueue::Dealt { left, count } => {
                count - left.iter().map(Vec::len).sum::<usize>() as u32
            }
        }
    }

    /// Tiles in all.
    pub(super) fn count(&self) -> u32 {
        match self {
            TileQueue::Common { count, .. } | TileQueue::Dealt { count, .. } => *count,
        }
    }
}
