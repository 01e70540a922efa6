//! The way from the cores to the memory and back: bus and DRAM with their own clocks.
//!
//! Time here is counted in picoseconds since the start of the frame, the one measure that all
//! clocks share. The bus has one channel for requests (and the data of writes) and one for
//! answers; each moves one thing at a time, first come first served.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use srp_archdesc::system::{BusSpec, SystemSpec};

use super::dram::{Dram, DramCounters, Memory, Request};

/// A clock: cycle `n` starts at [`Clock::start`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    mhz: u64,
}

impl Clock {
    /// A clock of `mhz` MHz, at least 1.
    pub fn new(mhz: u32) -> Clock {
        Clock {
            mhz: u64::from(mhz.max(1)),
        }
    }

    /// When cycle `n` starts, in ps.
    #[inline]
    pub fn start(&self, n: u64) -> u64 {
        n * 1_000_000 / self.mhz
    }

    /// The first cycle that starts at `ps` or later.
    #[inline]
    pub fn cycle_from(&self, ps: u64) -> u64 {
        (ps * self.mhz).div_ceil(1_000_000)
    }
}

/// Bus and memory.
#[derive(Clone, Serialize, Deserialize)]
pub struct MemoryPath {
    bus: BusSpec,
    bus_clock: Clock,
    dram_clock: Clock,
    dram: Memory,
    /// Bus cycle from which the request channel is free, and the answer channel.
    request_free: u64,
    answer_free: u64,
    /// On the way to the memory: when they arrive there, in ps.
    to_dram: VecDeque<(u64, Request)>,
    /// On the way back: when they arrive, in ps.
    answers: VecDeque<(u64, Request)>,
    done: Vec<(u64, Request)>,
    /// Cycle of the memory in which it has taken the last request; one behind another that waited for room arrives
    /// before it, and is not offered before it.
    taken: u64,
    in_flight: u32,
    /// A time, in ps, before which nothing arrives at the memory or leaves it.
    wakes: u64,
    /// Bus cycles in which the request channel moved something.
    request_cycles: u64,
    /// Bus cycles in which the answer channel moved something.
    answer_cycles: u64,
}

/// The work of the buses of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct BusReport {
    /// Bytes that a channel moves in a cycle.
    pub width: u32,
    /// Clock, MHz.
    pub mhz: u32,
    /// Part of its cycles in which the channel of requests, and of the data of writes, moved something, from 0 to 1.
    pub requests: f64,
    /// The same of the channel of answers.
    pub answers: f64,
}

impl BusReport {
    /// The report of buses that are alike, at a time since the start in ps.
    pub(crate) fn of(spec: &BusSpec, paths: &[MemoryPath], end: u64) -> BusReport {
        let cycles = Clock::new(spec.mhz).cycle_from(end) * paths.len() as u64;
        let part = |moved: fn(&MemoryPath) -> u64| {
            let moved: u64 = paths.iter().map(moved).sum();
            moved as f64 / cycles.max(1) as f64
        };
        BusReport {
            width: spec.width,
            mhz: spec.mhz,
            requests: part(|path| path.request_cycles),
            answers: part(|path| path.answer_cycles),
        }
    }

    /// The report as a line of text, for people.
    pub(crate) fn text(&self) -> String {
        format!(
            "bus: answers take {:.1} % of its cycles, requests and writes {:.1} %, {} bytes at {} MHz\n",
            100.0 * self.answers,
            100.0 * self.requests,
            self.width,
            self.mhz,
        )
    }
}

impl MemoryPath {
    /// An idle path with the memory that the machine names.
    pub fn new(spec: &SystemSpec) -> MemoryPath {
        MemoryPath::of(spec.bus, spec.dram.mhz, Memory::new(&spec.dram))
    }

    /// An idle path to `dram`, whose clock is of `mhz` MHz.
    pub fn of(bus: BusSpec, mhz: u32, dram: Memory) -> MemoryPath {
        MemoryPath {
            bus,
            bus_clock: Clock::new(bus.mhz),
            dram_clock: Clock::new(mhz),
            dram,
            request_free: 0,
            answer_free: 0,
            to_dram: VecDeque::new(),
            answers: VecDeque::new(),
            done: Vec::new(),
            taken: 0,
            in_flight: 0,
            wakes: u64::MAX,
            request_cycles: 0,
            answer_cycles: 0,
        }
    }

    /// Sends a request at `now`. Requests must be sent in the order of their times. Every request
    /// is answered, writes too.
    pub fn request(&mut self, now: u64, request: Request) {
        // A request takes one beat; the data of a write follow it.
        let beats = if request.is_write {
            1 + self.beats(request.bytes)
        } else {
            1
        };
        let start = self.bus_clock.cycle_from(now).max(self.request_free);
        self.request_free = start + beats;
        self.request_cycles += beats;
        let arrival = start + beats - 1 + u64::from(self.bus.latency);
        let arrival = self.bus_clock.start(arrival);
        self.to_dram.push_back((arrival, request));
        self.wakes = self.wakes.min(arrival);
        self.in_flight += 1;
    }

    /// The next request that is answered by `now`.
    #[inline]
    pub fn answer(&mut self, now: u64) -> Option<Request> {
        if self.in_flight == 0 {
            return None;
        }
        if self.wakes <= now {
            self.advance(now);
        }
        let (_, request) = self.answers.pop_front_if(|(at, _)| *at <= now)?;
        self.in_flight -= 1;
        Some(request)
    }

    /// A time before which [`answer`](Self::answer) has nothing to give; `None` where nothing is
    /// on the way.
    pub fn next_event(&self) -> Option<u64> {
        if self.in_flight == 0 {
            return None;
        }
        let answered = self.answers.front().map_or(u64::MAX, |(at, _)| *at);
        Some(answered.min(self.wakes))
    }

    /// A time before which no read of these `sources` is answered, whatever is sent behind what is on the way; `None`
    /// where nothing is.
    pub fn earliest_answer(&self, sources: impl Fn(u32) -> bool) -> Option<u64> {
        let mut back = self.answers.iter();
        // Answers come one after the other, and behind them what has not left the memory yet.
        match back.find(|(_, request)| !request.is_write && sources(request.source)) {
            Some(&(first, _)) => Some(first),
            None if self.wakes == u64::MAX => None,
            None => {
                let cycle = self.bus_clock.cycle_from(self.wakes);
                Some(self.bus_clock.start(cycle + u64::from(self.bus.latency)))
            }
        }
    }

    /// How many requests are on the way.
    pub fn in_flight(&self) -> u32 {
        self.in_flight
    }

    /// Counts of the memory.
    pub fn counters(&self) -> DramCounters {
        self.dram.counters()
    }

    fn beats(&self, bytes: u32) -> u64 {
        u64::from(bytes.div_ceil(self.bus.width.max(1)))
    }

    fn advance(&mut self, now: u64) {
        while let Some(&(at, request)) = self.to_dram.front()
            && at <= now
        {
            let cycle = self.dram_clock.cycle_from(at).max(self.taken);
            match self.dram.offer(cycle, request) {
                Ok(()) => {
                    self.taken = cycle;
                    self.to_dram.pop_front();
                }
                Err(from) => self.to_dram[0].0 = self.dram_clock.start(from).max(at + 1),
            }
        }
        // The cycle that is over by now, if one is.
        if let Some(cycle) = self.dram_clock.cycle_from(now + 1).checked_sub(1) {
            self.dram.advance(cycle, &mut self.done);
            self.send_answers();
        }
        let arriving = self.to_dram.front().map(|(at, _)| *at);
        let in_dram = self.dram.next_event().map(|c| self.dram_clock.start(c));
        self.wakes = [arriving, in_dram]
            .into_iter()
            .flatten()
            .min()
            .unwrap_or(u64::MAX);
    }

    fn send_answers(&mut self) {
        for (over, request) in self.done.drain(..) {
            let beats = match request.is_write {
                true => 1,
                false => u64::from(request.bytes.div_ceil(self.bus.width.max(1))),
            };
            let ready = self.bus_clock.cycle_from(self.dram_clock.start(over));
            let start = ready.max(self.answer_free);
            self.answer_free = start + beats;
            self.answer_cycles += beats;
            let arrival = start + beats - 1 + u64::from(self.bus.latency);
            self.answers
                .push_back((self.bus_clock.start(arrival), request));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_archdesc::dram::{DramSpec, FIXED, presets};

    const BUS: BusSpec = BusSpec {
        width: 16,
        mhz: 1000,
        latency: 4,
    };

    fn path(dram: &DramSpec) -> MemoryPath {
        MemoryPath::of(BUS, dram.mhz, Memory::new(dram))
    }

    /// One channel in which every access takes 100 ns.
    fn fixed() -> MemoryPath {
        path(&DramSpec {
            channels: 1,
            latency_ns: 100,
            ..FIXED
        })
    }

    fn read(source: u32) -> Request {
        Request {
            address: 64 * source,
            bytes: 64,
            is_write: false,
            source,
        }
    }

    /// When each of the requests is answered, in ps.
    fn times(path: &mut MemoryPath) -> Vec<(u64, u32)> {
        let mut times = Vec::new();
        for now in (0..2_000_000).step_by(250) {
            while let Some(request) = path.answer(now) {
                times.push((now, request.source));
            }
        }
        times
    }

    #[test]
    fn a_read_crosses_the_bus_twice() {
        let mut path = fixed();
        path.request(0, read(0));
        // 4 ns there (3.2 memory cycles, so from cycle 4 on), 88 memory cycles of 1.25 ns, then
        // 4 beats of which the last starts 3 ns later, and 4 ns back.
        let over = (4 + 88) * 1250;
        assert_eq!(times(&mut path), [(over + 3000 + 4000, 0)]);
        assert_eq!(path.in_flight(), 0);
    }

    #[test]
    fn requests_queue_for_the_memory() {
        let mut path = fixed();
        for i in 0..3 {
            path.request(0, read(i));
        }
        let times = times(&mut path);
        let order: Vec<u32> = times.iter().map(|t| t.1).collect();
        assert_eq!(order, [0, 1, 2]);
        // One channel moves a line in 8 memory cycles: 10 ns.
        assert_eq!(times[1].0 - times[0].0, 10_000);
        assert_eq!(times[2].0 - times[1].0, 10_000);
    }

    /// Requests that wait behind one for which the memory has no room are taken after it, and none is answered sooner
    /// than one alone.
    #[test]
    fn a_full_memory_holds_up_what_is_behind() {
        let [spec, ..] = presets();
        let mut path = path(&spec.spec);
        for i in 0..100_u32 {
            let request = Request {
                address: i.wrapping_mul(0x9e37_79b1) & 0xff_ff80,
                bytes: 64 << (i % 2),
                ..read(i)
            };
            path.request(1000 * u64::from(i), request);
        }
        let times = times(&mut path);
        assert_eq!(times.len(), 100);
        let counters = path.counters();
        let bursts = 100 * 6;
        let cycles: u64 = counters.channels.iter().map(|c| c.read_cycles).sum();
        assert!(cycles > bursts * 10 && cycles < bursts * 2000, "{cycles}");
    }

    /// Looking more often changes nothing: the memory is simulated to the same end.
    #[test]
    fn answers_do_not_depend_on_when_they_are_asked_for() {
        for preset in presets() {
            let (mut often, mut seldom) = (path(&preset.spec), path(&preset.spec));
            let mut expected = Vec::new();
            let mut answered = Vec::new();
            let mut state = 1u32;
            for now in (0..3_000_000).step_by(1000) {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if state >> 24 < 60 {
                    let request = Request {
                        address: (state >> 3) & 0xf_ffc0,
                        bytes: 64,
                        is_write: state & 1 << 23 != 0,
                        source: now as u32,
                    };
                    often.request(now, request);
                    seldom.request(now, request);
                }
                while let Some(request) = often.answer(now) {
                    expected.push((now, request));
                }
                if seldom.next_event().is_some_and(|at| at <= now) {
                    while let Some(request) = seldom.answer(now) {
                        answered.push((now, request));
                    }
                }
            }
            assert!(expected.len() > 300, "{} answers", expected.len());
            assert_eq!(answered, expected, "{}", preset.name);
        }
    }
}
