//! The data cache of one core, and the lines on their way between it and the memory.
//!
//! Loads allocate lines. One that misses freezes the core: at once if the cache blocks, else where its value is due
//! and its line is not there yet; what the core does until then is hit under miss. Prefetches allocate lines too, and
//! freeze nothing: the load that comes too early for its line does. Due times are in cycles of the engine: while the
//! core is frozen or waits for a port, time stands still for values in flight. Stores never freeze it: one that hits
//! marks its line, which is written back when it is replaced; one that misses goes round the cache into a small buffer
//! that combines neighbouring stores into lines (streams of pixels would otherwise read every line of the frame buffer
//! before overwriting it).

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use srp_archdesc::system::CacheSpec;

use crate::memory::cache::{Access, Cache};

/// A load whose line is on its way.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Late {
    line: u32,
    /// Cycles that the engine may run before the value is due.
    slack: u64,
}

/// Cache, store buffer and requests.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct DataCache {
    pub(super) cache: Cache,
    line: u32,
    blocking: bool,
    /// Cycles that the engine may run after the one of a load before its value is due; none if the cache blocks.
    slack: u64,
    /// The loads whose lines are on their way; those of the run that goes on are behind the first `known`.
    late: Vec<Late>,
    known: usize,
    /// Lines that a load of the current cycle needs and that cannot be requested yet.
    deferred: Vec<u32>,
    /// Combined stores: line and bytes, oldest first.
    stores: VecDeque<(u32, u32)>,
    max_stores: usize,
    /// Requests to be sent: address, bytes, whether it writes.
    requests: VecDeque<(u32, u32, bool)>,
    /// True if lines are there as soon as they are asked for.
    immediate: bool,
}

impl DataCache {
    /// An empty cache. The values of loads are due `latency` cycles after them.
    pub(super) fn new(spec: &CacheSpec, latency: u32, immediate: bool) -> DataCache {
        DataCache {
            cache: Cache::new(spec),
            line: spec.line,
            blocking: spec.blocking,
            slack: match spec.blocking {
                true => 0,
                false => u64::from(latency.saturating_sub(1)),
            },
            late: Vec::new(),
            known: 0,
            deferred: Vec::new(),
            stores: VecDeque::new(),
            max_stores: spec.misses.max(1) as usize,
            requests: VecDeque::new(),
            immediate,
        }
    }

    /// A load of naturally aligned bytes.
    pub(super) fn load(&mut self, address: u32) {
        self.look_up(address / self.line);
    }

    fn look_up(&mut self, line: u32) {
        let result = self.cache.access(line);
        match result {
            Access::Hit | Access::Pending => {}
            Access::Miss => self.request(line),
            Access::Full => self.deferred.push(line),
        }
        if self.immediate {
            if self.cache.outstanding() > 0 {
                self.fill(line * self.line);
            }
        } else if result != Access::Hit && result != Access::Full {
            let slack = self.slack;
            self.late.push(Late { line, slack });
        }
    }

    /// Requests a line of the memory.
    fn request(&mut self, line: u32) {
        // Data stored round the cache has to be in memory first.
        if let Some(i) = self.stores.iter().position(|s| s.0 == line) {
            let (line, bytes) = self.stores.remove(i).expect("just found");
            self.requests.push_back((line * self.line, bytes, true));
        }
        self.requests
            .push_back((line * self.line, self.line, false));
    }

    /// Asks for the line of an address, where a miss more can be outstanding.
    pub(super) fn prefetch(&mut self, address: u32) {
        let line = address / self.line;
        if self.cache.prefetch(line) {
            self.request(line);
            if self.immediate {
                self.fill(line * self.line);
            }
        }
    }

    /// A store of `bytes` naturally aligned bytes.
    pub(super) fn store(&mut self, address: u32, bytes: u32) {
        let line = address / self.line;
        if self.cache.write(line) {
            return;
        }
        if let Some(entry) = self.stores.iter_mut().find(|s| s.0 == line) {
            entry.1 = (entry.1 + bytes).min(self.line);
            return;
        }
        if self.stores.len() == self.max_stores {
            self.send_oldest_store();
        }
        self.stores.push_back((line, bytes));
    }

    fn send_oldest_store(&mut self) {
        if let Some((line, bytes)) = self.stores.pop_front() {
            self.requests.push_back((line * self.line, bytes, true));
        }
    }

    /// True if the core has to stand still.
    pub(super) fn waits(&self) -> bool {
        self.slack() == Some(0) || !self.deferred.is_empty()
    }

    /// Cycles that the engine may run before a value is due whose line is not there; `None` where there is none.
    pub(super) fn slack(&self) -> Option<u64> {
        self.late.iter().map(|late| late.slack).min()
    }

    /// True if a load of the run that goes on has missed or has to wait, or a request goes to the memory: the run ends
    /// with its cycle, and with it the time of the request is known.
    pub(super) fn ends_run(&self) -> bool {
        let sends = !self.immediate && !self.requests.is_empty();
        sends || self.waits() || self.late.len() > self.known
    }

    /// How many lines are on their way while the core may run.
    pub(super) fn under_way(&self) -> usize {
        match self.blocking && self.waits() {
            true => 0,
            false => self.cache.outstanding(),
        }
    }

    /// The engine has run for so many cycles; loads of the run that missed did so in the last one.
    pub(super) fn ran(&mut self, cycles: u64) {
        for late in &mut self.late[..self.known] {
            late.slack = late.slack.saturating_sub(cycles);
        }
        self.known = self.late.len();
    }

    /// A line arrives.
    pub(super) fn fill(&mut self, address: u32) {
        if let Some(back) = self.cache.fill(address / self.line) {
            self.requests.push_back((back * self.line, self.line, true));
        }
        let line = address / self.line;
        self.late.retain(|late| late.line != line);
        for line in std::mem::take(&mut self.deferred) {
            self.look_up(line);
        }
        self.known = self.late.len();
    }

    /// Writes everything back.
    pub(super) fn flush(&mut self) {
        for line in self.cache.flush() {
            self.requests.push_back((line * self.line, self.line, true));
        }
        while !self.stores.is_empty() {
            self.send_oldest_store();
        }
    }

    /// The next request to be sent: address, bytes, and whether it writes.
    #[inline]
    pub(super) fn take_request(&mut self) -> Option<(u32, u32, bool)> {
        self.requests.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cache() -> DataCache {
        DataCache::new(
            &CacheSpec {
                bytes: 256,
                ways: 2,
                line: 64,
                latency: 1,
                banks: 1,
                misses: 1,
                blocking: true,
            },
            4,
            false,
        )
    }

    fn requests(cache: &mut DataCache) -> Vec<(u32, u32, bool)> {
        std::iter::from_fn(|| cache.take_request()).collect()
    }

    #[test]
    fn loads_wait_for_their_lines_one_after_the_other() {
        let mut cache = cache();
        cache.load(0x40);
        cache.load(0x80);
        assert_eq!(requests(&mut cache), [(0x40, 64, false)]);
        cache.fill(0x40);
        assert!(cache.waits());
        assert_eq!(requests(&mut cache), [(0x80, 64, false)]);
        cache.fill(0x80);
        assert!(!cache.waits());
    }

    /// Values are due four cycles after their loads, and two lines may be on their way.
    #[test]
    fn the_core_runs_under_a_miss_until_the_value_is_due() {
        let mut cache = DataCache {
            blocking: false,
            slack: 3,
            ..cache()
        };
        cache.cache = Cache::new(&CacheSpec {
            bytes: 256,
            ways: 2,
            line: 64,
            latency: 1,
            banks: 1,
            misses: 2,
            blocking: false,
        });
        cache.load(0x40);
        assert!(cache.ends_run() && !cache.waits());
        cache.ran(9);
        assert_eq!(requests(&mut cache), [(0x40, 64, false)]);
        assert_eq!((cache.ends_run(), cache.slack()), (false, Some(3)));
        // Another miss two cycles later, which the first one does not wait for.
        cache.load(0x80);
        cache.ran(2);
        assert_eq!(requests(&mut cache), [(0x80, 64, false)]);
        assert_eq!((cache.waits(), cache.slack()), (false, Some(1)));
        cache.ran(1);
        assert!(cache.waits());
        cache.fill(0x40);
        assert_eq!((cache.waits(), cache.slack()), (false, Some(2)));
        // A third one has room now, a fourth one has to wait for it.
        cache.load(0xc0);
        assert!(!cache.waits());
        cache.load(0x100);
        assert!(cache.waits());
        cache.ran(1);
        cache.fill(0x80);
        assert_eq!((cache.waits(), cache.slack()), (false, Some(3)));
        cache.fill(0xc0);
        cache.fill(0x100);
        assert_eq!(cache.slack(), None);
    }

    #[test]
    fn a_prefetch_freezes_nothing_but_a_load_of_its_line_that_comes_too_early() {
        let mut cache = cache();
        cache.prefetch(0x44);
        assert!(cache.ends_run() && !cache.waits());
        assert_eq!(requests(&mut cache), [(0x40, 64, false)]);
        cache.ran(5);
        assert_eq!((cache.ends_run(), cache.under_way()), (false, 1));
        // There is no room for another line, nor need of the same one.
        cache.prefetch(0x80);
        cache.prefetch(0x48);
        assert_eq!(requests(&mut cache), []);
        let counters = cache.cache.counters;
        assert_eq!((counters.prefetches, counters.dropped), (1, 1));
        cache.load(0x40);
        assert!(cache.waits());
        assert_eq!(cache.under_way(), 0);
        cache.fill(0x40);
        assert!(!cache.waits());
        cache.load(0x40);
        assert!(!cache.ends_run());
        let counters = cache.cache.counters;
        assert_eq!((counters.hits, counters.misses, counters.joined), (1, 0, 1));
        // A load of another line waits for the room that a prefetch takes.
        cache.prefetch(0xc0);
        cache.load(0x100);
        assert!(cache.waits());
        cache.fill(0xc0);
        assert_eq!(
            requests(&mut cache),
            [(0xc0, 64, false), (0x100, 64, false)]
        );
        cache.fill(0x100);
        assert!(!cache.waits());
    }

    #[test]
    fn stores_that_miss_are_combined_and_stall_nothing() {
        let mut cache = cache();
        for i in 0..4 {
            cache.store(0x40 + 16 * i, 16);
        }
        assert!(!cache.waits());
        assert_eq!(requests(&mut cache), []);
        cache.store(0x80, 4);
        assert_eq!(requests(&mut cache), [(0x40, 64, true)]);
        // A load of a line that is being stored to lets the store go first.
        cache.load(0x84);
        assert_eq!(requests(&mut cache), [(0x80, 4, true), (0x80, 64, false)]);
    }

    #[test]
    fn stores_that_hit_are_written_back_when_replaced_or_flushed() {
        let mut cache = cache();
        for address in [0x00, 0x80] {
            cache.load(address);
            cache.fill(address);
        }
        cache.store(0x00, 4);
        requests(&mut cache);
        // 0x00, 0x80 and 0x100 share a set of two ways; 0x80 was used longest ago.
        cache.load(0x100);
        cache.fill(0x100);
        cache.load(0x180);
        cache.fill(0x180);
        let written: Vec<_> = requests(&mut cache).into_iter().filter(|r| r.2).collect();
        assert_eq!(written, [(0x00, 64, true)]);
        cache.store(0x180, 4);
        cache.flush();
        assert_eq!(requests(&mut cache), [(0x180, 64, true)]);
    }
}
