//! What an engine asks of its bus, and what it is answered.

use srp_runtime::core::{Bus, Lanes};
use std::ops::Range;

/// A question to a bus, with the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Talk {
    /// A bundle, and the first and the end of those that can be issued.
    Fetch(u32, [u32; 2]),
    Launch(u32),
    Load(u32, u32, Option<Lanes>),
    Store(u32, u32, Lanes, Option<()>),
    Prefetch(u32),
    /// Cycles that banks cost.
    Conflict(u32),
    Descriptor(u32, Option<Lanes>),
    Texels(Lanes, Result<Lanes, u32>),
    In(u32, Option<u32>),
    Out(u32, u32, bool),
    /// Whether it stalls.
    Stalled(bool),
}

/// The bus of the engine that goes first: every question is noted.
pub(super) struct Noting<'a> {
    pub(super) bus: &'a mut dyn Bus,
    pub(super) log: &'a mut Vec<Talk>,
}

impl Noting<'_> {
    /// Notes a question, and whether the bus stalls after it.
    fn note(&mut self, talk: Talk) {
        self.log.push(talk);
        self.log.push(Talk::Stalled(self.bus.stalled()));
    }
}

impl Bus for Noting<'_> {
    fn sram(&mut self) -> &mut [u8] {
        self.bus.sram()
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        let answer = self.bus.cached_load(address, bytes);
        self.note(Talk::Load(address, bytes, answer));
        answer
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        let answer = self.bus.cached_store(address, bytes, value);
        self.note(Talk::Store(address, bytes, value, answer));
        answer
    }

    fn prefetch(&mut self, address: u32) {
        self.bus.prefetch(address);
        self.note(Talk::Prefetch(address));
    }

    fn conflict(&mut self, cycles: u32) {
        self.bus.conflict(cycles);
        self.note(Talk::Conflict(cycles));
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        let answer = self.bus.texture_descriptor(address);
        self.note(Talk::Descriptor(address, answer));
        answer
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        let answer = self.bus.texels(addresses);
        self.note(Talk::Texels(addresses, answer));
        answer
    }

    fn fetch(&mut self, bundle: u32) -> Range<u32> {
        let there = self.bus.fetch(bundle);
        self.note(Talk::Fetch(bundle, [there.start, there.end]));
        there
    }

    fn launch(&mut self, kernel: u32) {
        self.bus.launch(kernel);
        self.note(Talk::Launch(kernel));
    }

    fn stalled(&self) -> bool {
        self.bus.stalled()
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        let answer = self.bus.port_in(port);
        self.note(Talk::In(port, answer));
        answer
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        let answer = self.bus.port_out(port, value);
        self.note(Talk::Out(port, value, answer));
        answer
    }
}

/// Where two engines ask different questions: that of the first, if it asks one, and that of the other.
pub(super) type Astray = (Option<Talk>, Talk);

/// The bus of an engine that follows: it is answered as the first one was, and may ask nothing else. It has an SRAM of
/// its own.
pub(super) struct Answering<'a> {
    sram: &'a mut [u8],
    log: &'a [Talk],
    next: usize,
    stalled: bool,
    /// The first question that the other engine has not asked: what it asked, and what this one does.
    pub(super) differs: Option<Astray>,
}

impl<'a> Answering<'a> {
    pub(super) fn new(sram: &'a mut [u8], log: &'a [Talk], stalled: bool) -> Answering<'a> {
        Answering {
            sram,
            log,
            next: 0,
            stalled,
            differs: None,
        }
    }

    /// The number of questions that were asked.
    pub(super) fn asked(&self) -> usize {
        self.next
    }

    pub(super) fn is_stalled(&self) -> bool {
        self.stalled
    }

    /// The answer to a question that is `asked` without one: that of the log, if it is the same question.
    fn answer(&mut self, asked: Talk, is_same: impl Fn(&Talk) -> bool) -> Option<Talk> {
        let talk = self.log.get(self.next).copied();
        match talk.filter(is_same) {
            Some(talk) if self.differs.is_none() => {
                if let Some(&Talk::Stalled(stalled)) = self.log.get(self.next + 1) {
                    self.stalled = stalled;
                }
                self.next += 2;
                Some(talk)
            }
            _ => {
                self.differs.get_or_insert((talk, asked));
                None
            }
        }
    }
}

impl Bus for Answering<'_> {
    fn sram(&mut self) -> &mut [u8] {
        self.sram
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        let asked = Talk::Load(address, bytes, None);
        let same = |t: &Talk| matches!(*t, Talk::Load(a, b, _) if (a, b) == (address, bytes));
        match self.answer(asked, same) {
            Some(Talk::Load(_, _, answer)) => answer,
            _ => None,
        }
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        let asked = Talk::Store(address, bytes, value, None);
        let this = (address, bytes, value);
        let same = |t: &Talk| matches!(*t, Talk::Store(a, b, v, _) if (a, b, v) == this);
        match self.answer(asked, same) {
            Some(Talk::Store(.., answer)) => answer,
            _ => None,
        }
    }

    fn prefetch(&mut self, address: u32) {
        let same = |talk: &Talk| *talk == Talk::Prefetch(address);
        self.answer(Talk::Prefetch(address), same);
    }

    fn conflict(&mut self, cycles: u32) {
        let same = |talk: &Talk| *talk == Talk::Conflict(cycles);
        self.answer(Talk::Conflict(cycles), same);
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        let asked = Talk::Descriptor(address, None);
        let same = |t: &Talk| matches!(*t, Talk::Descriptor(a, _) if a == address);
        match self.answer(asked, same) {
            Some(Talk::Descriptor(_, answer)) => answer,
            _ => None,
        }
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        let asked = Talk::Texels(addresses, Err(0));
        let same = |t: &Talk| matches!(*t, Talk::Texels(a, _) if a == addresses);
        match self.answer(asked, same) {
            Some(Talk::Texels(_, answer)) => answer,
            _ => Err(0),
        }
    }

    fn fetch(&mut self, bundle: u32) -> Range<u32> {
        // Where a run is cut in another way, it asks again for what it has: that changes nothing.
        let is_same = |talk: &Talk| matches!(*talk, Talk::Fetch(number, _) if number == bundle);
        if !self.log.get(self.next).is_some_and(is_same) {
            return 0..0;
        }
        match self.answer(Talk::Fetch(bundle, [0; 2]), is_same) {
            Some(Talk::Fetch(_, [start, end])) => start..end,
            _ => 0..0,
        }
    }

    fn launch(&mut self, kernel: u32) {
        let asked = Talk::Launch(kernel);
        self.answer(asked, |t| *t == asked);
    }

    fn stalled(&self) -> bool {
        self.stalled
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        let asked = Talk::In(port, None);
        match self.answer(asked, |t| matches!(*t, Talk::In(p, _) if p == port)) {
            Some(Talk::In(_, answer)) => answer,
            _ => None,
        }
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        let asked = Talk::Out(port, value, false);
        let same = |t: &Talk| matches!(*t, Talk::Out(p, v, _) if (p, v) == (port, value));
        match self.answer(asked, same) {
            Some(Talk::Out(_, _, answer)) => answer,
            _ => false,
        }
    }
}

impl Talk {
    /// In words.
    pub(super) fn words(&self) -> String {
        match *self {
            Talk::Fetch(bundle, _) => format!("issues bundle {bundle}"),
            Talk::Launch(kernel) => format!("launches kernel {kernel}"),
            Talk::Load(address, bytes, _) => format!("loads {bytes} bytes at {address:#010x}"),
            Talk::Store(address, bytes, value, _) => {
                let words = (bytes as usize).div_ceil(4);
                format!(
                    "stores {:#010x?} at {address:#010x}",
                    &value[..words.min(4)]
                )
            }
            Talk::Conflict(cycles) => format!("stands still for {cycles} cycles for its SRAM"),
            Talk::Prefetch(address) => format!("asks for the line at {address:#010x}"),
            Talk::Descriptor(address, _) => format!("reads the texture at {address:#010x}"),
            Talk::Texels(addresses, _) => format!("reads texels at {addresses:#010x?}"),
            Talk::In(port, _) => format!("reads port {port}"),
            Talk::Out(port, value, _) => format!("gives {value:#x} to port {port}"),
            Talk::Stalled(_) => "asks nothing".to_owned(),
        }
    }
}
