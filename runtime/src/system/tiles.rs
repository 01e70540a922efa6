//! Where cores get their tiles from.

use std::sync::Arc;

use super::WarmCaches;

/// A tile in the queue of a core.
#[derive(Clone, Debug)]
pub struct QueuedTile {
    /// Its number in the frame.
    pub tile: u32,
    /// Contents that the core's caches get when it takes the tile; without any, they keep theirs.
    pub caches: Option<Arc<WarmCaches>>,
}

/// Tiles that wait for cores. Each has a place: its number among all that are queued.
#[derive(Clone, Debug)]
pub struct TileQueue(Queue);

#[derive(Clone, Debug)]
enum Queue {
    /// So many tiles, to whoever asks, in their order.
    Common { next: u32, count: u32 },
    /// These tiles, to whoever asks, in this order.
    Ordered { next: u32, tiles: Vec<u32> },
    /// Of each core those that are left, the next at the end, with their places.
    OfCores {
        left: Vec<Vec<(u32, QueuedTile)>>,
        count: u32,
    },
}

impl TileQueue {
    /// The first `count` tiles of a frame, to whichever core asks first.
    pub fn common(count: u32) -> TileQueue {
        TileQueue(Queue::Common { next: 0, count })
    }

    /// Tiles in an order, to whichever core asks first.
    pub fn ordered(tiles: Vec<u32>) -> TileQueue {
        TileQueue(Queue::Ordered { next: 0, tiles })
    }

    /// Certain tiles for each core, in their order; places go core by core. A core with an empty queue,
    /// or with none, gets no tile.
    pub fn of_cores(queues: Vec<Vec<QueuedTile>>) -> TileQueue {
        let mut count = 0;
        let places = |queue: Vec<QueuedTile>| {
            let first = count;
            count += queue.len() as u32;
            let mut left: Vec<_> = (first..).zip(queue).collect();
            left.reverse();
            left
        };
        let left = queues.into_iter().map(places).collect();
        TileQueue(Queue::OfCores { left, count })
    }

    /// The next tile for a core, with its place.
    pub(super) fn take(&mut self, core: u32) -> Option<(u32, QueuedTile)> {
        match &mut self.0 {
            Queue::Common { next, count } => {
                let tile = Some(*next).filter(|next| next < count)?;
                *next += 1;
                Some((tile, QueuedTile { tile, caches: None }))
            }
            Queue::Ordered { next, tiles } => {
                let (place, tile) = (*next, *tiles.get(*next as usize)?);
                *next += 1;
                Some((place, QueuedTile { tile, caches: None }))
            }
            Queue::OfCores { left, .. } => left.get_mut(core as usize)?.pop(),
        }
    }

    /// Tiles handed out so far.
    pub(super) fn taken(&self) -> u32 {
        match &self.0 {
            Queue::Common { next, .. } | Queue::Ordered { next, .. } => *next,
            Queue::OfCores { left, count } => {
                count - left.iter().map(Vec::len).sum::<usize>() as u32
            }
        }
    }

    /// Tiles in all.
    pub(super) fn count(&self) -> u32 {
        match &self.0 {
            Queue::Common { count, .. } | Queue::OfCores { count, .. } => *count,
            Queue::Ordered { tiles, .. } => tiles.len() as u32,
        }
    }
}
