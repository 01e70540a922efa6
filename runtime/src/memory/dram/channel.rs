//! The controller of one channel: FR-FCFS over a queue for each bank.
//!
//! In every cycle it does three things, in this order.
//! 1. It issues at most one command. While a refresh is due, that is a precharge or the refresh.
//!    Otherwise it asks the bank queues in turn, beginning after the last that had a command; in each, the
//!    oldest request whose next command is ready goes first. A row is closed for the
//!    oldest request of a queue only, and only if no request there is for the open row, or the row
//!    has had its share of hits.
//! 2. It moves the oldest request that finds room from the read queue to the queue of its bank; or
//!    from the write queue while that is being drained, which begins when it has no room for
//!    a request that is offered, or when it holds more than a few and the bank queues are empty.
//! 3. Requests that were offered in this cycle take their places behind.
//!
//! A read of bytes that wait to be written is answered at once, and a write to them joins them. A read of
//! bytes that wait to be read is answered together with the earlier read.
//!
//! Nothing happens in most cycles, and these are skipped: [`Channel::run`] goes from one cycle with
//! something to do to the next.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use srp_archdesc::dram::{BankedSpec, ControllerSpec, RowPolicy};

use super::ChannelCounters;
use super::bank_queue::{BankQueue, Transaction};
use super::device::{Command, Device};
use super::mapping::Place;

/// The end of one burst: cycle, request, and cycle in which it was accepted.
pub(super) type Finished = (u64, u32, u64);

const NEVER: u64 = u64::MAX;

/// A channel: its banks, their queues, and its own.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Channel {
    device: Device,
    spec: ControllerSpec,
    refresh_interval: u64,
    banks: Vec<BankQueue>,
    /// Banks whose queue is not empty, and those whose queue is full, as bits.
    active: u64,
    full: u64,
    /// The bank whose queue was asked last.
    turn: u32,
    reads: VecDeque<Transaction>,
    writes: VecDeque<Transaction>,
    /// Reads that are answered together with an earlier one of the same burst.
    joined: Vec<Transaction>,
    /// Writes that are still to be moved before reads have their turn again.
    draining: usize,
    /// True if a write was refused since they were last drained.
    is_pressed: bool,
    refresh_due: u64,
    /// Refreshes that are due.
    refreshes: u32,
    /// All cycles before this one are over or have nothing in them.
    next: u64,
    /// Reads whose command is still to be issued.
    waiting_reads: u32,
    /// Requests in the queues, and the cycle up to which they are in the counters.
    queued: u64,
    counted: u64,
    pub(super) counters: ChannelCounters,
    pub(super) commands: Option<Vec<(u64, Command)>>,
}

impl Channel {
    pub(super) fn new(spec: &BankedSpec) -> Channel {
        let interval = u64::from(spec.timing.refi);
        let queue = BankQueue::default();
        Channel {
            device: Device::new(spec),
            spec: spec.controller,
            refresh_interval: interval,
            banks: vec![queue; spec.banks as usize],
            active: 0,
            full: 0,
            turn: 0,
            reads: VecDeque::new(),
            writes: VecDeque::new(),
            joined: Vec::new(),
            draining: 0,
            is_pressed: false,
            refresh_due: if interval == 0 { NEVER } else { interval },
            refreshes: 0,
            next: if interval == 0 { NEVER } else { interval },
            waiting_reads: 0,
            queued: 0,
            counted: 0,
            counters: ChannelCounters::default(),
            commands: None,
        }
    }

    /// True if so many more bursts find room. Where the queue is empty, any number does.
    pub(super) fn has_room(&self, bursts: usize, is_write: bool) -> bool {
        let (queue, depth) = match is_write {
            true => (&self.writes, self.spec.write_queue),
            false => (&self.reads, self.spec.read_queue),
        };
        queue.is_empty() || queue.len() + bursts <= depth as usize
    }

    /// Has been asked for more room than there is. Returns a cycle before which there will be no
    /// more.
    pub(super) fn refuse(&mut self, now: u64, is_write: bool) -> u64 {
        if is_write && self.draining == 0 {
            // Several bursts may find no room before the queue is full.
            self.is_pressed = true;
            self.next = self.next.min(now + 1);
        }
        self.next
    }

    /// Takes a burst; `true` where it is answered in the cycle after its acceptance.
    pub(super) fn push(&mut self, transaction: Transaction) -> bool {
        let same = |t: &Transaction| t.burst == transaction.burst;
        let queued = &self.banks[transaction.place.bank as usize].entries;
        let is_pending_write =
            self.writes.iter().any(same) || queued.iter().any(|t| t.is_write && same(t));
        if transaction.is_write {
            if is_pending_write {
                self.counters.merged_writes += 1;
                return true;
            }
            self.writes.push_back(transaction);
        } else {
            if is_pending_write {
                self.counters.forwarded_reads += 1;
                return true;
            }
            let is_pending_read =
                self.reads.iter().any(same) || queued.iter().any(|t| !t.is_write && same(t));
            if is_pending_read {
                self.counters.joined_reads += 1;
                self.joined.push(transaction);
                return false;
            }
            self.reads.push_back(transaction);
            self.waiting_reads += 1;
        }
        self.count_until(transaction.accepted);
        self.queued += 1;
        self.next = self.next.min(transaction.accepted);
        transaction.is_write
    }

    /// A cycle before which no burst that is read now will be over; `None` where none is.
    pub(super) fn next_answer(&self) -> Option<u64> {
        (self.waiting_reads > 0).then(|| self.next.saturating_add(self.device.read_latency()))
    }

    /// Simulates up to and including `cycle`.
    #[inline]
    pub(super) fn run(&mut self, cycle: u64, finished: &mut Vec<Finished>) {
        while self.next <= cycle {
            self.leave_out_refreshes(cycle);
            self.cycle(self.next, finished);
        }
    }

    /// Where nothing goes on and all banks are closed, refreshes follow each other at their interval;
    /// only the last one before `cycle` has an effect on what comes after.
    fn leave_out_refreshes(&mut self, cycle: u64) {
        let empty = self.active == 0 && self.reads.is_empty();
        let rests = empty && self.refreshes == 0 && self.next == self.refresh_due;
        if !rests || self.commands.is_some() || cycle - self.next < self.refresh_interval {
            return;
        }
        if self.device.earliest(Command::Refresh).is_some() {
            let left_out = (cycle - self.next) / self.refresh_interval;
            self.counters.refreshes += left_out;
            self.refresh_due += left_out * self.refresh_interval;
            self.next = self.refresh_due;
        }
    }

    fn cycle(&mut self, cycle: u64, finished: &mut Vec<Finished>) {
        self.count_until(cycle);
        if cycle == self.refresh_due {
            self.refreshes += 1;
            self.refresh_due += self.refresh_interval;
        }
        let mut wakes = if self.refreshes > 0 {
            self.refresh(cycle)
        } else {
            self.issue(cycle, finished)
        };
        if self.move_one() || self.can_move() {
            wakes = cycle + 1;
        }
        self.next = wakes.max(cycle + 1).min(self.refresh_due);
    }

    /// Issues a command for a refresh, if one is ready. Says when to look again.
    fn refresh(&mut self, cycle: u64) -> u64 {
        let mut wakes = NEVER;
        for bank in 0..self.banks.len() as u32 {
            if self.device.row(bank).is_none() {
                continue;
            }
            let first = self.device.precharge_at(bank);
            if first <= cycle {
                self.precharge(cycle, bank);
                return cycle + 1;
            }
            wakes = wakes.min(first);
        }
        match self.device.earliest(Command::Refresh) {
            Some(first) if first <= cycle => {
                self.command(cycle, Command::Refresh);
                self.counters.refreshes += 1;
                self.refreshes -= 1;
                cycle + 1
            }
            Some(first) => first,
            None => wakes,
        }
    }

    /// Issues a command for a request, if one is ready. Says when to look again.
    fn issue(&mut self, cycle: u64, finished: &mut Vec<Finished>) -> u64 {
        let mut wakes = NEVER;
        // First the banks after the last one's turn, then those up to it.
        let up_to_turn = u64::MAX >> (63 - self.turn);
        for mut banks in [self.active & !up_to_turn, self.active & up_to_turn] {
            while banks != 0 {
                let bank = banks.trailing_zeros();
                banks &= banks - 1;
                match self.ready(bank, cycle) {
                    Ok(command) => {
                        self.turn = bank;
                        self.serve(cycle, bank, command, finished);
                        return cycle + 1;
                    }
                    Err(first) => wakes = wakes.min(first),
                }
            }
        }
        wakes
    }

    /// The command that the queue of a bank can issue in this cycle, or else the first cycle in which it can
    /// issue one.
    fn ready(&self, bank: u32, cycle: u64) -> Result<Ready, u64> {
        let next = self.banks[bank as usize].next;
        if next.activate {
            let first = self.device.activate_at(bank);
            return if first <= cycle {
                Ok(Ready::Activate)
            } else {
                Err(first)
            };
        }
        let mut wakes = NEVER;
        if next.precharge {
            let first = self.device.precharge_at(bank);
            if first <= cycle {
                return Ok(Ready::Precharge);
            }
            wakes = first;
        }
        let mut oldest = None;
        let accesses = [
            (next.read, self.device.read_at(bank)),
            (next.write, self.device.write_at(bank)),
        ];
        for (position, first) in accesses {
            let Some(position) = position else {
                continue;
            };
            wakes = wakes.min(first);
            if first <= cycle && oldest.is_none_or(|o| position < o) {
                oldest = Some(position);
            }
        }
        oldest.map(Ready::Access).ok_or(wakes)
    }

    fn serve(&mut self, cycle: u64, bank: u32, ready: Ready, finished: &mut Vec<Finished>) {
        match ready {
            Ready::Precharge => self.precharge(cycle, bank),
            Ready::Activate => {
                let row = self.banks[bank as usize].entries[0].place.row;
                self.command(cycle, Command::Activate { bank, row });
                self.counters.activates += 1;
                self.look_ahead(bank);
            }
            Ready::Access(position) => self.access(cycle, bank, position, finished),
        }
    }

    fn precharge(&mut self, cycle: u64, bank: u32) {
        self.command(cycle, Command::Precharge { bank });
        self.counters.precharges += 1;
        self.look_ahead(bank);
    }

    /// Reads or writes a burst of the open row.
    fn access(&mut self, cycle: u64, bank: u32, position: usize, finished: &mut Vec<Finished>) {
        let queue = &mut self.banks[bank as usize].entries;
        let transaction = queue.remove(position).expect("a position in the queue");
        let Place { row, column, .. } = transaction.place;
        let precharge =
            self.spec.row_policy == RowPolicy::Closed && queue.iter().all(|t| t.place.row != row);
        if queue.is_empty() {
            self.active &= !(1 << bank);
        }
        self.full &= !(1 << bank);
        self.queued -= 1;
        let hit = u64::from(self.device.accesses(bank) > 0);
        self.counters.precharges += u64::from(precharge);
        self.counters.busy_cycles += self.device.burst_cycles();
        if transaction.is_write {
            self.counters.writes += 1;
            self.counters.write_row_hits += hit;
            self.command(
                cycle,
                Command::Write {
                    bank,
                    column,
                    precharge,
                },
            );
        } else {
            self.counters.reads += 1;
            self.counters.read_row_hits += hit;
            self.command(
                cycle,
                Command::Read {
                    bank,
                    column,
                    precharge,
                },
            );
            self.answer(cycle, transaction, finished);
        }
        self.look_ahead(bank);
    }

    /// Answers a read whose command is issued in `cycle`, and those that have joined it.
    fn answer(&mut self, cycle: u64, read: Transaction, finished: &mut Vec<Finished>) {
        let over = cycle + self.device.read_latency();
        self.waiting_reads -= 1;
        finished.push((over, read.request, read.accepted));
        if !self.joined.is_empty() {
            self.joined.retain(|other| {
                let same = other.burst == read.burst;
                if same {
                    finished.push((over, other.request, other.accepted));
                }
                !same
            });
        }
    }

    fn command(&mut self, cycle: u64, command: Command) {
        self.device.issue(cycle, command);
        if let Some(commands) = &mut self.commands {
            commands.push((cycle, command));
        }
    }

    /// Moves a request from one of the two queues of the channel to that of its bank. Says whether
    /// there was one.
    fn move_one(&mut self) -> bool {
        if self.draining == 0 && self.drains() {
            self.draining = self.writes.len();
            self.is_pressed = false;
        }
        let mut moved = None;
        if self.draining > 0
            && let Some(position) = self.first_with_room(&self.writes)
        {
            if self.is_read_before(&self.writes[position]) {
                // A burst that is still to be read must not be overwritten: reads go on.
                self.draining = 0;
            } else {
                self.draining -= 1;
                moved = self.writes.remove(position);
            }
        }
        if moved.is_none()
            && self.draining == 0
            && let Some(position) = self.first_with_room(&self.reads)
        {
            moved = self.reads.remove(position);
        }
        let Some(transaction) = moved else {
            return false;
        };
        let bank = transaction.place.bank;
        let queue = &mut self.banks[bank as usize].entries;
        queue.push_back(transaction);
        self.active |= 1 << bank;
        if queue.len() >= self.spec.command_queue as usize {
            self.full |= 1 << bank;
        }
        self.look_ahead(bank);
        true
    }

    /// True if the write queue must be drained.
    fn drains(&self) -> bool {
        let waiting = self.writes.len();
        self.is_pressed
            || waiting >= self.spec.write_queue as usize
            || (self.active == 0 && waiting > self.spec.write_drain as usize)
    }

    /// True if [`move_one`](Self::move_one) would find something, as things stand.
    fn can_move(&self) -> bool {
        if self.draining > 0 || self.drains() {
            return self.first_with_room(&self.writes).is_some();
        }
        self.first_with_room(&self.reads).is_some()
    }

    /// The oldest request of a queue whose bank has room.
    fn first_with_room(&self, queue: &VecDeque<Transaction>) -> Option<usize> {
        queue
            .iter()
            .position(|t| self.full & (1 << t.place.bank) == 0)
    }

    /// True if the burst of a write is still to be read.
    fn is_read_before(&self, write: &Transaction) -> bool {
        let same = |t: &Transaction| !t.is_write && t.burst == write.burst;
        let queued = &self.banks[write.place.bank as usize].entries;
        self.reads.iter().any(same) || queued.iter().any(same)
    }

    /// Finds the commands that the queue of a bank can issue next.
    fn look_ahead(&mut self, bank: u32) {
        let row = self.device.row(bank);
        let has_had_its_share = self.device.accesses(bank) >= self.spec.row_hits;
        self.banks[bank as usize].look_ahead(row, has_had_its_share);
    }

    /// Counts the occupancy of the queues up to `cycle`.
    fn count_until(&mut self, cycle: u64) {
        if cycle > self.counted {
            self.counters.queued_cycles += self.queued * (cycle - self.counted);
            self.counted = cycle;
        }
    }
}

/// A command that a bank's queue can issue.
#[derive(Clone, Copy, Debug)]
enum Ready {
    Activate,
    Precharge,
    /// The access at this position of the queue.
    Access(usize),
}
