//! A set-associative cache, least recently used line replaced: tags and misses only.
//!
//! The cache knows lines by number (address divided by the line size). It never waits by itself:
//! [`Cache::access`] returns the result; the owner sends the request of a miss on its way and calls
//! [`Cache::fill`] when the line arrives.

use crate::sums::sums;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::system::CacheSpec;

/// The result of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// The line is there.
    Hit,
    /// The line is not there and must be requested; it counts as outstanding from now on.
    Miss,
    /// The line has been requested and has not come yet.
    Pending,
    /// The line is not there, and as many misses as the cache allows are outstanding: try again.
    Full,
}

/// Counts of a cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct CacheCounters {
    /// Accesses that found their line.
    pub hits: u64,
    /// Accesses that requested a line.
    pub misses: u64,
    /// Accesses that joined an outstanding miss.
    pub joined: u64,
    /// Dirty lines written back.
    pub writebacks: u64,
    /// Lines that were requested ahead of any access.
    #[serde(default)]
    pub prefetches: u64,
    /// Prefetches of lines for which no room was among the outstanding misses.
    #[serde(default)]
    pub dropped: u64,
}

impl CacheCounters {
    /// Hits among all accesses, from 0 to 1; 1 where there were none. Joining a miss is no hit.
    pub fn hit_rate(&self) -> f64 {
        match self.hits + self.misses + self.joined {
            0 => 1.0,
            all => self.hits as f64 / all as f64,
        }
    }
}

sums!(CacheCounters: hits misses joined writebacks prefetches dropped);

/// Tag of an empty way.
const EMPTY: u32 = u32::MAX;

/// A cache's tags, and its misses on the way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cache {
    sets: u32,
    ways: usize,
    max_misses: usize,
    /// Line numbers, `ways` to a set, most recently used first.
    lines: Vec<u32>,
    dirty: Vec<bool>,
    outstanding: Vec<u32>,
    /// Counts so far.
    pub counters: CacheCounters,
}

impl Cache {
    /// An empty cache.
    pub fn new(spec: &CacheSpec) -> Cache {
        let lines = (spec.sets() * spec.ways) as usize;
        Cache {
            sets: spec.sets(),
            ways: spec.ways as usize,
            max_misses: spec.misses as usize,
            lines: vec![EMPTY; lines],
            dirty: vec![false; lines],
            outstanding: Vec::with_capacity(spec.misses as usize),
            counters: CacheCounters::default(),
        }
    }

    /// Looks for `line` as [`access`](Self::access) does, but without the effects of a miss.
    #[inline]
    pub fn hit(&mut self, line: u32) -> bool {
        let there = self.touch(line);
        self.counters.hits += u64::from(there);
        there
    }

    /// Looks for `line`, and makes it the most recently used of its set.
    #[inline]
    pub fn access(&mut self, line: u32) -> Access {
        if self.hit(line) {
            Access::Hit
        } else if self.outstanding.contains(&line) {
            self.counters.joined += 1;
            Access::Pending
        } else if self.outstanding.len() == self.max_misses {
            Access::Full
        } else {
            self.counters.misses += 1;
            self.outstanding.push(line);
            Access::Miss
        }
    }

    /// Asks for `line` ahead of an access to it. Returns whether it must be requested: it is neither there nor on its
    /// way, and there is room for one more miss.
    pub fn prefetch(&mut self, line: u32) -> bool {
        if self.touch(line) || self.outstanding.contains(&line) {
            return false;
        }
        let has_room = self.outstanding.len() < self.max_misses;
        if has_room {
            self.counters.prefetches += 1;
            self.outstanding.push(line);
        } else {
            self.counters.dropped += 1;
        }
        has_room
    }

    /// Makes `line` the most recently used of its set without counting it, and brings it in if it is neither
    /// there nor on its way; the line that it replaces is not written back. Returns whether it was there.
    #[inline]
    pub fn warm(&mut self, line: u32) -> bool {
        if self.touch(line) {
            return true;
        }
        if !self.outstanding.contains(&line) {
            let counters = self.counters;
            self.fill(line);
            self.counters = counters;
        }
        false
    }

    /// Takes over the lines of another cache of the same form. Counts, and lines on their way, stay.
    pub fn hold_lines_of(&mut self, other: &Cache) {
        self.lines.clone_from(&other.lines);
        self.dirty.clone_from(&other.dirty);
    }

    /// Writes to `line` where it is there: a hit that makes it dirty. Says whether it was.
    pub fn write(&mut self, line: u32) -> bool {
        let there = self.touch(line);
        if there {
            let set = self.set(line);
            self.dirty[set.start] = true;
            self.counters.hits += 1;
        }
        there
    }

    /// A requested line arrives. Returns the line that has to be written back in its place.
    pub fn fill(&mut self, line: u32) -> Option<u32> {
        self.outstanding.retain(|&l| l != line);
        let set = self.set(line);
        let last = set.end - 1;
        let evicted = self.lines[last];
        let written = self.dirty[last];
        self.lines[set.clone()].rotate_right(1);
        self.dirty[set.clone()].rotate_right(1);
        self.lines[set.start] = line;
        self.dirty[set.start] = false;
        let back = (evicted != EMPTY && written).then_some(evicted);
        self.counters.writebacks += u64::from(back.is_some());
        back
    }

    /// Writes everything back: the dirty lines, which are clean afterwards, in the order of sets.
    pub fn flush(&mut self) -> Vec<u32> {
        let mut written = Vec::new();
        for (line, dirty) in self.lines.iter().zip(&mut self.dirty) {
            if std::mem::take(dirty) {
                written.push(*line);
            }
        }
        self.counters.writebacks += written.len() as u64;
        written
    }

    /// How many misses are on the way.
    pub fn outstanding(&self) -> usize {
        self.outstanding.len()
    }

    #[inline]
    fn set(&self, line: u32) -> std::ops::Range<usize> {
        // A power of two in every machine file.
        let set = if self.sets.is_power_of_two() {
            line & (self.sets - 1)
        } else {
            line % self.sets
        };
        let start = set as usize * self.ways;
        start..start + self.ways
    }

    #[inline]
    fn touch(&mut self, line: u32) -> bool {
        let set = self.set(line);
        if self.lines[set.start] == line {
            return true;
        }
        let Some(way) = self.lines[set.clone()].iter().position(|&l| l == line) else {
            return false;
        };
        self.lines[set.start..=set.start + way].rotate_right(1);
        self.dirty[set.start..=set.start + way].rotate_right(1);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// The same cache, written as the definition has it: lines with the time of their last use.
    struct Reference {
        ways: usize,
        sets: u32,
        used: BTreeMap<u32, (u64, bool)>,
        now: u64,
    }

    impl Reference {
        fn access(&mut self, line: u32, write: bool) -> (bool, Option<u32>) {
            self.now += 1;
            if let Some(entry) = self.used.get_mut(&line) {
                *entry = (self.now, entry.1 || write);
                return (true, None);
            }
            let same: Vec<u32> = self
                .used
                .keys()
                .copied()
                .filter(|l| l % self.sets == line % self.sets)
                .collect();
            let mut back = None;
            if same.len() == self.ways {
                let oldest = same
                    .into_iter()
                    .min_by_key(|l| self.used[l].0)
                    .expect("ways ≥ 1");
                let (_, dirty) = self.used.remove(&oldest).expect("just seen");
                back = dirty.then_some(oldest);
            }
            self.used.insert(line, (self.now, write));
            (false, back)
        }
    }

    #[test]
    fn agrees_with_the_definition() {
        let mut state = 1u32;
        let mut random = move |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for (ways, sets) in [(1, 1), (1, 8), (2, 4), (4, 2), (3, 5), (8, 1)] {
            let spec = CacheSpec {
                bytes: ways * sets * 64,
                ways,
                line: 64,
                latency: 1,
                banks: 1,
                misses: 4,
                blocking: true,
            };
            let mut cache = Cache::new(&spec);
            let mut reference = Reference {
                ways: ways as usize,
                sets,
                used: BTreeMap::new(),
                now: 0,
            };
            for _ in 0..20_000 {
                let line = random(ways * sets * 3);
                let write = random(4) == 0;
                let (hit, back) = reference.access(line, write);
                match cache.access(line) {
                    Access::Hit => assert!(hit),
                    Access::Miss => {
                        assert!(!hit);
                        assert_eq!(cache.fill(line), back);
                    }
                    other => panic!("{other:?} with nothing outstanding"),
                }
                if write {
                    assert!(cache.write(line));
                }
            }
            let mut dirty: Vec<u32> = cache.flush();
            dirty.sort_unstable();
            let expected: Vec<u32> = reference
                .used
                .iter()
                .filter(|(_, e)| e.1)
                .map(|(&l, _)| l)
                .collect();
            assert_eq!(dirty, expected);
        }
    }

    #[test]
    fn misses_join_and_are_bounded() {
        let spec = CacheSpec {
            bytes: 256,
            ways: 2,
            line: 64,
            latency: 1,
            banks: 1,
            misses: 2,
            blocking: true,
        };
        let mut cache = Cache::new(&spec);
        assert_eq!(cache.access(1), Access::Miss);
        assert_eq!(cache.access(1), Access::Pending);
        assert_eq!(cache.access(2), Access::Miss);
        assert_eq!(cache.access(3), Access::Full);
        cache.fill(1);
        assert_eq!(cache.access(1), Access::Hit);
        assert_eq!(cache.access(3), Access::Miss);
    }
}
