//! A memory of channels, banks and rows as a [`Dram`].

use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

use srp_archdesc::dram::{BankedSpec, DramSpec};

use super::bank_queue::Transaction;
use super::channel::{Channel, Finished};
use super::device::Command;
use super::mapping::Mapping;
use super::{Dram, DramCounters, Request};

/// A request on its way.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct InFlight {
    request: Request,
    /// Bursts that are not over.
    bursts: u32,
    /// The cycle in which the last of those that are over was.
    over: u64,
    accepted: u64,
    /// Its place in the order of all requests.
    number: u64,
}

/// Answers in the order in which they are given: cycle, number and place of the request.
type Answers = BinaryHeap<Reverse<(u64, u64, u32)>>;

/// Channels with their controllers. A request is divided into the bursts that it touches; it is
/// in the controllers from the cycle after the one in which it is offered, and over with its last
/// burst.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Banked {
    mapping: Mapping,
    channels: Vec<Channel>,
    latency: u64,
    in_flight: Vec<InFlight>,
    free: Vec<u32>,
    answers: Answers,
    finished: Vec<Finished>,
    next_number: u64,
    /// The cycle of the last offer.
    offered: u64,
    counters: DramCounters,
}

impl Banked {
    /// An idle memory.
    pub fn new(memory: &DramSpec, spec: &BankedSpec) -> Banked {
        Banked {
            mapping: Mapping::new(memory, spec),
            channels: vec![Channel::new(spec); memory.channels as usize],
            latency: super::cycles(memory.latency_ns, memory.mhz),
            in_flight: Vec::new(),
            free: Vec::new(),
            answers: BinaryHeap::new(),
            finished: Vec::new(),
            next_number: 0,
            offered: 0,
            counters: DramCounters::default(),
        }
    }

    /// From now on, remembers all commands.
    pub fn record_commands(&mut self) {
        for channel in &mut self.channels {
            channel.commands.get_or_insert_default();
        }
    }

    /// The commands of a channel since [`record_commands`](Self::record_commands), each with its
    /// cycle.
    pub fn commands(&self, channel: u32) -> &[(u64, Command)] {
        let channel = &self.channels[channel as usize];
        channel.commands.as_deref().unwrap_or_default()
    }

    fn run(&mut self, cycle: u64) {
        for i in 0..self.channels.len() {
            self.channels[i].run(cycle, &mut self.finished);
            if self.finished.is_empty() {
                continue;
            }
            let mut finished = std::mem::take(&mut self.finished);
            for &(over, request, accepted) in &finished {
                let counters = &mut self.channels[i].counters;
                counters.read_bursts += 1;
                counters.read_cycles += over - accepted;
                counters.max_read_cycles = counters.max_read_cycles.max(over - accepted);
                self.finish_burst(request, over);
            }
            finished.clear();
            self.finished = finished;
        }
    }

    fn finish_burst(&mut self, request: u32, over: u64) {
        let state = &mut self.in_flight[request as usize];
        state.over = state.over.max(over);
        state.bursts -= 1;
        if state.bursts > 0 {
            return;
        }
        let answer = (state.over + self.latency, state.number, request);
        self.answers.push(Reverse(answer));
    }

    /// The first and the last burst that a request touches.
    fn bursts(&self, request: &Request) -> (u32, u32) {
        let last = request.address.saturating_add(request.bytes.max(1) - 1);
        (
            self.mapping.burst(request.address),
            self.mapping.burst(last),
        )
    }

    /// Checks that every channel has room for its bursts of a request; else fails with the cycle from which
    /// that may change.
    fn room(&mut self, now: u64, first: u32, last: u32, is_write: bool) -> Result<(), u64> {
        for i in 0..self.channels.len() {
            let here = |&burst: &u32| self.mapping.place(burst).channel as usize == i;
            let bursts = (first..=last).filter(here).count();
            if bursts > 0 && !self.channels[i].has_room(bursts, is_write) {
                return Err(self.channels[i].refuse(now, is_write).max(now + 1));
            }
        }
        Ok(())
    }

    /// A place for a request that has been accepted.
    fn enter(&mut self, state: InFlight) -> u32 {
        match self.free.pop() {
            Some(place) => {
                self.in_flight[place as usize] = state;
                place
            }
            None => {
                self.in_flight.push(state);
                self.in_flight.len() as u32 - 1
            }
        }
    }
}

impl Dram for Banked {
    fn offer(&mut self, now: u64, request: Request) -> Result<(), u64> {
        debug_assert!(self.offered <= now, "time goes back");
        self.offered = now;
        self.run(now);
        let (first, last) = self.bursts(&request);
        self.room(now, first, last, request.is_write)?;
        let accepted = now + 1;
        let number = self.next_number;
        self.next_number += 1;
        let place = self.enter(InFlight {
            request,
            bursts: last - first + 1,
            over: 0,
            accepted,
            number,
        });
        for burst in first..=last {
            let transaction = Transaction {
                burst,
                place: self.mapping.place(burst),
                is_write: request.is_write,
                request: place,
                accepted,
            };
            let channel = &mut self.channels[transaction.place.channel as usize];
            if channel.push(transaction) {
                // Answered by the controller itself in the next cycle.
                if !request.is_write {
                    channel.counters.read_bursts += 1;
                    channel.counters.read_cycles += 1;
                }
                self.finish_burst(place, accepted + 1);
            }
        }
        Ok(())
    }

    fn advance(&mut self, now: u64, done: &mut Vec<(u64, Request)>) {
        self.run(now);
        while let Some(&Reverse((over, _, place))) = self.answers.peek()
            && over <= now
        {
            self.answers.pop();
            self.free.push(place);
            let InFlight {
                request, accepted, ..
            } = self.in_flight[place as usize];
            self.counters.answered(&request, over - accepted);
            done.push((over, request));
        }
    }

    fn next_event(&self) -> Option<u64> {
        let answered = self.answers.peek().map(|Reverse((over, ..))| *over);
        let coming = self.channels.iter().filter_map(Channel::next_answer).min();
        let coming = coming.map(|over| over + self.latency);
        [answered, coming].into_iter().flatten().min()
    }

    fn counters(&self) -> DramCounters {
        DramCounters {
            channels: self.channels.iter().map(|c| c.counters).collect(),
            ..self.counters.clone()
        }
    }
}
