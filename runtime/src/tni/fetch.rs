//! The memory side of a pipeline: input buffer, ray accumulation unit and level-1 cache
//! (SGRT section 3.2; US 9,342,919).
//!
//! A ray that finds its line in the cache passes on. One that misses is stored in the row of its
//! line; later rays that need the same line join the row. When the line arrives the row is valid
//! and gives up its rays, one a cycle. So rays that hit overtake rays that wait.

use std::collections::VecDeque;

use serde::Serialize;
use srp_archdesc::system::CacheSpec;

use super::Slot;
use crate::memory::cache::{Access, Cache};

/// One row: rays that wait for the same line.
#[derive(Clone, Debug)]
struct Row {
    line: u32,
    /// The line is here, and the rays may leave.
    valid: bool,
    /// Empty where the row is free; its length is the occupancy counter.
    rays: VecDeque<Slot>,
}

/// What a ray accumulation unit did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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

impl RauCounters {
    /// Adds what another unit did.
    pub fn add(&mut self, other: &RauCounters) {
        self.opened += other.opened;
        self.joined += other.joined;
        self.retried += other.retried;
        self.occupancy += other.occupancy;
        self.outstanding += other.outstanding;
    }
}

/// Input buffer, ray accumulation unit and cache.
#[derive(Clone, Debug)]
pub(super) struct Fetch {
    /// Rays that need a line, or have everything already.
    pub(super) input: VecDeque<Slot>,
    pub(super) cache: Cache,
    pub(super) counters: RauCounters,
    rows: Vec<Row>,
    rays_per_row: usize,
    waiting: u32,
}

/// What a ray in the input buffer needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// This line of memory.
    Line(u32),
    /// Nothing (more).
    Nothing,
}

impl Fetch {
    /// `rows` rows of `rays` rays each, in front of a cache.
    pub(super) fn new((rows, rays): (u32, u32), cache: &CacheSpec, resident: usize) -> Fetch {
        let row = Row {
            line: 0,
            valid: false,
            rays: VecDeque::new(),
        };
        Fetch {
            input: VecDeque::with_capacity(resident),
            cache: Cache::new(cache),
            counters: RauCounters::default(),
            rows: vec![row; rows.max(1) as usize],
            rays_per_row: rays.max(1) as usize,
            waiting: 0,
        }
    }

    /// Ends a cycle.
    #[inline]
    pub(super) fn count(&mut self) {
        if self.waiting > 0 {
            self.counters.occupancy += u64::from(self.waiting);
            self.counters.outstanding += self.cache.outstanding() as u64;
        }
    }

    /// One port's cycle: at most one ray gets its line, or needs none, and is returned. `need` says
    /// what a ray needs; lines to be requested go to `request`.
    #[inline]
    pub(super) fn tick(
        &mut self,
        need: impl Fn(Slot) -> Need,
        request: impl FnOnce(u32),
    ) -> Option<Slot> {
        if self.waiting > 0
            && let Some(row) = self.rows.iter_mut().find(|r| r.valid && !r.rays.is_empty())
        {
            self.waiting -= 1;
            return row.rays.pop_front();
        }
        let slot = self.input.pop_front()?;
        let Need::Line(line) = need(slot) else {
            return Some(slot);
        };
        if self.waiting > 0
            && let Some(row) = self
                .rows
                .iter_mut()
                .find(|r| r.line == line && !r.rays.is_empty())
        {
            if row.rays.len() == self.rays_per_row {
                return self.retry(slot);
            }
            row.rays.push_back(slot);
            self.waiting += 1;
            self.counters.joined += 1;
            self.cache.counters.joined += 1;
            return None;
        }
        if self.cache.hit(line) {
            return Some(slot);
        }
        let Some(free) = self.rows.iter().position(|r| r.rays.is_empty()) else {
            // Asking would start a miss that no row waits for.
            return self.retry(slot);
        };
        match self.cache.access(line) {
            Access::Hit => Some(slot),
            Access::Miss => {
                request(line);
                let row = &mut self.rows[free];
                (row.line, row.valid) = (line, false);
                row.rays.push_back(slot);
                self.waiting += 1;
                self.counters.opened += 1;
                None
            }
            Access::Pending | Access::Full => self.retry(slot),
        }
    }

    fn retry(&mut self, slot: Slot) -> Option<Slot> {
        self.counters.retried += 1;
        self.input.push_back(slot);
        None
    }

    /// A requested line arrives.
    pub(super) fn fill(&mut self, line: u32) {
        self.cache.fill(line);
        for row in &mut self.rows {
            if row.line == line && !row.rays.is_empty() {
                row.valid = true;
            }
        }
    }

    /// Rays in input buffer and rows.
    pub(super) fn is_empty(&self) -> bool {
        self.input.is_empty() && self.waiting == 0
    }

    /// Rays that wait for lines.
    pub(super) fn waiting(&self) -> u32 {
        self.waiting
    }
}
