//! The banks of one channel: which rows are open, and when each command may be issued.
//!
//! The state knows nothing of requests and queues. A controller asks for the earliest cycle of a
//! command and issues it; rules between commands are kept here and nowhere else.

use serde::{Deserialize, Serialize};
use srp_archdesc::dram::{BankedSpec, DramTiming};

/// A command to the banks of one channel. With `precharge`, the bank is closed behind the access
/// as soon as the times allow (auto-precharge).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Command {
    /// Opens a row of a closed bank.
    Activate {
        /// The bank.
        bank: u32,
        /// The row.
        row: u32,
    },
    /// Reads one burst of the open row.
    Read {
        /// The bank.
        bank: u32,
        /// The burst.
        column: u32,
        /// True if the bank is closed behind it.
        precharge: bool,
    },
    /// Writes one burst of the open row.
    Write {
        /// The bank.
        bank: u32,
        /// The burst.
        column: u32,
        /// True if the bank is closed behind it.
        precharge: bool,
    },
    /// Closes an open bank.
    Precharge {
        /// The bank.
        bank: u32,
    },
    /// Refreshes all banks, which are closed.
    Refresh,
}

/// One bank: its row, and the first cycle for each command as far as this bank is concerned.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Bank {
    row: Option<u32>,
    /// Reads and writes since the row was opened.
    accesses: u32,
    activate: u64,
    column: u64,
    precharge: u64,
    refresh: u64,
}

/// Times between commands, as they are added to the cycle of the first.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Delays {
    burst: u64,
    read_to_read: u64,
    read_to_write: u64,
    read_to_precharge: u64,
    write_to_write: u64,
    write_to_read: u64,
    write_to_precharge: u64,
    read_data: u64,
}

impl Delays {
    fn of(spec: &BankedSpec) -> Delays {
        let t = &spec.timing;
        // Two columns a cycle.
        let burst = u64::from(spec.burst).div_ceil(2);
        let between = u64::from(t.ccd).max(burst);
        let write_data = u64::from(t.cwl) + burst;
        Delays {
            burst,
            read_to_read: between,
            read_to_write: u64::from(t.rtw),
            read_to_precharge: u64::from(t.rtp),
            write_to_write: between,
            write_to_read: write_data + u64::from(t.wtr),
            write_to_precharge: write_data + u64::from(t.wr),
            read_data: u64::from(t.cl) + burst,
        }
    }
}

/// Activations that tFAW counts.
const WINDOW: usize = 4;

/// All banks of a channel, closed at first.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Device {
    banks: Vec<Bank>,
    timing: DramTiming,
    delays: Delays,
    /// First cycles for the channel as a whole.
    activate: u64,
    read: u64,
    write: u64,
    /// First cycles after the last four activations, by tFAW; the oldest at `oldest`.
    window: [u64; WINDOW],
    oldest: usize,
}

impl Device {
    /// The banks of one channel.
    pub fn new(spec: &BankedSpec) -> Device {
        Device {
            banks: vec![Bank::default(); spec.banks as usize],
            timing: spec.timing,
            delays: Delays::of(spec),
            activate: 0,
            read: 0,
            write: 0,
            window: [0; WINDOW],
            oldest: 0,
        }
    }

    /// The row that is open in a bank.
    #[inline]
    pub fn row(&self, bank: u32) -> Option<u32> {
        self.banks[bank as usize].row
    }

    /// Reads and writes that the open row of a bank has had.
    #[inline]
    pub fn accesses(&self, bank: u32) -> u32 {
        self.banks[bank as usize].accesses
    }

    /// Cycles from a read command to the end of its data.
    #[inline]
    pub fn read_latency(&self) -> u64 {
        self.delays.read_data
    }

    /// Cycles in which one burst takes the data lines.
    #[inline]
    pub fn burst_cycles(&self) -> u64 {
        self.delays.burst
    }

    /// The first cycle in which a command may be issued; `None` where the banks are in no state
    /// for it.
    pub fn earliest(&self, command: Command) -> Option<u64> {
        match command {
            Command::Activate { bank, .. } => {
                self.row(bank).is_none().then(|| self.activate_at(bank))
            }
            Command::Read { bank, .. } => self.row(bank).map(|_| self.read_at(bank)),
            Command::Write { bank, .. } => self.row(bank).map(|_| self.write_at(bank)),
            Command::Precharge { bank } => self.row(bank).map(|_| self.precharge_at(bank)),
            Command::Refresh => {
                let closed = self.banks.iter().all(|b| b.row.is_none());
                closed.then(|| self.banks.iter().map(|b| b.refresh).fold(0, u64::max))
            }
        }
    }

    /// The first cycle in which a closed bank may be activated.
    #[inline]
    pub(super) fn activate_at(&self, bank: u32) -> u64 {
        self.banks[bank as usize]
            .activate
            .max(self.activate)
            .max(self.window[self.oldest])
    }

    /// The first cycle in which the open row of a bank may be read.
    #[inline]
    pub(super) fn read_at(&self, bank: u32) -> u64 {
        self.banks[bank as usize].column.max(self.read)
    }

    /// The first cycle in which the open row of a bank may be written.
    #[inline]
    pub(super) fn write_at(&self, bank: u32) -> u64 {
        self.banks[bank as usize].column.max(self.write)
    }

    /// The first cycle in which an open bank may be closed.
    #[inline]
    pub(super) fn precharge_at(&self, bank: u32) -> u64 {
        self.banks[bank as usize].precharge
    }

    /// Issues a command.
    ///
    /// # Panics
    ///
    /// In debug builds, before the command's [`earliest`](Self::earliest) cycle.
    pub fn issue(&mut self, cycle: u64, command: Command) {
        debug_assert!(
            self.earliest(command).is_some_and(|first| first <= cycle),
            "{command:?} in cycle {cycle}, first {:?}",
            self.earliest(command)
        );
        match command {
            Command::Activate { bank, row } => self.activate(cycle, bank, row),
            Command::Read {
                bank, precharge, ..
            } => self.read(cycle, bank, precharge),
            Command::Write {
                bank, precharge, ..
            } => self.write(cycle, bank, precharge),
            Command::Precharge { bank } => self.close(cycle, bank),
            Command::Refresh => self.refresh(cycle),
        }
    }

    fn activate(&mut self, cycle: u64, bank: u32, row: u32) {
        let t = self.timing;
        let after = |cycles: u32| cycle + u64::from(cycles);
        self.activate = after(t.rrd);
        self.window[self.oldest] = after(t.faw);
        self.oldest = (self.oldest + 1) % WINDOW;
        let bank = &mut self.banks[bank as usize];
        bank.row = Some(row);
        bank.accesses = 0;
        bank.activate = after(t.rc);
        bank.column = after(t.rcd);
        bank.precharge = after(t.ras);
    }

    fn read(&mut self, cycle: u64, bank: u32, precharge: bool) {
        let delays = self.delays;
        self.read = self.read.max(cycle + delays.read_to_read);
        self.write = self.write.max(cycle + delays.read_to_write);
        self.access(cycle + delays.read_to_precharge, bank, precharge);
    }

    fn write(&mut self, cycle: u64, bank: u32, precharge: bool) {
        let delays = self.delays;
        self.read = self.read.max(cycle + delays.write_to_read);
        self.write = self.write.max(cycle + delays.write_to_write);
        self.access(cycle + delays.write_to_precharge, bank, precharge);
    }

    /// The part that reads and writes share; the bank may be closed from cycle `closing` on.
    fn access(&mut self, closing: u64, bank: u32, precharge: bool) {
        let state = &mut self.banks[bank as usize];
        state.accesses += 1;
        state.precharge = state.precharge.max(closing);
        if precharge {
            let cycle = state.precharge;
            self.close(cycle, bank);
        }
    }

    fn close(&mut self, cycle: u64, bank: u32) {
        let bank = &mut self.banks[bank as usize];
        let after = cycle + u64::from(self.timing.rp);
        bank.row = None;
        bank.activate = bank.activate.max(after);
        bank.refresh = bank.refresh.max(after);
    }

    fn refresh(&mut self, cycle: u64) {
        let after = cycle + u64::from(self.timing.rfc);
        for bank in &mut self.banks {
            bank.activate = bank.activate.max(after);
            bank.refresh = bank.refresh.max(after);
        }
    }
}
