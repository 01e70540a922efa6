//! A timeline in Perfetto's format: tracks of cores, their units, rays and caches, and counters over time.
//!
//! A nanosecond of the file is an SRP cycle. The tracks are those of `docs/trace.md`.

use crate::event::{Done, Event, Outside, Turn, What, parts};
use crate::names::{control, short_place};
use crate::protobuf::Message;
use crate::replay::replay;
use crate::trace::Trace;
use srp_csimgen::spec::{Origin, Position};
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::system::{MemoryRequest, Requester};
use srp_runtime::tni::{Client, RayCost, TniCounters};
use std::collections::BTreeMap;

/// The bytes of a file with the timeline of a trace.
pub fn write(trace: &Trace) -> Vec<u8> {
    let mut timeline = Timeline::of(trace);
    replay(trace, &mut |event| timeline.take(&event));
    timeline.finish()
}

/// What happens on a track.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    End,
    Counter(i64),
    Begin(u32),
    Instant(u32),
}

/// An event of a track: those of one time in this order, so that ends come before beginnings.
struct Mark {
    time: u64,
    kind: Kind,
    track: u64,
    at: Position,
    /// A flow that goes through, or ends here.
    flow: Option<(u64, bool)>,
}

/// The tracks of a core.
#[derive(Default)]
struct Core {
    /// What the core does, and since when.
    doing: Option<u32>,
    /// The function whose bundles it issues.
    function: Option<u32>,
    /// Packets in the T&I unit: when they were sent, with how many rays.
    packets: BTreeMap<u64, (u64, u32)>,
}

struct Timeline<'t> {
    trace: &'t Trace,
    marks: Vec<Mark>,
    names: Vec<String>,
    number_of: BTreeMap<String, u32>,
    /// Descriptions of tracks, in the order of their numbers.
    tracks: Vec<Message>,
    track_of: BTreeMap<(u64, String), u64>,
    cores: BTreeMap<u32, Core>,
    /// The name of the function of each bundle.
    functions: Vec<u32>,
    /// Slices of packets and rays, which overlap: core, begin, end, name, whether it is a ray, flow.
    overlapping: Vec<Overlapping>,
}

struct Overlapping {
    group: u64,
    lane: &'static str,
    begin: u64,
    end: u64,
    name: u32,
    flow: u64,
}

impl<'t> Timeline<'t> {
    fn of(trace: &'t Trace) -> Timeline<'t> {
        let mut timeline = Timeline {
            trace,
            marks: Vec::new(),
            names: Vec::new(),
            number_of: BTreeMap::new(),
            tracks: Vec::new(),
            track_of: BTreeMap::new(),
            cores: BTreeMap::new(),
            functions: Vec::new(),
            overlapping: Vec::new(),
        };
        let bundles = 0..trace.spec.bundles.len() as u32;
        let functions = bundles.map(|bundle| {
            let name = trace.spec.function_of(bundle).unwrap_or("?");
            timeline.name(name)
        });
        timeline.functions = functions.collect();
        for core in &trace.cores {
            timeline.cores.insert(core.core, Core::default());
            let group = timeline.group(core.core);
            timeline.track(group, "activity");
            timeline.track(group, "function");
        }
        timeline
    }

    fn name(&mut self, name: &str) -> u32 {
        if let Some(&number) = self.number_of.get(name) {
            return number;
        }
        let number = self.names.len() as u32;
        self.names.push(name.to_owned());
        self.number_of.insert(name.to_owned(), number);
        number
    }

    /// The number of a track below another; 0 is none.
    fn track(&mut self, above: u64, name: &str) -> u64 {
        self.described(above, name, false)
    }

    fn described(&mut self, above: u64, name: &str, counts: bool) -> u64 {
        let next = self.tracks.len() as u64 + 1;
        let key = (above, name.to_owned());
        let track = *self.track_of.entry(key).or_insert(next);
        if track == next {
            let mut description = Message::default();
            description.number(1, track);
            description.text(2, name);
            if above > 0 {
                description.number(5, above);
            }
            if counts {
                description.message(8, &Message::default());
            }
            self.tracks.push(description);
        }
        track
    }

    fn group(&mut self, core: u32) -> u64 {
        self.track(0, &format!("core {core}"))
    }

    fn mark(&mut self, time: u64, track: u64, kind: Kind) {
        self.marks.push(Mark {
            time,
            kind,
            track,
            at: 0,
            flow: None,
        });
    }

    fn slice(&mut self, track: u64, (begin, end): (u64, u64), name: u32, at: Position) {
        self.marks.push(Mark {
            time: begin,
            kind: Kind::Begin(name),
            track,
            at,
            flow: None,
        });
        self.mark(end, track, Kind::End);
    }

    fn count(&mut self, core: u32, time: u64, name: &str, value: u64) {
        let group = self.group(core);
        let track = self.described(group, name, true);
        self.mark(time, track, Kind::Counter(value as i64));
    }

    fn take(&mut self, event: &Event<'_>) {
        let (core, cycle) = (event.core, event.cycle);
        if !self.cores.contains_key(&core) {
            return;
        }
        match event.what {
            What::Cell(..) | What::Preset(..) => {}
            What::Does(doing) => {
                let (word, kernel) = doing.in_words();
                let kernel = kernel.map(|k| self.trace.spec.kernels[k as usize].name.clone());
                let name = self.name(kernel.as_deref().unwrap_or(word));
                let before = self.cores.entry(core).or_default().doing.replace(name);
                self.change(core, cycle, "activity", before, Some(name));
            }
            What::Turn(turn) => {
                let name = match turn {
                    Turn::Bundle(bundle) => Some(self.functions[bundle as usize]),
                    Turn::Context { .. } => None,
                };
                let before = std::mem::replace(&mut self.core(core).function, name);
                if before != name {
                    self.change(core, cycle, "function", before, name);
                }
            }
            What::Control(transfer, at) => {
                let name = control(&self.trace.spec, transfer);
                self.operation(core, cycle, "branches", &name, at);
            }
            What::Step(done) => self.step(core, cycle, &done),
            What::Outside(outside) => self.outside(core, cycle, outside),
        }
    }

    fn core(&mut self, core: u32) -> &mut Core {
        self.cores.entry(core).or_default()
    }

    /// One slice of a track gives way to another.
    fn change(&mut self, core: u32, time: u64, track: &str, old: Option<u32>, new: Option<u32>) {
        let group = self.group(core);
        let track = self.track(group, track);
        if old.is_some() {
            self.mark(time, track, Kind::End);
        }
        if let Some(name) = new {
            self.mark(time, track, Kind::Begin(name));
        }
    }

    fn operation(&mut self, core: u32, cycle: u64, unit: &str, name: &str, at: Position) {
        let group = self.group(core);
        let units = self.track(group, "units");
        let track = self.track(units, unit);
        let name = self.name(name);
        self.slice(track, (cycle, cycle + 1), name, at);
    }

    fn step(&mut self, core: u32, cycle: u64, done: &Done<'_>) {
        let names = &self.trace.names;
        if let (Origin::Unit { unit, .. }, Some(op)) = (done.step.origin, done.step.opcode()) {
            self.operation(core, cycle, names.unit(unit), op.name(), done.step.at);
        }
    }

    fn outside(&mut self, core: u32, cycle: u64, outside: &Outside) {
        match outside {
            Outside::Tile(tile) => {
                let name = tile.map_or("no tile".to_owned(), |tile| format!("tile {tile}"));
                self.instant(core, cycle, "activity", &name, None);
            }
            Outside::PacketSent(sent) => {
                let (packet, rays) = (sent.number, sent.buffers.count);
                self.core(core).packets.insert(packet, (cycle, rays));
                let flow = Some((flow(core, packet), false));
                self.instant(
                    core,
                    cycle,
                    "activity",
                    &format!("send packet {packet}"),
                    flow,
                );
            }
            Outside::PacketReturned(packet, _) => {
                let sent = self.core(core).packets.remove(packet);
                self.packet(core, *packet, sent, cycle);
                let flow = Some((flow(core, *packet), true));
                self.instant(
                    core,
                    cycle,
                    "activity",
                    &format!("take packet {packet}"),
                    flow,
                );
            }
            Outside::Ray(cost) => self.ray(core, cycle, cost),
            Outside::Requested(request) => self.request(core, cycle, request),
            Outside::Occupancy(occupancy) => {
                for (unit, part, rays) in parts(occupancy) {
                    self.count(core, cycle, &format!("{unit} {part}"), u64::from(rays));
                }
            }
            Outside::Counts(counts) => {
                let (data, texture, tni) = &**counts;
                self.cache(core, cycle, "data cache", data);
                self.cache(core, cycle, "texture cache", texture);
                self.tni(core, cycle, tni);
            }
        }
    }

    fn instant(
        &mut self,
        core: u32,
        time: u64,
        track: &str,
        name: &str,
        flow: Option<(u64, bool)>,
    ) {
        let group = self.group(core);
        let (track, name) = (self.track(group, track), self.name(name));
        self.marks.push(Mark {
            time,
            kind: Kind::Instant(name),
            track,
            at: 0,
            flow,
        });
    }

    fn packet(&mut self, core: u32, packet: u64, sent: Option<(u64, u32)>, end: u64) {
        let (begin, rays) = sent.unwrap_or((self.trace.cycles.start, 0));
        let name = match rays {
            0 => format!("packet {packet}"),
            _ => format!("packet {packet}: {rays} rays"),
        };
        self.overlap(core, "packets", (begin, end), &name, flow(core, packet));
    }

    fn ray(&mut self, core: u32, end: u64, cost: &RayCost) {
        let (srp, tni) = self.trace.clocks;
        let cycles = cost.cycles * u64::from(srp) / u64::from(tni.max(1));
        let name = format!("ray {} of packet {}", cost.index, cost.submission);
        let span = (end.saturating_sub(cycles), end);
        self.overlap(core, "rays", span, &name, flow(core, cost.submission));
    }

    fn overlap(&mut self, core: u32, lane: &'static str, span: (u64, u64), name: &str, flow: u64) {
        let group = self.group(core);
        let name = self.name(name);
        self.overlapping.push(Overlapping {
            group,
            lane,
            begin: span.0,
            end: span.1.max(span.0 + 1),
            name,
            flow,
        });
    }

    fn request(&mut self, core: u32, time: u64, request: &MemoryRequest) {
        let who = match request.requester {
            Requester::DataCache => "data cache".to_owned(),
            Requester::TextureCache => "texture cache".to_owned(),
            Requester::InstructionCache => "instruction cache".to_owned(),
            Requester::ConfigurationMemory => "configuration memory".to_owned(),
            Requester::Tni(Client::TrvL2) => "T&I level 2".to_owned(),
            Requester::Tni(Client::IstL1(unit)) => format!("ist{unit} level 1"),
        };
        let does = if request.is_write { "write" } else { "read" };
        let name = format!("{does} {:#010x} {} B", request.address, request.bytes);
        let group = self.group(core);
        let memory = self.track(group, "memory requests");
        let (track, name) = (self.track(memory, &who), self.name(&name));
        self.mark(time, track, Kind::Instant(name));
    }

    fn cache(&mut self, core: u32, time: u64, cache: &str, counts: &CacheCounters) {
        self.count(core, time, &format!("{cache} hits"), counts.hits);
        self.count(core, time, &format!("{cache} misses"), counts.misses);
    }

    fn tni(&mut self, core: u32, time: u64, counts: &TniCounters) {
        let rays = counts.unit.rays.saturating_sub(counts.unit.results);
        self.count(core, time, "rays in T&I unit", rays);
        self.count(core, time, "node visits", counts.node_visits());
        self.count(core, time, "triangle tests", counts.triangle_tests);
        self.cache(core, time, "T&I level 2", &counts.trv_l2);
    }

    /// Gives what overlaps lanes of its own, and ends what is still open.
    fn finish(mut self) -> Vec<u8> {
        let end = self.trace.cycles.end;
        let cores = std::mem::take(&mut self.cores);
        for (number, core) in cores {
            self.change(number, end, "activity", core.doing, None);
            self.change(number, end, "function", core.function, None);
            for (packet, sent) in core.packets {
                self.packet(number, packet, Some(sent), end);
            }
        }
        let mut overlapping = std::mem::take(&mut self.overlapping);
        overlapping.sort_by_key(|slice| (slice.begin, slice.end));
        let mut lanes: BTreeMap<(u64, &str), Vec<u64>> = BTreeMap::new();
        for slice in overlapping {
            let lanes = lanes.entry((slice.group, slice.lane)).or_default();
            let free = lanes.iter().position(|&end| end <= slice.begin);
            let lane = free.unwrap_or(lanes.len());
            lanes.resize(lanes.len().max(lane + 1), 0);
            lanes[lane] = slice.end;
            let above = self.track(slice.group, slice.lane);
            let track = self.track(above, &format!("{} {lane}", slice.lane));
            self.marks.push(Mark {
                time: slice.begin,
                kind: Kind::Begin(slice.name),
                track,
                at: 0,
                flow: Some((slice.flow, false)),
            });
            self.mark(slice.end, track, Kind::End);
        }
        self.marks.sort_by_key(|mark| (mark.time, mark.kind));
        self.bytes()
    }

    fn bytes(self) -> Vec<u8> {
        let mut file = Message::default();
        for (i, track) in self.tracks.iter().enumerate() {
            let mut packet = Message::default();
            packet.number(10, 1);
            if i == 0 {
                // Nothing before this packet is needed.
                packet.number(13, 1);
            }
            packet.message(60, track);
            file.message(1, &packet);
        }
        for mark in &self.marks {
            let mut packet = Message::default();
            packet.number(8, mark.time);
            packet.number(10, 1);
            packet.message(11, &self.event(mark));
            file.message(1, &packet);
        }
        file.into_bytes()
    }

    fn event(&self, mark: &Mark) -> Message {
        let mut event = Message::default();
        let (kind, name) = match mark.kind {
            Kind::Begin(name) => (1, Some(name)),
            Kind::End => (2, None),
            Kind::Instant(name) => (3, Some(name)),
            Kind::Counter(_) => (4, None),
        };
        event.number(9, kind);
        event.number(11, mark.track);
        if let Some(name) = name {
            event.text(23, &self.names[name as usize]);
        }
        if let Kind::Counter(value) = mark.kind {
            event.number(30, value as u64);
        }
        let place = short_place(&self.trace.spec, mark.at).rsplit_once(':');
        if let Some((file, line)) = place {
            let mut location = Message::default();
            location.text(2, file);
            location.number(4, line.parse().unwrap_or(0));
            event.message(33, &location);
        }
        if let Some((flow, ends)) = mark.flow {
            event.fixed(if ends { 48 } else { 47 }, flow);
        }
        event
    }
}

/// The flow of a packet: one for each of a core.
fn flow(core: u32, packet: u64) -> u64 {
    u64::from(core) << 48 | packet
}
