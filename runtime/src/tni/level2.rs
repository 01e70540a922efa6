//! The level-2 cache that the traversal units share: banks that each take one request a cycle.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use srp_archdesc::system::CacheSpec;

use crate::memory::cache::{Access, Cache};

/// Banked cache, its requests and its answers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Level2 {
    pub(super) cache: Cache,
    latency: u64,
    line: u32,
    /// Requests that wait for their bank: traversal unit and byte address.
    banks: Vec<VecDeque<(u32, u32)>>,
    /// Requests that wait for memory, with the line they wait for.
    waiting: Vec<(u32, u32, u32)>,
    /// Answers on the way: the cycle of their arrival, traversal unit and byte address.
    answers: VecDeque<(u64, u32, u32)>,
    queued: u32,
}

impl Level2 {
    pub(super) fn new(spec: &CacheSpec) -> Level2 {
        Level2 {
            cache: Cache::new(spec),
            latency: u64::from(spec.latency),
            line: spec.line,
            banks: vec![VecDeque::new(); spec.banks.max(1) as usize],
            waiting: Vec::new(),
            answers: VecDeque::new(),
            queued: 0,
        }
    }

    /// Traversal unit `trv` asks for the line of its level-1 cache that starts at `address`.
    pub(super) fn request(&mut self, trv: u32, address: u32) {
        let bank = address / self.line % self.banks.len() as u32;
        self.banks[bank as usize].push_back((trv, address));
        self.queued += 1;
    }

    /// One cycle of all banks; addresses of lines to be read from memory go to `outbox`.
    pub(super) fn tick(&mut self, now: u64, mut outbox: impl FnMut(u32)) {
        if self.queued == 0 {
            return;
        }
        for bank in &mut self.banks {
            let Some(&(trv, address)) = bank.front() else {
                continue;
            };
            let line = address / self.line;
            match self.cache.access(line) {
                Access::Hit => self.answers.push_back((now + self.latency, trv, address)),
                Access::Miss => {
                    outbox(line * self.line);
                    self.waiting.push((line, trv, address));
                }
                Access::Pending => self.waiting.push((line, trv, address)),
                Access::Full => continue,
            }
            bank.pop_front();
            self.queued -= 1;
        }
    }

    /// The line at `address` arrives from memory.
    pub(super) fn fill(&mut self, now: u64, address: u32) {
        let line = address / self.line;
        self.cache.fill(line);
        for &(waits_for, trv, address) in &self.waiting {
            if waits_for == line {
                self.answers.push_back((now + self.latency, trv, address));
            }
        }
        self.waiting.retain(|w| w.0 != line);
    }

    /// The next answer that has arrived by `now`: traversal unit and address.
    pub(super) fn answer(&mut self, now: u64) -> Option<(u32, u32)> {
        let (_, trv, address) = self.answers.pop_front_if(|(at, ..)| *at <= now)?;
        Some((trv, address))
    }
}
