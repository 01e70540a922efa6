//! A profile: every cycle of a program's cores by function, loop and source line, with the reason.
//!
//! A [`Profiler`] makes cores that count ([`srp_csimgen::Counting`]) and, in a system, sees when they stand still
//! or wait. Its [`Profile`] has the same cycles as the system's own account, to the cycle: the tests compare them.
//!
//! A cycle of VLIW code belongs to the line of the bundle's first operation, an empty bundle to the line that it
//! follows. The cycles of a loop on the array are shared out over the lines of its body: each context's over its
//! operations. A core that stands still does so for a load or texture sample, and a core that waits does so for a
//! port: these cycles belong to that line.

mod advice;
mod lines;
mod model;
mod timeline;

pub use advice::advice;
pub use model::{Advice, FunctionProfile, Iterations, LineProfile, LoopProfile, Parts, Profile};
pub use timeline::{CoreTimeline, DoingTimeline, Timeline};

use lines::Lines;
use model::Line;
use srp_archdesc::isa::Class;
use srp_csimgen::{Counting, SharedCounts, SimSpec, TooManyStages, Turn, link};
use srp_ir::check::Checked;
use srp_runtime::core::{Activity, Core, Run};
use srp_runtime::system::{CoreView, Observer, Stall};
use srp_runtime::tni::RayCost;
use std::collections::BTreeMap;
use timeline::{Cache, Clock, Doing};

/// Makes the cores of a program, and sees what they do.
pub struct Profiler {
    spec: SimSpec,
    lines: Lines,
    cores: Vec<Counted>,
    clock: Clock,
}

/// A core and its time apart from its turns.
struct Counted {
    counts: SharedCounts,
    /// Since when it stands still, and for which cache.
    still: Option<(u64, Stall)>,
    /// Cycles of standing still and of waiting, by the turn before.
    stalls: BTreeMap<(Turn, Cache), u64>,
    waits: BTreeMap<Turn, u64>,
}

impl Profiler {
    /// A profiler of a program on the machine that it was checked for.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels.
    pub fn new(program: &Checked) -> Result<Profiler, TooManyStages> {
        let spec = link(program)?;
        let arch = program.arch();
        // Where a cache does not block, the core stands still when the value is due.
        let due = |blocking: bool, class| match blocking {
            true => 0,
            false => arch.srp.least_latency(class).unwrap_or(1).saturating_sub(1),
        };
        let system = &arch.system;
        let lines = Lines::of(
            &spec,
            due(system.data_cache.blocking, Class::Cload),
            due(system.texture_cache.blocking, Class::Tex),
        );
        Ok(Profiler {
            spec,
            lines,
            cores: Vec::new(),
            clock: Clock::new(),
        })
    }

    /// The next core, at the start of the program.
    pub fn core(&mut self) -> Box<dyn Core> {
        let core = Counting::new(&self.spec);
        self.cores.push(Counted {
            counts: core.counts(),
            still: None,
            stalls: BTreeMap::new(),
            waits: BTreeMap::new(),
        });
        Box::new(core)
    }

    /// So many cores, for a system that this observes.
    pub fn cores(&mut self, count: u32) -> Vec<Box<dyn Core>> {
        (0..count).map(|_| self.core()).collect()
    }

    /// The profile of all cores so far.
    pub fn profile(&self) -> Profile {
        let mut builder = Builder::new(&self.spec, &self.lines);
        for core in &self.cores {
            builder.add(core);
        }
        let kernel = |number: u32| self.spec.kernels[number as usize].name.clone();
        Profile {
            timeline: self.clock.timeline(kernel),
            ..builder.finish()
        }
    }
}

impl Observer for Profiler {
    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        self.clock.ran(core.core, core.cycle, run);
        if let Activity::Wait(_) = run.activity {
            let core = &mut self.cores[core.core as usize];
            let last = core.counts.get().last;
            if let Some(turn) = last {
                *core.waits.entry(turn).or_default() += run.cycles;
            }
        }
    }

    fn stall_began(&mut self, core: &CoreView<'_>, stall: Stall) {
        self.cores[core.core as usize].still = Some((core.cycle, stall));
    }

    fn stall_ended(&mut self, core: &CoreView<'_>, _: Stall) {
        self.go_on(core);
    }

    fn ray_returned(&mut self, core: u32, cycle: u64, _: &RayCost) {
        self.clock.ray(core, cycle);
    }

    fn finished(&mut self, core: &CoreView<'_>) {
        self.go_on(core);
    }
}

impl Profiler {
    /// A core has stood still until now, if it has.
    fn go_on(&mut self, core: &CoreView<'_>) {
        let of = &mut self.cores[core.core as usize];
        let Some((since, stall)) = of.still.take() else {
            return;
        };
        let (cache, cycles) = (Cache::from(stall), core.cycle.saturating_sub(since));
        let last = of.counts.get().last;
        if let Some(turn) = last {
            *of.stalls.entry((turn, cache)).or_default() += cycles;
        }
        self.clock
            .does(core.core, since, cycles, Doing::Stands(cache));
    }
}

/// Adds up the counts of cores.
struct Builder<'a> {
    spec: &'a SimSpec,
    lines: &'a Lines,
    functions: Vec<Parts>,
    loops: Vec<LoopCounts>,
    by_line: BTreeMap<Line, Parts>,
    all: Parts,
    cores: u32,
}

/// The counts of a loop on the array, of all cores.
#[derive(Clone, Default)]
struct LoopCounts {
    parts: Parts,
    launches: u64,
    iterations: u64,
    fewest: Option<u64>,
    most: u64,
}

impl<'a> Builder<'a> {
    fn new(spec: &'a SimSpec, lines: &'a Lines) -> Builder<'a> {
        Builder {
            spec,
            lines,
            functions: vec![Parts::default(); spec.functions.len()],
            loops: vec![LoopCounts::default(); spec.kernels.len()],
            by_line: BTreeMap::new(),
            all: Parts::default(),
            cores: 0,
        }
    }

    fn add(&mut self, core: &Counted) {
        self.cores += 1;
        let counts = core.counts.get();
        for (number, &cycles) in counts.bundles.iter().enumerate() {
            let bundle = &self.spec.bundles[number];
            let is_empty = bundle.steps.is_empty() && bundle.control.is_none();
            let parts = match is_empty {
                true => Parts {
                    empty: cycles,
                    ..Parts::default()
                },
                false => Parts {
                    vliw: cycles,
                    ..Parts::default()
                },
            };
            self.control(number as u32, parts, None);
        }
        for (kernel, counts) in counts.kernels.iter().enumerate() {
            let array: u64 = counts.contexts.iter().sum();
            let switch = counts.switch;
            let of = &mut self.loops[kernel];
            of.launches += counts.launches;
            of.iterations += counts.iterations;
            if counts.launches > 0 {
                of.fewest = Some(of.fewest.map_or(counts.fewest, |f| f.min(counts.fewest)));
            }
            of.most = of.most.max(counts.most);
            let switches = Parts {
                switch,
                ..Parts::default()
            };
            self.array(kernel, switches, self.lines.loop_line(kernel));
            for (line, cycles) in self.lines.shares(kernel, &counts.contexts) {
                self.by_line.entry(line).or_default().array += cycles;
            }
            self.loops[kernel].parts.array += array;
            self.all.array += array;
            if let Some(function) = self.lines.launcher(kernel) {
                self.functions[function].array += array;
            }
        }
        for (&(turn, cache), &cycles) in &core.stalls {
            let is_data = cache == Cache::Data;
            let parts = match is_data {
                true => Parts {
                    memory_stall: cycles,
                    ..Parts::default()
                },
                false => Parts {
                    texture_stall: cycles,
                    ..Parts::default()
                },
            };
            let line = self.lines.stalled(turn, is_data);
            match turn {
                Turn::Bundle(bundle) => self.control(bundle, parts, Some(line)),
                Turn::Context { kernel, .. } => self.array(kernel as usize, parts, line),
            }
        }
        for (&turn, &cycles) in &core.waits {
            let parts = Parts {
                wait: cycles,
                ..Parts::default()
            };
            if let Turn::Bundle(bundle) = turn {
                self.control(bundle, parts, None);
            }
        }
    }

    /// Adds cycles of a bundle, to its own line or to another.
    fn control(&mut self, bundle: u32, parts: Parts, line: Option<Line>) {
        if parts.total() == 0 {
            return;
        }
        let line = line.unwrap_or_else(|| self.lines.bundle_line(bundle));
        self.by_line.entry(line).or_default().add(&parts);
        if let Some(function) = self.lines.function(bundle) {
            self.functions[function].add(&parts);
        }
        self.all.add(&parts);
    }

    /// Adds cycles of a loop on the array to a line.
    fn array(&mut self, kernel: usize, parts: Parts, line: Line) {
        if parts.total() == 0 {
            return;
        }
        self.by_line.entry(line).or_default().add(&parts);
        self.loops[kernel].parts.add(&parts);
        if let Some(function) = self.lines.launcher(kernel) {
            self.functions[function].add(&parts);
        }
        self.all.add(&parts);
    }

    fn finish(self) -> Profile {
        let functions = self.functions.into_iter().zip(&self.spec.functions);
        let mut functions: Vec<FunctionProfile> = functions
            .filter(|(parts, _)| parts.total() > 0)
            .map(|(parts, (name, _))| FunctionProfile {
                name: name.clone(),
                parts,
            })
            .collect();
        functions.sort_by_key(|f| std::cmp::Reverse(f.parts.total()));
        let loops = self.loops.into_iter().zip(&self.spec.kernels);
        let mut loops: Vec<LoopProfile> = loops
            .filter(|(counts, _)| counts.parts.total() > 0)
            .map(|(counts, kernel)| LoopProfile {
                kernel: kernel.name.clone(),
                at: self.spec.position(kernel.at).map(str::to_owned),
                ii: kernel.ii,
                length: kernel.length,
                launches: counts.launches,
                iterations: Iterations {
                    all: counts.iterations,
                    fewest: counts.fewest.unwrap_or(0),
                    most: counts.most,
                },
                parts: counts.parts,
            })
            .collect();
        loops.sort_by_key(|l| std::cmp::Reverse(l.parts.total()));
        let lines = self.by_line.into_iter();
        let lines = lines.filter(|(_, parts)| parts.total() > 0);
        Profile {
            machine: self.spec.machine.clone(),
            cores: self.cores,
            parts: self.all,
            functions,
            loops,
            lines: lines
                .map(|((file, line), parts)| LineProfile { file, line, parts })
                .collect(),
            timeline: None,
            advice: Vec::new(),
        }
    }
}
