//! The data cache of one core, and the lines on their way between it and the memory.
//!
//! Loads allocate lines and stall the core when they miss. Stores never stall: one that hits marks
//! its line, which is written back when it is replaced; one that misses goes round the cache into a
//! small buffer that combines neighbouring stores into lines (streams of pixels would otherwise
//! read every line of the frame buffer before overwriting it).

use std::collections::VecDeque;

use srp_archdesc::system::CacheSpec;

use crate::memory::cache::{Access, Cache};

/// Cache, store buffer and requests.
#[derive(Clone, Debug)]
pub(super) struct DataCache {
    pub(super) cache: Cache,
    line: u32,
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
    pub(super) fn new(spec: &CacheSpec, immediate: bool) -> DataCache {
        DataCache {
            cache: Cache::new(spec),
            line: spec.line,
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
        match self.cache.access(line) {
            Access::Hit | Access::Pending => {}
            Access::Miss => {
                // Data stored round the cache has to be in memory first.
                if let Some(i) = self.stores.iter().position(|s| s.0 == line) {
                    let (line, bytes) = self.stores.remove(i).expect("just found");
                    self.requests.push_back((line * self.line, bytes, true));
                }
                self.requests
                    .push_back((line * self.line, self.line, false));
            }
            Access::Full => self.deferred.push(line),
        }
        if self.immediate && self.cache.outstanding() > 0 {
            self.fill(line * self.line);
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

    /// True if loads wait for lines.
    pub(super) fn waits(&self) -> bool {
        self.cache.outstanding() > 0 || !self.deferred.is_empty()
    }

    /// A line arrives.
    pub(super) fn fill(&mut self, address: u32) {
        if let Some(back) = self.cache.fill(address / self.line) {
            self.requests.push_back((back * self.line, self.line, true));
        }
        for line in std::mem::take(&mut self.deferred) {
            self.look_up(line);
        }
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
            },
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
