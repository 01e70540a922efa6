//! Perfetto's protocol buffers, decoded by other code than wrote them.

use prost::Message;
use std::collections::BTreeMap;

#[derive(Clone, PartialEq, Message)]
struct File {
    #[prost(message, repeated, tag = "1")]
    packets: Vec<Packet>,
}

#[derive(Clone, PartialEq, Message)]
struct Packet {
    #[prost(uint64, tag = "8")]
    timestamp: u64,
    #[prost(uint32, tag = "10")]
    sequence: u32,
    #[prost(message, optional, tag = "11")]
    event: Option<TrackEvent>,
    #[prost(message, optional, tag = "60")]
    track: Option<TrackDescriptor>,
}

#[derive(Clone, PartialEq, Message)]
struct TrackEvent {
    #[prost(uint32, tag = "9")]
    kind: u32,
    #[prost(uint64, tag = "11")]
    track: u64,
    #[prost(string, tag = "23")]
    name: String,
    #[prost(int64, tag = "30")]
    counter: i64,
    #[prost(message, optional, tag = "33")]
    location: Option<Location>,
    #[prost(fixed64, repeated, packed = "false", tag = "47")]
    flows: Vec<u64>,
    #[prost(fixed64, repeated, packed = "false", tag = "48")]
    ended_flows: Vec<u64>,
}

#[derive(Clone, PartialEq, Message)]
struct Location {
    #[prost(string, tag = "2")]
    file: String,
    #[prost(uint32, tag = "4")]
    line: u32,
}

#[derive(Clone, PartialEq, Message)]
struct TrackDescriptor {
    #[prost(uint64, tag = "1")]
    uuid: u64,
    #[prost(string, tag = "2")]
    name: String,
    #[prost(uint64, tag = "5")]
    parent: u64,
    #[prost(message, optional, tag = "8")]
    counter: Option<Nothing>,
}

#[derive(Clone, PartialEq, Message)]
struct Nothing {}

/// A slice of a track.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Slice {
    pub(crate) begin: u64,
    pub(crate) end: u64,
    pub(crate) name: String,
    /// `file:line`, where there is one.
    pub(crate) place: Option<String>,
}

/// A timeline; tracks by their path.
#[derive(Default)]
pub(crate) struct Timeline {
    pub(crate) packets: usize,
    pub(crate) slices: BTreeMap<String, Vec<Slice>>,
    pub(crate) instants: BTreeMap<String, Vec<(u64, String)>>,
    pub(crate) counters: BTreeMap<String, Vec<(u64, i64)>>,
    /// Places that flows go through, and those where they end.
    pub(crate) flows: BTreeMap<u64, (usize, usize)>,
}

/// Decodes a file. Times ascend, every event's track is described before, and every slice ends.
pub(crate) fn read(bytes: &[u8]) -> Timeline {
    let file = File::decode(bytes).expect("it is a file of Perfetto");
    let mut timeline = Timeline {
        packets: file.packets.len(),
        ..Timeline::default()
    };
    let mut paths: BTreeMap<u64, String> = BTreeMap::new();
    let mut open: BTreeMap<u64, Vec<Slice>> = BTreeMap::new();
    let mut time = 0;
    for packet in file.packets {
        assert_eq!(packet.sequence, 1);
        if let Some(track) = packet.track {
            let above = paths.get(&track.parent).map(|path| format!("{path}/"));
            assert!(track.parent == 0 || above.is_some());
            let path = above.unwrap_or_default() + &track.name;
            assert!(paths.insert(track.uuid, path).is_none());
        }
        let Some(event) = packet.event else { continue };
        assert!(packet.timestamp >= time);
        time = packet.timestamp;
        let path = paths.get(&event.track).expect("it is described").clone();
        event
            .flows
            .iter()
            .for_each(|&f| timeline.flows.entry(f).or_default().0 += 1);
        (event.ended_flows.iter()).for_each(|&f| timeline.flows.entry(f).or_default().1 += 1);
        match event.kind {
            1 => open.entry(event.track).or_default().push(Slice {
                begin: time,
                end: time,
                name: event.name,
                place: event.location.map(|l| format!("{}:{}", l.file, l.line)),
            }),
            2 => {
                let slice = open.get_mut(&event.track).and_then(Vec::pop);
                let slice =
                    slice.unwrap_or_else(|| panic!("{path} ends what did not begin at {time}"));
                let slice = Slice { end: time, ..slice };
                timeline.slices.entry(path).or_default().push(slice);
            }
            3 => timeline
                .instants
                .entry(path)
                .or_default()
                .push((time, event.name)),
            4 => timeline
                .counters
                .entry(path)
                .or_default()
                .push((time, event.counter)),
            kind => panic!("{kind}"),
        }
    }
    assert!(open.values().all(Vec::is_empty), "a slice does not end");
    timeline
}

impl Timeline {
    /// Cycles of a track by the names of its slices, which do not overlap.
    pub(crate) fn cycles(&self, track: &str) -> BTreeMap<String, u64> {
        let mut sums = BTreeMap::new();
        let mut before = 0;
        for slice in self.slices.get(track).into_iter().flatten() {
            assert!(
                slice.begin >= before && slice.end > slice.begin,
                "{slice:?}"
            );
            before = slice.end;
            *sums.entry(slice.name.clone()).or_default() += slice.end - slice.begin;
        }
        sums
    }

    /// How many slices the tracks below one have.
    pub(crate) fn count(&self, above: &str) -> usize {
        let below = self
            .slices
            .iter()
            .filter(|(path, _)| path.starts_with(above));
        below.map(|(_, slices)| slices.len()).sum()
    }
}
