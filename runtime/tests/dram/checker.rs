//! Commands of controllers, checked by rules written anew: no two commands closer than the times say, data
//! never on the lines twice at once, every burst served in its row, and refreshes when they are due. The
//! rules look at pairs of commands and know nothing of how the model keeps time.

use std::collections::BTreeMap;

use srp_archdesc::dram::BankedSpec;
use srp_runtime::memory::dram::device::Command;
use srp_runtime::memory::dram::mapping::Mapping;
use srp_runtime::memory::dram::{Banked, Dram, Request};

use crate::requests::{self, Random};

/// Commands so far back that no time reaches them are not looked at.
const REACH: u64 = 1000;

/// Cycles from an access to when its bank may be closed.
fn recovery(spec: &BankedSpec, is_write: bool) -> u64 {
    let t = &spec.timing;
    match is_write {
        true => u64::from(t.cwl + spec.burst.div_ceil(2) + t.wr),
        false => u64::from(t.rtp),
    }
}

/// An event in a rule for pairs of commands: a command opens or closes a bank, reads, writes or refreshes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Open,
    Close,
    Read,
    Write,
    Refresh,
}

/// One event: cycle, kind, bank. An access that closes its bank is two.
type Event = (u64, Kind, u32);

/// The least number of cycles from one event to a later one, if there is a rule.
fn distance(spec: &BankedSpec, (_, first, a): Event, (_, second, b): Event) -> Option<u32> {
    use Kind::{Close, Open, Read, Refresh, Write};
    let t = &spec.timing;
    let data = spec.burst.div_ceil(2);
    let same = a == b;
    match (first, second) {
        (Open, Open) if same => Some(t.rc.max(t.rrd)),
        (Open, Open) => Some(t.rrd),
        (Open, Read | Write) if same => Some(t.rcd),
        (Open, Close) if same => Some(t.ras),
        (Close, Open) if same => Some(t.rp),
        (Close, Refresh) => Some(t.rp),
        (Read, Read) | (Write, Write) => Some(t.ccd.max(data)),
        (Read, Write) => Some(t.rtw),
        (Write, Read) => Some(t.cwl + data + t.wtr),
        (Read, Close) if same => Some(t.rtp),
        (Write, Close) if same => Some(t.cwl + data + t.wr),
        (Refresh, Open | Refresh) => Some(t.rfc),
        _ => None,
    }
}

/// The events of a channel's commands; asserts that banks are open where they must be.
fn events(spec: &BankedSpec, commands: &[(u64, Command)]) -> Vec<Event> {
    let mut events = Vec::new();
    // Open banks, and when they may be closed.
    let mut open: BTreeMap<u32, u64> = BTreeMap::new();
    for (i, &(cycle, command)) in commands.iter().enumerate() {
        assert!(i == 0 || commands[i - 1].0 < cycle, "one command a cycle");
        match command {
            Command::Activate { bank, .. } => {
                let closing = cycle + u64::from(spec.timing.ras);
                assert_eq!(
                    open.insert(bank, closing),
                    None,
                    "cycle {cycle}: open already"
                );
                events.push((cycle, Kind::Open, bank));
            }
            Command::Precharge { bank } => {
                assert!(
                    open.remove(&bank).is_some(),
                    "cycle {cycle}: closed already"
                );
                events.push((cycle, Kind::Close, bank));
            }
            Command::Read {
                bank, precharge, ..
            }
            | Command::Write {
                bank, precharge, ..
            } => {
                let is_write = matches!(command, Command::Write { .. });
                let closing = open.get_mut(&bank).expect("an open bank");
                *closing = (*closing).max(cycle + recovery(spec, is_write));
                let at = *closing;
                let kind = if is_write { Kind::Write } else { Kind::Read };
                events.push((cycle, kind, bank));
                if precharge {
                    open.remove(&bank);
                    events.push((at, Kind::Close, bank));
                }
            }
            Command::Refresh => {
                assert!(open.is_empty(), "cycle {cycle}: refresh with open banks");
                events.push((cycle, Kind::Refresh, 0));
            }
        }
    }
    events.sort_by_key(|e| e.0);
    events
}

/// Asserts all rules between the commands of a channel.
fn check_times(spec: &BankedSpec, commands: &[(u64, Command)]) {
    let events = events(spec, commands);
    for (i, &later) in events.iter().enumerate() {
        let before = events[..i].iter().rev();
        for &earlier in before.take_while(|e| later.0 - e.0 <= REACH) {
            if let Some(least) = distance(spec, earlier, later) {
                let is = later.0 - earlier.0;
                assert!(
                    is >= u64::from(least),
                    "{earlier:?}, {later:?}: {is} < {least}"
                );
            }
        }
    }
    let opened: Vec<u64> = (events.iter().filter(|e| e.1 == Kind::Open))
        .map(|e| e.0)
        .collect();
    for five in opened.windows(5) {
        let is = five[4] - five[0];
        assert!(is >= u64::from(spec.timing.faw), "{five:?}");
    }
    let data = u64::from(spec.burst).div_ceil(2);
    let mut busy = 0;
    let mut moved: Vec<u64> = (events.iter())
        .filter_map(|e| match e.1 {
            Kind::Read => Some(e.0 + u64::from(spec.timing.cl)),
            _ => None,
        })
        .collect();
    moved.sort_unstable();
    for start in moved {
        assert!(start >= busy, "data of two reads in cycle {start}");
        busy = start + data;
    }
    let refreshed = events.iter().filter(|e| e.1 == Kind::Refresh);
    for (i, refresh) in refreshed.enumerate() {
        let due = (i as u64 + 1) * u64::from(spec.timing.refi);
        let late = refresh
            .0
            .checked_sub(due)
            .expect("no refresh before its time");
        assert!(late <= u64::from(spec.refresh_and_access()), "{late} late");
    }
}

/// Asserts that accesses go to rows that hold their bursts, and that each burst of `expected` is
/// read or written as often as that says.
fn check_places(
    mapping: &Mapping,
    channel: u32,
    commands: &[(u64, Command)],
    expected: &BTreeMap<(u32, bool), u64>,
) {
    let mut rows: BTreeMap<u32, u32> = BTreeMap::new();
    let mut served: BTreeMap<(u32, u32, u32, bool), u64> = BTreeMap::new();
    for &(_, command) in commands {
        match command {
            Command::Activate { bank, row } => drop(rows.insert(bank, row)),
            Command::Read { bank, column, .. } => {
                *served
                    .entry((bank, rows[&bank], column, false))
                    .or_default() += 1;
            }
            Command::Write { bank, column, .. } => {
                *served.entry((bank, rows[&bank], column, true)).or_default() += 1;
            }
            Command::Precharge { .. } | Command::Refresh => {}
        }
    }
    let mut asked: BTreeMap<(u32, u32, u32, bool), u64> = BTreeMap::new();
    for (&(burst, is_write), count) in expected {
        let place = mapping.place(burst);
        if place.channel == channel {
            let key = (place.bank, place.row, place.column, is_write);
            *asked.entry(key).or_default() += count;
        }
    }
    for (place, count) in &served {
        let most = asked.get(place).copied().unwrap_or(0);
        assert!(*count <= most, "{place:?} served {count} times of {most}");
    }
}

/// Offers a stream; returns when each request was answered, in the order of answers.
fn run(memory: &mut Banked, stream: &[(u64, Request)]) -> Vec<(u64, Request)> {
    let mut done = Vec::new();
    let mut now = 0;
    for &(cycle, request) in stream {
        now = cycle.max(now);
        let limit = now + 100_000;
        while let Err(from) = memory.offer(now, request) {
            assert!(from > now, "an earlier cycle to offer it again in");
            assert!(from < limit, "room some time");
            now = from;
        }
        memory.advance(now, &mut done);
        now += 1;
    }
    let limit = now + 1_000_000;
    while let Some(event) = memory.next_event() {
        assert!(event < limit, "an end");
        memory.advance(event, &mut done);
    }
    done
}

fn check(seed: u64) {
    let mut random = Random::new(seed);
    let (memory, spec) = requests::memory(&mut random);
    let stream = requests::stream(&mut random, &memory, 600);
    let mut device = Banked::new(&memory, &spec);
    device.record_commands();
    let done = run(&mut device, &stream);

    assert!(done.is_sorted_by_key(|d| d.0), "answers in order");
    let mut answered: Vec<u32> = done.iter().map(|d| d.1.source).collect();
    answered.sort_unstable();
    assert!(
        answered.into_iter().eq(0..stream.len() as u32),
        "each answered once"
    );

    let mapping = Mapping::new(&memory, &spec);
    let mut expected: BTreeMap<(u32, bool), u64> = BTreeMap::new();
    for (_, request) in &stream {
        let last = mapping.burst(request.address + request.bytes - 1);
        for burst in mapping.burst(request.address)..=last {
            *expected.entry((burst, request.is_write)).or_default() += 1;
        }
    }
    let counters = device.counters();
    let mut bursts = [0, 0];
    for channel in 0..memory.channels {
        let commands = device.commands(channel);
        check_times(&spec, commands);
        check_places(&mapping, channel, commands, &expected);
        let c = &counters.channels[channel as usize];
        bursts[0] += c.reads + c.forwarded_reads + c.joined_reads;
        bursts[1] += c.writes + c.merged_writes;
    }
    let asked = |is_write| -> u64 {
        let of_kind = expected.iter().filter(|((_, w), _)| *w == is_write);
        of_kind.map(|(_, count)| count).sum()
    };
    assert_eq!(bursts[0], asked(false), "every burst is read");
    // Fewer writes are left than a queue would wait with.
    let most = u64::from(memory.channels * spec.controller.write_queue.max(600));
    assert!(bursts[1] <= asked(true) && asked(true) - bursts[1] <= most);
}

#[test]
fn nothing_that_is_issued_breaks_a_rule() {
    for seed in 0..150 {
        let outcome = std::panic::catch_unwind(|| check(seed));
        assert!(outcome.is_ok(), "seed {seed}");
    }
}

/// Which cycles a memory is asked in changes nothing.
#[test]
fn cycle_by_cycle_is_the_same() {
    for seed in 0..40 {
        let mut random = Random::new(1000 + seed);
        let (memory, spec) = requests::memory(&mut random);
        let stream = requests::stream(&mut random, &memory, 100);
        let mut skipping = Banked::new(&memory, &spec);
        let expected = run(&mut skipping, &stream);
        let end = expected.last().map_or(0, |d| d.0);
        let mut stepping = Banked::new(&memory, &spec);
        let (mut done, mut waiting) = (Vec::new(), stream.iter().peekable());
        for now in 0..=end {
            if let Some((_, request)) = waiting.next_if(|(cycle, _)| *cycle <= now)
                && stepping.offer(now, *request).is_err()
            {
                let left = waiting.clone().count() + 1;
                waiting = stream[stream.len() - left..].iter().peekable();
            }
            let before = done.len();
            stepping.advance(now, &mut done);
            assert!(
                done[before..].iter().all(|d| d.0 == now),
                "seed {seed}: late"
            );
        }
        assert_eq!(done, expected, "seed {seed}");
        assert_eq!(stepping.counters().channels.len(), memory.channels as usize);
    }
}
