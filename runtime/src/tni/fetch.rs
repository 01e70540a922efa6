//! The memory side of a pipeline: input buffer, ray accumulation unit and level-1 cache
//! (SGRT section 3.2; US 9,342,919).
//!
//! A ray that finds its line in the cache passes on. One that misses is stored in the row of its
//! line; later rays that need the same line join the row. When the line arrives the row is valid
//! and gives up its rays, one a cycle. So rays that hit overtake rays that wait.
//!
//! Without rows there is no accumulation unit, as in the paper's FPGA prototype (section 4.3): a ray that misses
//! stands where it is, and all others behind it, until its line is here.

use schemars::JsonSchema;
use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use srp_archdesc::system::CacheSpec;

use super::Slot;
use super::ring::Ring;
use crate::memory::cache::{Access, Cache};
use crate::sums::sums;

/// Rows of rays that wait for the same line, part by part.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Rows {
    /// The line of each, or [`FREE`].
    lines: Vec<u32>,
    /// True if the line of the row is here, and its rays may leave.
    valid: Vec<bool>,
    /// The rays of each; their number is the occupancy counter.
    rays: Vec<VecDeque<Slot>>,
    /// Rays in valid rows.
    ready: u32,
}

/// Number of no line: lines have two bytes or more.
const FREE: u32 = u32::MAX;

impl Rows {
    fn new(count: usize) -> Rows {
        Rows {
            lines: vec![FREE; count],
            valid: vec![false; count],
            rays: vec![VecDeque::new(); count],
            ready: 0,
        }
    }

    fn find(&self, line: u32) -> Option<usize> {
        self.lines.iter().position(|&l| l == line)
    }

    /// The next ray of the first valid row.
    fn take_ready(&mut self) -> Option<Slot> {
        if self.ready == 0 {
            return None;
        }
        let row = self.valid.iter().position(|&valid| valid)?;
        let slot = self.rays[row].pop_front()?;
        self.ready -= 1;
        if self.rays[row].is_empty() {
            (self.lines[row], self.valid[row]) = (FREE, false);
        }
        Some(slot)
    }

    fn join(&mut self, row: usize, slot: Slot) {
        self.rays[row].push_back(slot);
        self.ready += u32::from(self.valid[row]);
    }

    fn fill(&mut self, line: u32) {
        if let Some(row) = self.find(line)
            && !self.valid[row]
        {
            self.valid[row] = true;
            self.ready += self.rays[row].len() as u32;
        }
    }
}

/// Counts of a ray accumulation unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RauCounters {
    /// Rays that opened a row.
    pub opened: u64,
    /// Rays that joined one.
    pub joined: u64,
    /// Rays sent back to the input buffer, because all rows or all misses were taken.
    pub retried: u64,
    /// Rays in rows, summed over the cycles.
    pub occupancy: u64,
    /// Lines on the way, summed over the cycles.
    pub outstanding: u64,
}

sums!(RauCounters: opened joined retried occupancy outstanding);

/// Input buffer, ray accumulation unit and cache.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Fetch {
    /// Rays that need a line, or have everything already.
    pub(super) input: Ring<Slot>,
    pub(super) cache: Cache,
    pub(super) counters: RauCounters,
    rows: Rows,
    rays_per_row: usize,
    /// True without an accumulation unit: the one row is the place of the ray that stands.
    stands: bool,
    waiting: u32,
}

/// The line that a ray in the input buffer needs, if any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// This line of memory.
    Line(u32),
    /// Nothing (more).
    Nothing,
}

impl Fetch {
    /// `rows` rows of `rays` rays each, in front of a cache; without an accumulation unit, none.
    pub(super) fn new((rows, rays): (u32, u32), cache: &CacheSpec, resident: usize) -> Fetch {
        Fetch {
            input: Ring::new(resident),
            cache: Cache::new(cache),
            counters: RauCounters::default(),
            rows: Rows::new(rows.max(1) as usize),
            rays_per_row: rays.max(1) as usize,
            stands: rows == 0,
            waiting: 0,
        }
    }

    /// Counts cycles in which rays wait as they do now.
    #[inline]
    pub(super) fn count(&mut self, cycles: u64) {
        self.counters.occupancy += cycles * u64::from(self.waiting);
        self.counters.outstanding += cycles * self.cache.outstanding() as u64;
    }

    /// True if a port's cycle would do anything.
    #[inline]
    pub(super) fn has_work(&self) -> bool {
        self.rows.ready > 0 || !self.input.is_empty() && !self.is_blocked()
    }

    /// True if a ray stands and waits for its line.
    fn is_blocked(&self) -> bool {
        self.stands && self.waiting > self.rows.ready
    }

    /// One port's cycle: at most one ray gets its line, or needs none, and is returned. `need` gives
    /// the need of a ray; lines to request go to `request`.
    #[inline]
    pub(super) fn tick(
        &mut self,
        need: impl Fn(Slot) -> Need,
        request: impl FnOnce(u32),
    ) -> Option<Slot> {
        if let Some(slot) = self.rows.take_ready() {
            self.waiting -= 1;
            return Some(slot);
        }
        if self.is_blocked() {
            return None;
        }
        let slot = self.input.pop_front()?;
        let Need::Line(line) = need(slot) else {
            return Some(slot);
        };
        if self.waiting > 0
            && let Some(row) = self.rows.find(line)
        {
            if self.rows.rays[row].len() == self.rays_per_row {
                return self.retry(slot);
            }
            self.rows.join(row, slot);
            self.waiting += 1;
            self.counters.joined += 1;
            self.cache.counters.joined += 1;
            return None;
        }
        if self.cache.hit(line) {
            return Some(slot);
        }
        let Some(free) = self.rows.find(FREE) else {
            // Asking would start a miss that no row waits for.
            return self.retry(slot);
        };
        match self.cache.access(line) {
            Access::Hit => Some(slot),
            Access::Miss => {
                request(line);
                self.rows.lines[free] = line;
                self.rows.join(free, slot);
                self.waiting += 1;
                self.counters.opened += 1;
                None
            }
            Access::Pending | Access::Full => self.retry(slot),
        }
    }

    fn retry(&mut self, slot: Slot) -> Option<Slot> {
        self.counters.retried += 1;
        match self.stands {
            true => self.input.push_front(slot),
            false => self.input.push_back(slot),
        }
        None
    }

    /// A requested line arrives.
    pub(super) fn fill(&mut self, line: u32) {
        self.cache.fill(line);
        self.rows.fill(line);
    }

    /// Rays that wait for lines.
    pub(super) fn waiting(&self) -> u32 {
        self.waiting
    }
}
