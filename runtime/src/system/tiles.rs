//! Where cores get their tiles from.
//!
//! Neighbours in the picture read the same records and texels, so a core that gets a block of neighbours finds more of
//! them in its caches than one that gets every fourth tile of a row.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::sync::Arc;

use srp_archdesc::system::SystemSpec;

use super::WarmCaches;
use crate::scene_image::SceneImage;

/// A tile in the queue of a core.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct QueuedTile {
    /// Its number in the frame.
    pub tile: u32,
    /// Contents that the core's caches get when it takes the tile; without any, they keep theirs.
    #[serde(skip)]
    pub caches: Option<Arc<WarmCaches>>,
}

/// The number of a place on the curve of Z order, which goes through each square block before it leaves it.
pub fn z_order(x: u32, y: u32) -> u64 {
    let spread = |n: u32| (0..32).fold(0, |sum, bit| sum | u64::from(n >> bit & 1) << (2 * bit));
    spread(x) | spread(y) << 1
}

/// Blocks of a frame for each core, at least, unless they are single tiles: fewer leave some cores idle at its end.
const BLOCKS_A_CORE: u32 = 8;

/// The tiles of a frame in the blocks in which a machine's cores get them: of `tile-block` tiles on each side, or half
/// as many as often as it takes for each core to get several.
pub fn frame_blocks(image: &SceneImage, spec: &SystemSpec) -> Vec<Vec<u32>> {
    let (across, down) = (image.across, image.tiles / image.across);
    let mut side = spec.tile_block;
    while side > 1 && across.div_ceil(side) * down.div_ceil(side) < BLOCKS_A_CORE * spec.cores {
        side /= 2;
    }
    blocks(across, down, side)
}

/// The tiles of a frame in blocks of `side` × `side`, both in Z order; for a side of 1, tile by tile in rows.
fn blocks(across: u32, down: u32, side: u32) -> Vec<Vec<u32>> {
    if side <= 1 {
        return (0..across * down).map(|tile| vec![tile]).collect();
    }
    let ordered = |x: std::ops::Range<u32>, y: std::ops::Range<u32>| {
        let places = y.flat_map(|y| x.clone().map(move |x| (x, y)));
        let mut places: Vec<_> = places.collect();
        places.sort_by_key(|&(x, y)| z_order(x, y));
        places
    };
    let of_block = |(x, y): (u32, u32)| {
        let range = |at: u32, end: u32| at * side..((at + 1) * side).min(end);
        let tiles = ordered(range(x, across), range(y, down));
        tiles.into_iter().map(|(x, y)| y * across + x).collect()
    };
    let all = ordered(0..across.div_ceil(side), 0..down.div_ceil(side));
    all.into_iter().map(of_block).collect()
}

/// Tiles that wait for cores. Each has a place: its number among all that are queued.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TileQueue(Queue);

#[derive(Clone, Debug, Serialize, Deserialize)]
enum Queue {
    /// Blocks, to whoever asks, in their order; and of each core what is left of its own.
    Blocks {
        left: VecDeque<Vec<u32>>,
        own: Vec<VecDeque<u32>>,
        taken: u32,
        count: u32,
    },
    /// Of each core those that are left, the next at the end, with their places.
    OfCores {
        left: Vec<Vec<(u32, QueuedTile)>>,
        count: u32,
    },
}

impl TileQueue {
    /// Blocks of tiles: a core takes the tiles of its block one after the other, then the next block. Where there is
    /// none, it takes the later half of the most that another core has left.
    pub fn of_blocks(blocks: Vec<Vec<u32>>) -> TileQueue {
        TileQueue(Queue::Blocks {
            count: blocks.iter().map(Vec::len).sum::<usize>() as u32,
            left: blocks.into(),
            own: Vec::new(),
            taken: 0,
        })
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
    pub fn take(&mut self, core: u32) -> Option<(u32, QueuedTile)> {
        match &mut self.0 {
            Queue::Blocks {
                left, own, taken, ..
            } => {
                let tile = next_of_blocks(left, own, core as usize)?;
                *taken += 1;
                Some((*taken - 1, QueuedTile { tile, caches: None }))
            }
            Queue::OfCores { left, .. } => left.get_mut(core as usize)?.pop(),
        }
    }

    /// Tiles handed out so far.
    pub(super) fn taken(&self) -> u32 {
        match &self.0 {
            Queue::Blocks { taken, .. } => *taken,
            Queue::OfCores { left, count } => {
                count - left.iter().map(Vec::len).sum::<usize>() as u32
            }
        }
    }

    /// Tiles in all.
    pub(super) fn count(&self) -> u32 {
        match &self.0 {
            Queue::Blocks { count, .. } | Queue::OfCores { count, .. } => *count,
        }
    }
}

fn next_of_blocks(
    left: &mut VecDeque<Vec<u32>>,
    own: &mut Vec<VecDeque<u32>>,
    core: usize,
) -> Option<u32> {
    if own.len() <= core {
        own.resize(core + 1, VecDeque::new());
    }
    if own[core].is_empty() {
        own[core] = match left.pop_front() {
            Some(block) => block.into(),
            None => {
                let most = own.iter_mut().rev().max_by_key(|tiles| tiles.len())?;
                most.split_off(most.len().div_ceil(2))
            }
        };
    }
    own[core].pop_front()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_each_tile_once_and_neighbours_together() {
        for (across, down, side) in [(40, 30, 4), (7, 3, 2), (5, 9, 64), (6, 4, 1)] {
            let blocks = blocks(across, down, side);
            let mut all = blocks.concat();
            for block in &blocks {
                let range = |of: fn(u32, u32) -> u32| {
                    let places = block.iter().map(|&tile| of(tile, across));
                    places.clone().max().unwrap() - places.min().unwrap()
                };
                assert!(
                    range(|t, across| t % across) < side && range(|t, across| t / across) < side
                );
            }
            all.sort_unstable();
            assert!(all.into_iter().eq(0..across * down));
        }
        assert_eq!(
            blocks(3, 3, 2),
            [vec![0, 1, 3, 4], vec![2, 5], vec![6, 7], vec![8]]
        );
    }

    /// Core 0 has a block of four, core 1 one of one, then half of what core 0 has left.
    #[test]
    fn cores_without_a_block_share_those_of_others() {
        let mut queue = TileQueue::of_blocks(vec![vec![0, 1, 2, 3], vec![4]]);
        let taken =
            [0, 1, 1, 0, 0, 1, 0].map(|core| queue.take(core).map(|(_, queued)| queued.tile));
        assert_eq!(
            taken,
            [Some(0), Some(4), Some(3), Some(1), Some(2), None, None]
        );
        assert_eq!((queue.taken(), queue.count()), (5, 5));
    }
}
