//! The effects of a bundle of VLIW code on later cycles: results on their way to registers, branches under their delay, and
//! the kernel that is to run next. Engines fill it in as a bundle issues; the [sequencer](super::sequencer) takes what is
//! due at the end of each cycle.

use super::border::Stop;
use super::ops::V4;
use super::saved::{Saved, Words};

/// The work of a core from the next cycle on, in place of issuing a bundle.
#[derive(Clone, Copy, Debug)]
pub enum NextMode {
    /// It runs a kernel.
    Launch(u32),
    /// It ends, with this status.
    Halt(i32),
}

/// A transfer of control under way.
#[derive(Clone, Copy, Debug)]
pub struct Transfer {
    /// The bundle that issues next.
    pub target: u32,
    /// The kind.
    pub kind: TransferKind,
}

/// The effect of a transfer on the open calls.
#[derive(Clone, Copy, Debug)]
pub enum TransferKind {
    /// Nothing.
    Jump,
    /// It opens one, at this place.
    Call {
        /// The place.
        at: u32,
    },
    /// It closes the last.
    Return,
}

/// The effects of a bundle on later cycles: results in flight, targets of branches, the next mode.
#[derive(Clone, Debug)]
pub struct Issue {
    in_flight: Flight,
    /// Targets of the branches under way, a ring: the first applies at the end of this cycle.
    targets: Vec<Option<Transfer>>,
    first_target: usize,
    next_mode: Option<NextMode>,
    /// True if cycles have passed in this run.
    behind: bool,
}

impl Issue {
    /// Nothing under way, on an engine with this branch delay and this largest latency.
    pub fn new(branch_delay: u32, max_latency: u32) -> Issue {
        Issue {
            in_flight: Flight::new(max_latency),
            targets: vec![None; branch_delay as usize + 1],
            first_target: 0,
            next_mode: None,
            behind: false,
        }
    }

    /// Appends what is under way.
    pub fn save(&self, out: &mut Vec<u32>) {
        self.in_flight.save(out);
        let (later, first) = self.targets.split_at(self.first_target);
        for target in first.iter().chain(later) {
            let (kind, place, at) = match *target {
                None => (0, 0, 0),
                Some(Transfer { target, kind }) => match kind {
                    TransferKind::Jump => (1, target, 0),
                    TransferKind::Call { at } => (2, target, at),
                    TransferKind::Return => (3, target, 0),
                },
            };
            out.extend([kind, place, at]);
        }
    }

    /// Takes what [`save`](Self::save) has appended; `None` where the words mean nothing.
    pub fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        self.in_flight.restore(words)?;
        self.first_target = 0;
        self.next_mode = None;
        for place in &mut self.targets {
            let (kind, target) = (words.next_word()?, words.next_word()?);
            let at = words.next_word()?;
            let kind = match kind {
                0 => None,
                1 => Some(TransferKind::Jump),
                2 => Some(TransferKind::Call { at }),
                3 => Some(TransferKind::Return),
                _ => return None,
            };
            *place = kind.map(|kind| Transfer { target, kind });
        }
        Some(())
    }

    /// A run begins.
    pub fn begin_run(&mut self) {
        self.behind = false;
    }

    /// A cycle of the run has passed.
    pub fn end_cycle(&mut self) {
        self.behind = true;
    }

    /// Stops a bundle that talks to a port where cycles have passed in this run.
    pub fn meet_bus(&self) -> Result<(), Stop> {
        if self.behind {
            Err(Stop::Behind)
        } else {
            Ok(())
        }
    }

    /// Sends a word, or a predicate as 0 or 1, on its way: it lands at the end of the `latency`-th
    /// cycle, this one being the first.
    pub fn land(&mut self, latency: u32, register: u32, value: u32) {
        self.in_flight.add(latency, register, Landing::Word(value));
    }

    /// Sends a vector on its way.
    pub fn land_vec(&mut self, latency: u32, register: u32, value: V4) {
        self.in_flight.add(latency, register, Landing::Vec(value));
    }

    /// Makes `target` issue after the branch delay.
    pub fn jump(&mut self, target: u32) {
        self.transfer(target, TransferKind::Jump);
    }

    /// The same for a call at the place `at`.
    pub fn call(&mut self, target: u32, at: u32) {
        self.transfer(target, TransferKind::Call { at });
    }

    /// The same for a return.
    pub fn give_back(&mut self, target: u32) {
        self.transfer(target, TransferKind::Return);
    }

    fn transfer(&mut self, target: u32, kind: TransferKind) {
        // The ring is as long as the delay and one, so the last place is just before the first.
        let last = self.first_target + self.targets.len() - 1;
        let last = last % self.targets.len();
        self.targets[last] = Some(Transfer { target, kind });
    }

    /// Makes the array run a kernel from the next cycle on.
    pub fn launch(&mut self, kernel: u32) {
        self.next_mode = Some(NextMode::Launch(kernel));
    }

    /// Ends the program.
    pub fn halt(&mut self, status: u32) {
        self.next_mode = Some(NextMode::Halt(status as i32));
    }

    /// Gives the results that land at the end of this cycle, each with its register.
    #[inline(always)]
    pub fn land_due(&mut self, write: impl FnMut(u32, Landing)) {
        self.in_flight.tick(write);
    }

    /// Takes what begins with the next cycle, if the core is not to issue then.
    pub fn take_mode(&mut self) -> Option<NextMode> {
        self.next_mode.take()
    }

    /// The transfer that applies at the end of this cycle.
    pub fn next_transfer(&mut self) -> Option<Transfer> {
        let transfer = self.targets[self.first_target].take();
        self.first_target += 1;
        if self.first_target == self.targets.len() {
            self.first_target = 0;
        }
        transfer
    }
}

/// A result.
#[derive(Clone, Copy, Debug)]
pub enum Landing {
    /// A word, or a predicate as 0 or 1.
    Word(u32),
    /// A vector.
    Vec(V4),
}

/// Results of VLIW code that have not landed, by the cycle in which they do.
#[derive(Clone, Debug)]
struct Flight {
    cycles: Vec<Vec<(u32, Landing)>>,
    first: usize,
    count: usize,
}

impl Flight {
    fn new(max_latency: u32) -> Flight {
        Flight {
            cycles: vec![Vec::new(); max_latency as usize],
            first: 0,
            count: 0,
        }
    }

    fn add(&mut self, latency: u32, register: u32, value: Landing) {
        let mut cycle = self.first + latency as usize - 1;
        if cycle >= self.cycles.len() {
            cycle -= self.cycles.len();
        }
        self.cycles[cycle].push((register, value));
        self.count += 1;
    }

    /// Appends what is in flight: for each cycle from the next on, how many results, and these.
    fn save(&self, out: &mut Vec<u32>) {
        let (later, first) = self.cycles.split_at(self.first);
        for cycle in first.iter().chain(later) {
            out.push(cycle.len() as u32);
            for &(register, value) in cycle {
                match value {
                    Landing::Word(value) => out.extend([register, 1, value]),
                    Landing::Vec(value) => {
                        out.extend([register, 4]);
                        value.save(out);
                    }
                }
            }
        }
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        (self.first, self.count) = (0, 0);
        for cycle in &mut self.cycles {
            cycle.clear();
            for _ in 0..words.next_word()? {
                let (register, lanes) = (words.next_word()?, words.next_word()?);
                let value = match lanes {
                    1 => Landing::Word(words.next_word()?),
                    4 => {
                        let mut value = V4::default();
                        value.restore(words)?;
                        Landing::Vec(value)
                    }
                    _ => return None,
                };
                cycle.push((register, value));
                self.count += 1;
            }
        }
        Some(())
    }

    /// Ends a cycle: gives the results that land then.
    #[inline(always)]
    fn tick(&mut self, mut write: impl FnMut(u32, Landing)) {
        if self.count > 0 {
            for (register, value) in self.cycles[self.first].drain(..) {
                self.count -= 1;
                write(register, value);
            }
        }
        self.first += 1;
        if self.first == self.cycles.len() {
            self.first = 0;
        }
    }
}
