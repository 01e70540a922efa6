//! [`DramSpec`]: system memory, as a device of fixed latency or as banks with rows behind an
//! FR-FCFS controller, and the named memories that a machine file can start from.
//!
//! Times are cycles of the memory clock; the names are those of the JEDEC standards.

use serde::{Deserialize, Serialize};

/// System memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DramSpec {
    /// Memory clock, MHz; data moves on both edges.
    pub mhz: u32,
    /// Channels, a power of two.
    pub channels: u32,
    /// Data lines of one channel, a power of two (≥ 8).
    pub bits: u32,
    /// True if all cores share it; else each core has such a memory, and a bus, of its own.
    pub shared: bool,
    /// Nanoseconds that every answer takes in addition to the time of `model`: the way through controller
    /// and interface.
    pub latency_ns: u32,
    /// The model of its timing.
    pub model: DramModel,
}

impl DramSpec {
    /// Bytes that its banks hold, beyond which addresses wrap; `None` where it has no banks.
    pub fn capacity(&self) -> Option<u64> {
        let DramModel::Banked(spec) = &self.model else {
            return None;
        };
        let parts = [self.channels, spec.banks, spec.rows, spec.columns];
        let columns: u64 = parts.into_iter().map(u64::from).product();
        Some(columns * u64::from(self.bits / 8))
    }
}

/// How the time of an access comes about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DramModel {
    /// Every access takes the same time, and each channel moves its peak rate.
    Fixed,
    /// Banks, rows, refresh, and a controller that reorders.
    Banked(BankedSpec),
}

/// One channel of banks and its controller.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BankedSpec {
    /// Banks of a channel, a power of two.
    pub banks: u32,
    /// Rows of a bank, a power of two.
    pub rows: u32,
    /// Columns of a row, each as wide as the channel; a power of two.
    pub columns: u32,
    /// Columns that one command moves: the burst length, a power of two (≥ 2).
    pub burst: u32,
    /// Where an address above the burst's own bytes goes, from its most significant bit down.
    /// The fields of each part have in all the bits that it needs; addresses beyond the capacity wrap.
    pub mapping: Vec<AddressField>,
    /// Times between commands.
    pub timing: DramTiming,
    /// The controller.
    pub controller: ControllerSpec,
}

impl BankedSpec {
    /// Bytes that one command moves over data lines of this number.
    pub fn burst_bytes(&self, bits: u32) -> u32 {
        self.burst * bits / 8
    }

    /// Bits that the parts of an address have in a memory of so many channels.
    pub fn address_bits(&self, channels: u32) -> [(AddressPart, u32); 4] {
        [
            (AddressPart::Row, self.rows.ilog2()),
            (AddressPart::Channel, channels.ilog2()),
            (AddressPart::Bank, self.banks.ilog2()),
            (AddressPart::Column, (self.columns / self.burst).ilog2()),
        ]
    }

    /// Cycles within which a channel can surely close all its banks, refresh, and serve a request
    /// after that: refreshes that are due more often leave no time for requests.
    pub fn refresh_and_access(&self) -> u32 {
        let t = &self.timing;
        let close = self.banks + t.ras + t.rtp + t.cwl + self.burst + t.wr + t.rp;
        let open = t.rfc + t.rc + t.rp + t.rrd + t.faw + t.rcd;
        close + open + t.cl + t.cwl + t.wtr + t.rtw + t.ccd + self.burst
    }
}

/// Neighbouring bits of an address that belong to the same part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AddressField {
    /// The part. Where it has several fields, those further up hold its more significant bits.
    pub part: AddressPart,
    /// How many bits.
    pub bits: u32,
}

/// The coordinate that bits of an address choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum AddressPart {
    /// The row of the bank.
    Row,
    /// The channel.
    Channel,
    /// The bank of the channel.
    Bank,
    /// The burst of the row.
    Column,
}

/// Cycles that lie between two commands at least, and when data moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DramTiming {
    /// tCL: from a read command to its first data.
    pub cl: u32,
    /// tCWL: from a write command to its first data.
    pub cwl: u32,
    /// tRCD: from activation to read or write, in the same bank.
    pub rcd: u32,
    /// tRP: from precharge to activation in the same bank, and to refresh.
    pub rp: u32,
    /// tRAS: from activation to precharge, in the same bank.
    pub ras: u32,
    /// tRC: from activation to activation, in the same bank.
    pub rc: u32,
    /// tRRD: from activation to activation, in different banks.
    pub rrd: u32,
    /// tFAW: from an activation to the fourth after it.
    pub faw: u32,
    /// tWTR: from the last data of a write to a read.
    pub wtr: u32,
    /// tRTW: from a read command to a write command.
    pub rtw: u32,
    /// tWR: from the last data of a write to precharge, in the same bank.
    pub wr: u32,
    /// tRTP: from a read to precharge, in the same bank.
    pub rtp: u32,
    /// tCCD: from a read to a read and from a write to a write; never less than a burst takes.
    pub ccd: u32,
    /// tRFC: from refresh to activation, and to the next refresh.
    pub rfc: u32,
    /// tREFI: refreshes become due so often; 0 for a memory that needs none.
    pub refi: u32,
}

impl DramTiming {
    /// All of them under their names in a machine file, in the order in which they are written.
    pub fn rows(&self) -> [(&'static str, u32); 15] {
        [
            ("cl", self.cl),
            ("cwl", self.cwl),
            ("rcd", self.rcd),
            ("rp", self.rp),
            ("ras", self.ras),
            ("rc", self.rc),
            ("rrd", self.rrd),
            ("faw", self.faw),
            ("wtr", self.wtr),
            ("rtw", self.rtw),
            ("wr", self.wr),
            ("rtp", self.rtp),
            ("ccd", self.ccd),
            ("rfc", self.rfc),
            ("refi", self.refi),
        ]
    }
}

/// The controller of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ControllerSpec {
    /// Bursts to be read that wait for their bank's queue.
    pub read_queue: u32,
    /// Bursts to be written that wait for their bank's queue.
    pub write_queue: u32,
    /// Reads and writes that one bank's queue holds.
    pub command_queue: u32,
    /// The treatment of a row after an access.
    pub row_policy: RowPolicy,
    /// Accesses to an open row after which a request for another row of the bank goes before
    /// further requests for it.
    pub row_hits: u32,
    /// Writes that wait until the bank queues are empty, at most; a full write queue waits no
    /// longer either.
    pub write_drain: u32,
}

/// The treatment of a row after an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RowPolicy {
    /// It stays open until another row is needed.
    Open,
    /// It is closed with the last access that its bank's queue has for it.
    Closed,
}

/// A memory with a name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DramPreset {
    /// Its name in machine files and on the command line.
    pub name: &'static str,
    /// Where its figures come from.
    pub source: &'static str,
    /// The memory.
    pub spec: DramSpec,
}

/// Fixed latency, 12.8 GB/s.
pub const FIXED: DramSpec = DramSpec {
    mhz: 800,
    channels: 2,
    bits: 32,
    shared: true,
    latency_ns: 340,
    model: DramModel::Fixed,
};

/// The named memories, the default first.
pub fn presets() -> [DramPreset; 4] {
    [
        DramPreset {
            name: "paper-gddr3-1GHz",
            source: "1 GHz and 2 × 32 bits: SGRT section 4.1. The paper has no times; these, the \
                     bursts and the banks are the default of GPGPU-Sim, probably its model, \
                     without refresh as there; its read-to-write time of CL + BL/2 + 2 − WL. \
                     Queue of 16: its QuadroFX5800 configuration. Rows, columns and the \
                     interleaving of channels by 64 bytes are assumed.",
            spec: paper_gddr3(),
        },
        DramPreset {
            name: "paper-gddr3-390ns",
            source: "The same with 300 ns on top of every answer: with bus and level-2 cache a round trip \
                     of about 390 ns, which the paper's rates of diffuse rays imply if its visits and \
                     hit rates are taken as they are printed.",
            spec: DramSpec {
                latency_ns: 300,
                ..paper_gddr3()
            },
        },
        DramPreset {
            name: "lpddr3-1600",
            source: "LPDDR3-1600 x32 of 8 Gb: DRAMsim3, configs/LPDDR3_8Gb_x32_1600.ini, with two \
                     channels of 1 GiB and transaction queues of 32. Refreshes are due every 7800 \
                     cycles as DRAMsim3 has them: the file says 3120 as `REFI`, where the program \
                     looks for `tREFI` and takes its default.",
            spec: lpddr3_1600(),
        },
        DramPreset {
            name: "lpddr3-1866",
            source: "LPDDR3-1866 x32 of 8 Gb: DRAMsim3, configs/LPDDR3_8Gb_x32_1866.ini, with two \
                     channels of 1 GiB and transaction queues of 32. Refreshes as for 1600; the \
                     file says 3645.",
            spec: lpddr3_1866(),
        },
    ]
}

const fn field(part: AddressPart, bits: u32) -> AddressField {
    AddressField { part, bits }
}

fn paper_gddr3() -> DramSpec {
    let banked = BankedSpec {
        banks: 4,
        rows: 8192,
        columns: 512,
        burst: 4,
        mapping: vec![
            field(AddressPart::Row, 13),
            field(AddressPart::Bank, 2),
            field(AddressPart::Column, 5),
            field(AddressPart::Channel, 1),
            field(AddressPart::Column, 2),
        ],
        timing: DramTiming {
            cl: 9,
            cwl: 4,
            rcd: 12,
            rp: 13,
            ras: 21,
            rc: 34,
            rrd: 8,
            faw: 0,
            wtr: 5,
            rtw: 9,
            wr: 13,
            rtp: 2,
            ccd: 2,
            rfc: 0,
            refi: 0,
        },
        controller: ControllerSpec {
            read_queue: 16,
            write_queue: 16,
            ..CONTROLLER
        },
    };
    DramSpec {
        mhz: 1000,
        channels: 2,
        bits: 32,
        shared: true,
        latency_ns: 0,
        model: DramModel::Banked(banked),
    }
}

/// The controller of all presets: the queues and rules of DRAMsim3.
const CONTROLLER: ControllerSpec = ControllerSpec {
    read_queue: 32,
    write_queue: 32,
    command_queue: 8,
    row_policy: RowPolicy::Open,
    row_hits: 4,
    write_drain: 8,
};

/// The value of tREFI that DRAMsim3 takes if a file has none. The standard's 3.9 µs are 3120 cycles
/// at 800 MHz and 3645 at 933 MHz.
const DRAMSIM3_REFI: u32 = 7800;

fn lpddr3(mhz: u32, timing: DramTiming) -> DramSpec {
    let banked = BankedSpec {
        banks: 8,
        rows: 32_768,
        columns: 1024,
        burst: 8,
        mapping: vec![
            field(AddressPart::Row, 15),
            field(AddressPart::Channel, 1),
            field(AddressPart::Bank, 3),
            field(AddressPart::Column, 7),
        ],
        timing,
        controller: CONTROLLER,
    };
    DramSpec {
        mhz,
        channels: 2,
        bits: 32,
        shared: true,
        latency_ns: 0,
        model: DramModel::Banked(banked),
    }
}

fn lpddr3_1600() -> DramSpec {
    let timing = DramTiming {
        cl: 12,
        cwl: 9,
        rcd: 15,
        rp: 15,
        ras: 34,
        rc: 49,
        rrd: 8,
        faw: 40,
        wtr: 6,
        rtw: 8,
        wr: 12,
        rtp: 6,
        ccd: 4,
        rfc: 168,
        refi: DRAMSIM3_REFI,
    };
    lpddr3(800, timing)
}

fn lpddr3_1866() -> DramSpec {
    let timing = DramTiming {
        cl: 14,
        cwl: 11,
        rcd: 17,
        rp: 17,
        ras: 40,
        rc: 57,
        rrd: 10,
        faw: 47,
        wtr: 7,
        rtw: 8,
        wr: 15,
        rtp: 7,
        ccd: 4,
        rfc: 196,
        refi: DRAMSIM3_REFI,
    };
    lpddr3(933, timing)
}
