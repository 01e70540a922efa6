//! Each time between commands by itself: a command is issued, and the first cycle of another is
//! asserted; once with the time and once with one cycle more, so that each is its own.

use srp_archdesc::dram::{BankedSpec, DramModel, DramSpec, DramTiming, RowPolicy};
use srp_runtime::memory::dram::device::{Command, Device};
use srp_runtime::memory::dram::{Banked, Dram, Request};

/// Times in which no sum of some is another.
const TIMING: DramTiming = DramTiming {
    cl: 11,
    cwl: 7,
    rcd: 13,
    rp: 17,
    ras: 29,
    rc: 59,
    rrd: 5,
    faw: 43,
    wtr: 6,
    rtw: 9,
    wr: 19,
    rtp: 8,
    ccd: 4,
    rfc: 101,
    refi: 0,
};

fn spec(timing: DramTiming) -> BankedSpec {
    let named = srp_archdesc::dram::presets();
    let lpddr3 = named.into_iter().find(|p| p.name == "lpddr3-1600");
    match lpddr3.expect("the preset").spec.model {
        DramModel::Banked(spec) => BankedSpec { timing, ..spec },
        DramModel::Fixed => panic!("a memory with banks"),
    }
}

fn activate(bank: u32) -> Command {
    Command::Activate { bank, row: 1 }
}

fn read(bank: u32) -> Command {
    Command::Read {
        bank,
        column: 0,
        precharge: false,
    }
}

fn write(bank: u32) -> Command {
    Command::Write {
        bank,
        column: 0,
        precharge: false,
    }
}

fn precharge(bank: u32) -> Command {
    Command::Precharge { bank }
}

/// When `then` can be issued after these commands, each issued in its cycle.
#[track_caller]
fn first(timing: DramTiming, issued: &[(u64, Command)], then: Command) -> u64 {
    let mut device = Device::new(&spec(timing));
    for &(cycle, command) in issued {
        device.issue(cycle, command);
    }
    device.earliest(then).expect("a state for the command")
}

/// Asserts that `then` can be issued in this cycle, and a cycle later where `longer` is longer.
#[track_caller]
fn probe(
    issued: &[(u64, Command)],
    then: Command,
    expected: u64,
    longer: impl Fn(&mut DramTiming) -> &mut u32,
) {
    assert_eq!(first(TIMING, issued, then), expected);
    let mut timing = TIMING;
    *longer(&mut timing) += 1;
    assert_eq!(first(timing, issued, then), expected + 1);
}

#[test]
fn between_activation_and_access() {
    probe(&[(100, activate(0))], read(0), 113, |t| &mut t.rcd);
    probe(&[(100, activate(0))], write(0), 113, |t| &mut t.rcd);
}

#[test]
fn between_activation_and_precharge() {
    probe(&[(100, activate(0))], precharge(0), 129, |t| &mut t.ras);
}

#[test]
fn between_precharge_and_activation() {
    let closed = [(100, activate(0)), (200, precharge(0))];
    probe(&closed, activate(0), 217, |t| &mut t.rp);
}

#[test]
fn between_precharge_and_refresh() {
    let closed = [(100, activate(0)), (200, precharge(0))];
    probe(&closed, Command::Refresh, 217, |t| &mut t.rp);
}

#[test]
fn between_activations_of_a_bank() {
    let closed = [(100, activate(0)), (129, precharge(0))];
    probe(&closed, activate(0), 159, |t| &mut t.rc);
}

#[test]
fn between_activations_of_two_banks() {
    probe(&[(100, activate(0))], activate(1), 105, |t| &mut t.rrd);
}

#[test]
fn between_an_activation_and_the_fourth_after_it() {
    let four: Vec<_> = (0..4).map(|i| (100 + 6 * i, activate(i as u32))).collect();
    probe(&four, activate(4), 143, |t| &mut t.faw);
    let five: Vec<_> = four.into_iter().chain([(143, activate(4))]).collect();
    assert_eq!(first(TIMING, &five, activate(5)), 149);
    assert_eq!(first(TIMING, &five[..3], activate(5)), 117);
}

#[test]
fn between_reads_and_between_writes() {
    let open = [(100, activate(0)), (150, activate(1))];
    for bank in [0, 1] {
        let after_read = [open[0], open[1], (200, read(0))];
        let after_write = [open[0], open[1], (200, write(0))];
        probe(&after_read, read(bank), 204, |t| &mut t.ccd);
        probe(&after_write, write(bank), 204, |t| &mut t.ccd);
    }
    // Eight columns take four cycles, however small tCCD is.
    let timing = DramTiming { ccd: 1, ..TIMING };
    let after = [open[0], open[1], (200, read(0))];
    assert_eq!(first(timing, &after, read(1)), 204);
}

#[test]
fn between_a_read_and_a_write() {
    let open = [(100, activate(0)), (150, activate(1)), (200, read(0))];
    for bank in [0, 1] {
        probe(&open, write(bank), 209, |t| &mut t.rtw);
    }
}

#[test]
fn between_the_data_of_a_write_and_a_read() {
    let open = [(100, activate(0)), (150, activate(1)), (200, write(0))];
    for bank in [0, 1] {
        // 7 cycles to the data, 4 of data, 6.
        probe(&open, read(bank), 217, |t| &mut t.wtr);
        probe(&open, read(bank), 217, |t| &mut t.cwl);
    }
}

#[test]
fn between_a_read_and_precharge() {
    let open = [(100, activate(0)), (200, read(0))];
    probe(&open, precharge(0), 208, |t| &mut t.rtp);
    // Not of another bank.
    let open = [(100, activate(0)), (105, activate(1)), (200, read(0))];
    assert_eq!(first(TIMING, &open, precharge(1)), 134);
}

#[test]
fn between_the_data_of_a_write_and_precharge() {
    let open = [(100, activate(0)), (200, write(0))];
    // 7 cycles to the data, 4 of data, 19.
    probe(&open, precharge(0), 230, |t| &mut t.wr);
    probe(&open, precharge(0), 230, |t| &mut t.cwl);
}

#[test]
fn behind_an_access_that_closes_its_bank() {
    let closing = Command::Read {
        bank: 0,
        column: 0,
        precharge: true,
    };
    // Closed after tRTP, and not before tRAS.
    let late = [(100, activate(0)), (200, closing)];
    probe(&late, activate(0), 200 + 8 + 17, |t| &mut t.rtp);
    let early = [(100, activate(0)), (113, closing)];
    let timing = DramTiming { rc: 0, ..TIMING };
    assert_eq!(first(timing, &early, activate(0)), 100 + 29 + 17);
}

#[test]
fn after_refresh() {
    let refreshed = [(100, Command::Refresh)];
    probe(&refreshed, activate(3), 201, |t| &mut t.rfc);
    probe(&refreshed, Command::Refresh, 201, |t| &mut t.rfc);
}

#[test]
fn banks_are_open_or_closed() {
    let mut device = Device::new(&spec(TIMING));
    assert_eq!(device.earliest(read(0)), None);
    assert_eq!(device.earliest(precharge(0)), None);
    device.issue(0, activate(0));
    assert_eq!(device.row(0), Some(1));
    assert_eq!(device.earliest(activate(0)), None);
    assert_eq!(device.earliest(Command::Refresh), None);
    device.issue(29, precharge(0));
    assert_eq!(device.row(0), None);
}

fn memory(edit: impl Fn(&mut BankedSpec)) -> Banked {
    let named = srp_archdesc::dram::presets();
    let lpddr3 = named.into_iter().find(|p| p.name == "lpddr3-1600");
    let mut banked = spec(TIMING);
    edit(&mut banked);
    let memory = DramSpec {
        model: DramModel::Banked(banked.clone()),
        ..lpddr3.expect("the preset").spec
    };
    Banked::new(&memory, &banked)
}

fn request(address: u32, is_write: bool) -> Request {
    Request {
        address,
        bytes: 32,
        is_write,
        source: address,
    }
}

/// The cycle of each answer to requests that are all offered in cycle 0.
fn answers(mut memory: Banked, requests: &[Request]) -> Vec<(u64, u32)> {
    for &request in requests {
        assert_eq!(memory.offer(0, request), Ok(()));
    }
    let mut done = Vec::new();
    while let Some(event) = memory.next_event() {
        memory.advance(event, &mut done);
    }
    done.iter().map(|(over, r)| (*over, r.source)).collect()
}

#[test]
fn a_read_of_a_resting_memory() {
    // Taken in cycle 1, in its bank's queue in 2: activation, tRCD, tCL, and 4 cycles of data.
    let over = 2 + 13 + 11 + 4;
    assert_eq!(answers(memory(|_| {}), &[request(0, false)]), [(over, 0)]);
    let slower = memory(|s| s.timing.cl += 1);
    assert_eq!(answers(slower, &[request(0, false)]), [(over + 1, 0)]);
    let longer = memory(|s| {
        s.burst = 16;
        s.mapping[3].bits -= 1;
    });
    assert_eq!(answers(longer, &[request(0, false)]), [(over + 4, 0)]);
}

#[test]
fn a_row_hit_overtakes_and_a_row_has_its_share() {
    const ROW: u32 = 1 << 16;
    // One bank: row 0, row 1, then six more of row 0.
    let mut requests = vec![request(0, false), request(ROW, false)];
    requests.extend((1..7).map(|i| request(32 * i, false)));
    let order = |hits| -> Vec<u32> {
        let memory = memory(|s| {
            (s.timing.ras, s.timing.rtp) = (20, 2);
            s.controller.row_hits = hits;
        });
        answers(memory, &requests).iter().map(|a| a.1).collect()
    };
    // The other row is opened after four accesses, or after all.
    let hits_first = order(100);
    assert_eq!(hits_first.last(), Some(&ROW));
    let place = order(4).iter().position(|&a| a == ROW);
    assert_eq!(place, Some(4));
}

#[test]
fn writes_are_answered_at_once_and_what_is_to_be_written_is_read_at_once() {
    let requests = [request(64, true), request(64, false), request(64, true)];
    let both = answers(memory(|_| {}), &requests);
    assert_eq!(both, [(2, 64), (2, 64), (2, 64)]);
    let twice = answers(memory(|_| {}), &[request(0, false), request(0, false)]);
    assert_eq!(twice, [(30, 0), (30, 0)]);
}

#[test]
fn queues_fill() {
    let mut memory = memory(|s| {
        s.controller.read_queue = 3;
        s.controller.command_queue = 2;
    });
    for i in 0..3 {
        assert_eq!(memory.offer(0, request(32 * i, false)), Ok(()));
    }
    let mut now = 0;
    let mut tries = 0;
    while let Err(from) = memory.offer(now, request(96, false)) {
        assert!(from > now);
        (now, tries) = (from, tries + 1);
        assert!(tries < 100);
    }
    // The first request leaves the queue in cycle 1.
    assert_eq!(now, 1);
}

#[test]
fn closed_rows_are_closed_with_their_last_request() {
    let requests = [request(0, false), request(32, false)];
    let mut memory = memory(|s| s.controller.row_policy = RowPolicy::Closed);
    memory.record_commands();
    for request in requests {
        assert_eq!(memory.offer(0, request), Ok(()));
    }
    memory.advance(1000, &mut Vec::new());
    let closing: Vec<bool> = (memory.commands(0).iter())
        .filter_map(|(_, command)| match command {
            Command::Read { precharge, .. } => Some(*precharge),
            _ => None,
        })
        .collect();
    assert_eq!(closing, [false, true]);
    let channel = memory.counters().channels[0];
    assert_eq!((channel.activates, channel.precharges), (1, 1));
}

#[test]
fn refreshes_come_when_they_are_due_also_where_nothing_else_happens() {
    let mut memory = memory(|s| s.timing.refi = 1000);
    memory.record_commands();
    // A row is open when the first refresh is due: it is closed before.
    assert_eq!(memory.offer(900, request(0, false)), Ok(()));
    memory.advance(4999, &mut Vec::new());
    let expected = [
        (902, Command::Activate { bank: 0, row: 0 }),
        (
            915,
            Command::Read {
                bank: 0,
                column: 0,
                precharge: false,
            },
        ),
        (1000, Command::Precharge { bank: 0 }),
        (1017, Command::Refresh),
        (2000, Command::Refresh),
        (3000, Command::Refresh),
        (4000, Command::Refresh),
    ];
    assert_eq!(memory.commands(0), expected);
    // Those of a long rest are counted without being simulated.
    let rest = 1_000_000_000_000_000;
    memory = self::memory(|s| s.timing.refi = 1000);
    assert_eq!(memory.offer(rest, request(0, false)), Ok(()));
    assert_eq!(memory.counters().channels[0].refreshes, rest / 1000);
}
