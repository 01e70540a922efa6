//! Caches beyond their arrays.

use super::memory::SRAM_BIT;
use super::operator::{MULTIPLEXER_BIT, compare};

/// Area of what finds a line among the ways of a cache, µm²: a comparator for the tag of each way, the tags with the order in
/// which the ways of a set were used, and a multiplexer of the bits that are read.
pub fn ways_area(bytes: u32, line: u32, ways: u32, read: u32) -> f64 {
    const ADDRESS: u32 = 32;
    let tag = ADDRESS - (bytes / ways).max(1).ilog2();
    let each = compare(tag).area_um2 + f64::from(read) * MULTIPLEXER_BIT;
    let stored = f64::from(bytes / line) * (f64::from(tag) + f64::from(ways).log2());
    f64::from(ways) * each + stored * SRAM_BIT
}
