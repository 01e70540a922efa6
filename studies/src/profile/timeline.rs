//! What cores do in the course of time, in steps of as many cycles each.
//!
//! A frame's length is not known before its end, so steps begin short, and two become one whenever there are too many.
//! What is counted does not depend on when that happens.

use schemars::JsonSchema;
use serde::Serialize;
use srp_runtime::core::{Activity, Run};
use srp_runtime::system::Stall;
use std::collections::BTreeMap;

/// Most steps.
const MOST: usize = 256;

/// Cycles of the first steps.
const FIRST: u64 = 16;

/// What cores do in the course of time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Timeline {
    /// SRP cycles of a step.
    pub step: u64,
    /// The cores of a frame, by number.
    pub cores: Vec<CoreTimeline>,
}

/// What a core does.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct CoreTimeline {
    /// By what it does, by loops of the array first, the cycles in each step.
    pub doings: Vec<DoingTimeline>,
    /// Rays that came back from its T&I unit in each step.
    pub rays: Vec<u64>,
}

/// One thing that a core does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DoingTimeline {
    /// The loop on the array, or one of the parts of a profile: `VLIW`, `switch`, `memory`, `texture`, `wait`.
    pub doing: String,
    /// Its cycles in each step.
    pub cycles: Vec<u64>,
}

/// What a core can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Doing {
    Loop(u32),
    Vliw,
    Switch,
    Stands(Stall),
    Waits,
}

/// A cache for the data of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Cache {
    Data,
    Texture,
}

impl Cache {
    /// The cache that a core stands still for, where it is one for data.
    pub(super) fn of(stall: Stall) -> Option<Cache> {
        match stall {
            Stall::Data => Some(Cache::Data),
            Stall::Texture => Some(Cache::Texture),
            Stall::Instructions | Stall::Contexts | Stall::Banks => None,
        }
    }
}

/// Counts by steps.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    step: u64,
    cores: Vec<Counts>,
}

#[derive(Clone, Debug, Default)]
struct Counts {
    doings: BTreeMap<Doing, Vec<u64>>,
    rays: Vec<u64>,
    /// The thing that the core does, since when and until when: it often goes on with that, and is counted when it ends.
    under_way: Option<(Doing, u64, u64)>,
}

impl Clock {
    pub(super) fn new() -> Clock {
        Clock {
            step: FIRST,
            cores: Vec::new(),
        }
    }

    /// A core has done one thing in a run of cycles that began in this one.
    pub(super) fn ran(&mut self, core: u32, cycle: u64, run: &Run) {
        let doing = match run.activity {
            Activity::Vliw => Doing::Vliw,
            Activity::Array(kernel) => Doing::Loop(kernel),
            Activity::Switch => Doing::Switch,
            Activity::Wait(_) => Doing::Waits,
            Activity::Halted(_) => return,
        };
        self.does(core, cycle, run.cycles, doing);
    }

    /// A core does something for so many cycles.
    pub(super) fn does(&mut self, core: u32, cycle: u64, cycles: u64, doing: Doing) {
        let end = cycle + cycles;
        let counts = self.core(core);
        match &mut counts.under_way {
            Some((same, _, until)) if *same == doing && *until == cycle => *until = end,
            under_way => {
                if let Some(before) = under_way.replace((doing, cycle, end)) {
                    self.count(core, before);
                }
            }
        }
    }

    /// Counts what a core did from one cycle to another.
    fn count(&mut self, core: u32, (doing, mut from, end): (Doing, u64, u64)) {
        self.make_room(end);
        let step = self.step;
        let counts = self.core(core).doings.entry(doing).or_default();
        while from < end {
            let number = (from / step) as usize;
            let to = end.min((number as u64 + 1) * step);
            counts.resize(counts.len().max(number + 1), 0);
            counts[number] += to - from;
            from = to;
        }
    }

    /// A ray came back.
    pub(super) fn ray(&mut self, core: u32, cycle: u64) {
        self.make_room(cycle + 1);
        let number = (cycle / self.step) as usize;
        let rays = &mut self.core(core).rays;
        rays.resize(rays.len().max(number + 1), 0);
        rays[number] += 1;
    }

    fn core(&mut self, core: u32) -> &mut Counts {
        let core = core as usize;
        if self.cores.len() <= core {
            self.cores.resize(core + 1, Counts::default());
        }
        &mut self.cores[core]
    }

    /// Makes steps longer until there are few enough up to a cycle.
    fn make_room(&mut self, end: u64) {
        while end > self.step * MOST as u64 {
            self.step *= 2;
            for core in &mut self.cores {
                let counts = core.doings.values_mut().chain([&mut core.rays]);
                counts.for_each(|counts| {
                    *counts = counts.chunks(2).map(|two| two.iter().sum()).collect();
                });
            }
        }
    }

    /// What was counted; nothing where no system was observed.
    pub(super) fn timeline(&self, kernel: impl Fn(u32) -> String) -> Option<Timeline> {
        let mut all = self.clone();
        for core in 0..all.cores.len() as u32 {
            if let Some(last) = all.core(core).under_way.take() {
                all.count(core, last);
            }
        }
        all.counted(kernel)
    }

    /// The counts without what is under way.
    fn counted(&self, kernel: impl Fn(u32) -> String) -> Option<Timeline> {
        let lengths = self
            .cores
            .iter()
            .flat_map(|core| core.doings.values().map(Vec::len));
        let steps = lengths.max()?;
        let whole = |counts: &Vec<u64>| {
            let mut counts = counts.clone();
            counts.resize(steps.max(counts.len()), 0);
            counts
        };
        let of_core = |core: &Counts| CoreTimeline {
            doings: (core.doings.iter())
                .map(|(doing, cycles)| DoingTimeline {
                    doing: match doing {
                        Doing::Loop(number) => kernel(*number),
                        Doing::Vliw => "VLIW".to_owned(),
                        Doing::Switch => "switch".to_owned(),
                        Doing::Stands(Stall::Data) => "memory".to_owned(),
                        Doing::Stands(Stall::Texture) => "texture".to_owned(),
                        Doing::Stands(Stall::Instructions) => "instructions".to_owned(),
                        Doing::Stands(Stall::Contexts) => "contexts".to_owned(),
                        Doing::Stands(Stall::Banks) => "banks".to_owned(),
                        Doing::Waits => "wait".to_owned(),
                    },
                    cycles: whole(cycles),
                })
                .collect(),
            rays: whole(&core.rays),
        };
        Some(Timeline {
            step: self.step,
            cores: self.cores.iter().map(of_core).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_and_lose_nothing() {
        let mut clock = Clock::new();
        let mut now = 0;
        for i in 0..1000 {
            let cycles = 1 + i * 37 % 101;
            clock.does(1, now, cycles, Doing::Loop((i % 3) as u32));
            clock.ray(1, now);
            now += cycles;
        }
        let timeline = clock.timeline(|number| format!("loop{number}"));
        let timeline = timeline.expect("something was counted");
        let core = &timeline.cores[1];
        let steps = core.doings[0].cycles.len();
        assert!((MOST / 2..=MOST).contains(&steps), "{steps}");
        for step in 0..steps - 1 {
            let all: u64 = core.doings.iter().map(|d| d.cycles[step]).sum();
            assert_eq!(all, timeline.step, "a step is full");
        }
        let all: u64 = core.doings.iter().flat_map(|d| &d.cycles).sum();
        assert_eq!((all, core.rays.iter().sum()), (now, 1000));
    }
}
