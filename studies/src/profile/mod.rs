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
mod frame;
mod lines;
mod model;
mod timeline;

pub use frame::Surroundings;
pub use model::{
    AccessProfile, Advice, BEFORE_ALL, CodeProfile, FrameProfile, FunctionProfile, Iterations,
    LineEnergy, LineProfile, LoopProfile, MaterialProfile, ObjectProfile, Parts, PipelineProfile,
    Profile,
};
pub use timeline::{CoreTimeline, DoingTimeline, Timeline};

use frame::Work;
use lines::Lines;
use model::Line;
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Class;
use srp_csimgen::{Counting, SharedCounts, SimSpec, TooManyStages, Turn, link};
use srp_ir::check::Checked;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::core::{Activity, Core, Run};
use srp_runtime::system::{CoreView, MemoryRequest, Observer, Report, Stall};
use srp_runtime::tni::{HitRecord, RayCost, Visited};
use std::collections::BTreeMap;
use timeline::{Cache, Clock, Doing};

/// Adds to the profile of a frame of a program what only its account tells: energy, the pipelines of its T&I units,
/// and what to do about its largest costs.
pub fn add_account(profile: &mut Profile, report: &Report, program: &ScheduledDre, arch: &Arch) {
    profile.advice = advice::advice(profile, report, arch);
    if let Some(frame) = &mut profile.frame {
        frame.energy = frame::energy(&frame.objects, report, program, arch);
        let (code, accesses) = (&profile.code, &frame.accesses);
        frame.energy_of_lines = frame::energy_of_lines(code, accesses, report, program, arch);
        frame.pipelines = frame::pipelines(report, &arch.system);
    }
}

/// Makes the cores of a program, and sees what they do.
pub struct Profiler {
    spec: SimSpec,
    lines: Lines,
    cores: Vec<Counted>,
    clock: Clock,
    /// Of a frame, what its caches and T&I units work for.
    work: Option<Work>,
}

/// A core and its time apart from its turns.
struct Counted {
    counts: SharedCounts,
    /// Since when it stands still, and for what.
    still: Option<(u64, Stall)>,
    /// Cycles of standing still, by the turn before.
    stalls: BTreeMap<(Turn, Stall), u64>,
    /// Cycles of waiting, by the bundle.
    waits: Vec<u64>,
    /// The wait that may go on: a core looks at its port in every cycle, and the whole is counted when it is over.
    waiting: Option<Wait>,
}

/// A wait of a core from one cycle until another.
#[derive(Clone, Copy)]
struct Wait {
    bundle: u32,
    since: u64,
    until: u64,
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
            work: None,
        })
    }

    /// The cores of a frame in these surroundings, for a system that this observes.
    pub fn frame(&mut self, surroundings: Surroundings, count: u32) -> Vec<Box<dyn Core>> {
        self.work = Some(Work::of(surroundings, count));
        self.cores(count)
    }

    /// The next core, at the start of the program.
    pub fn core(&mut self) -> Box<dyn Core> {
        let core = Counting::new(&self.spec);
        self.cores.push(Counted {
            counts: core.counts(),
            still: None,
            stalls: BTreeMap::new(),
            waits: vec![0; self.spec.bundles.len()],
            waiting: None,
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
        let mut clock = self.clock.clone();
        for (number, core) in (0..).zip(&self.cores) {
            if let Some(wait) = core.waiting {
                clock.does(number, wait.since, wait.until - wait.since, Doing::Waits);
            }
        }
        Profile {
            timeline: clock.timeline(kernel),
            frame: self.work.as_ref().map(Work::profile),
            ..builder.finish()
        }
    }
}

impl Observer for Profiler {
    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        let of = &mut self.cores[core.core as usize];
        let is_wait = matches!(run.activity, Activity::Wait(_));
        if is_wait
            && let Some(wait) = &mut of.waiting
            && wait.until == core.cycle
        {
            wait.until += run.cycles;
            return;
        }
        let last = of.counts.get().last;
        self.wait_ended(core.core);
        if is_wait && let Some(Turn::Bundle(bundle)) = last {
            let (since, until) = (core.cycle, core.cycle + run.cycles);
            self.cores[core.core as usize].waiting = Some(Wait {
                bundle,
                since,
                until,
            });
            return;
        }
        self.clock.ran(core.core, core.cycle, run);
    }

    fn stall_began(&mut self, core: &CoreView<'_>, stall: Stall) {
        self.cores[core.core as usize].still = Some((core.cycle, stall));
    }

    fn stall_ended(&mut self, core: &CoreView<'_>, _: Stall) {
        self.go_on(core);
    }

    fn requested(&mut self, core: &CoreView<'_>, request: &MemoryRequest) {
        if let Some(work) = &mut self.work {
            let last = self.cores[core.core as usize].counts.get().last;
            work.requested(core.core, request, last, &self.lines);
        }
    }

    fn ray_returned(&mut self, core: u32, cycle: u64, cost: &RayCost) {
        self.clock.ray(core, cycle);
        if let Some(work) = &mut self.work {
            work.ray_returned(core, cost);
        }
    }

    fn tni_visited(&mut self, _: u32, visited: &[Visited]) {
        if let Some(work) = &mut self.work {
            work.visited(visited);
        }
    }

    fn packet_returned(&mut self, core: &CoreView<'_>, packet: u64, hits: &[HitRecord]) {
        if let Some(work) = &mut self.work {
            work.packet_returned(core.core, packet, hits);
        }
    }

    fn finished(&mut self, core: &CoreView<'_>) {
        self.go_on(core);
    }
}

impl Profiler {
    /// A core does not wait any more, if it has.
    fn wait_ended(&mut self, core: u32) {
        let of = &mut self.cores[core as usize];
        if let Some(wait) = of.waiting.take() {
            let cycles = wait.until - wait.since;
            of.waits[wait.bundle as usize] += cycles;
            self.clock.does(core, wait.since, cycles, Doing::Waits);
        }
    }

    /// A core has stood still until now, if it has.
    fn go_on(&mut self, core: &CoreView<'_>) {
        self.wait_ended(core.core);
        let of = &mut self.cores[core.core as usize];
        let Some((since, stall)) = of.still.take() else {
            return;
        };
        let cycles = core.cycle.saturating_sub(since);
        let last = of.counts.get().last;
        if let Some(turn) = last {
            *of.stalls.entry((turn, stall)).or_default() += cycles;
            if let (Some(work), Some(cache)) = (&mut self.work, Cache::of(stall)) {
                let line = self.lines.stalled(turn, cache == Cache::Data);
                work.stood_still(core.core, cache, line, cycles);
            }
        }
        self.clock
            .does(core.core, since, cycles, Doing::Stands(stall));
    }
}

/// Adds up the counts of cores.
struct Builder<'a> {
    spec: &'a SimSpec,
    lines: &'a Lines,
    /// By function; what belongs to none is before all functions.
    functions: BTreeMap<Option<usize>, Parts>,
    loops: Vec<LoopCounts>,
    /// By function, loop and line; the function and the loop by their numbers.
    code: BTreeMap<(Option<usize>, Option<usize>, Line), Parts>,
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
            functions: BTreeMap::new(),
            loops: vec![LoopCounts::default(); spec.kernels.len()],
            code: BTreeMap::new(),
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
            let launcher = self.lines.launcher(kernel);
            for (line, cycles) in self.lines.shares(kernel, &counts.contexts) {
                let code = (launcher, Some(kernel), line);
                self.code.entry(code).or_default().array += cycles;
            }
            self.loops[kernel].parts.array += array;
            self.all.array += array;
            self.functions.entry(launcher).or_default().array += array;
        }
        // Of a program alone nobody tells when it stands still: the core itself has counted for what it can.
        let told = core.stalls.keys().any(|&(_, stall)| stall == Stall::Banks);
        let counted = counts.conflicts.iter().filter(|_| !told);
        let counted = counted.map(|(&turn, &cycles)| (turn, Stall::Banks, cycles));
        let stalls = core
            .stalls
            .iter()
            .map(|(&(turn, stall), &cycles)| (turn, stall, cycles));
        for (turn, stall, cycles) in stalls.chain(counted) {
            let mut parts = Parts::default();
            match stall {
                Stall::Data => parts.memory_stall = cycles,
                Stall::Texture => parts.texture_stall = cycles,
                Stall::Instructions => parts.instruction_stall = cycles,
                Stall::Contexts => parts.context_stall = cycles,
                Stall::Banks => parts.sram_stall = cycles,
            }
            // A bundle that is not there stalls at its own line.
            let line = Cache::of(stall).map(|cache| self.lines.stalled(turn, cache == Cache::Data));
            match turn {
                Turn::Bundle(bundle) => self.control(bundle, parts, line),
                Turn::Context { kernel, .. } => {
                    let kernel = kernel as usize;
                    let line = line.unwrap_or_else(|| self.lines.loop_line(kernel));
                    self.array(kernel, parts, line);
                }
            }
        }
        let waiting = core.waiting.map(|w| (w.bundle, w.until - w.since));
        let waits = (0..).zip(core.waits.iter().copied());
        for (bundle, cycles) in waits.chain(waiting) {
            let parts = Parts {
                wait: cycles,
                ..Parts::default()
            };
            self.control(bundle, parts, None);
        }
    }

    /// Adds cycles of a bundle, to its own line or to another.
    fn control(&mut self, bundle: u32, parts: Parts, line: Option<Line>) {
        if parts.total() == 0 {
            return;
        }
        let line = line.unwrap_or_else(|| self.lines.bundle_line(bundle));
        let function = self.lines.function(bundle);
        let code = (function, None, line);
        self.code.entry(code).or_default().add(&parts);
        self.functions.entry(function).or_default().add(&parts);
        self.all.add(&parts);
    }

    /// Adds cycles of a loop on the array to a line.
    fn array(&mut self, kernel: usize, parts: Parts, line: Line) {
        if parts.total() == 0 {
            return;
        }
        let launcher = self.lines.launcher(kernel);
        let code = (launcher, Some(kernel), line);
        self.code.entry(code).or_default().add(&parts);
        self.loops[kernel].parts.add(&parts);
        self.functions.entry(launcher).or_default().add(&parts);
        self.all.add(&parts);
    }

    fn finish(self) -> Profile {
        let name = |function: Option<usize>| {
            function.map_or(String::new(), |f| self.spec.functions[f].0.clone())
        };
        let functions = self.functions.into_iter();
        let mut functions: Vec<FunctionProfile> = functions
            .filter(|(_, parts)| parts.total() > 0)
            .map(|(function, parts)| FunctionProfile {
                name: name(function),
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
        let mut lines: BTreeMap<&Line, Parts> = BTreeMap::new();
        for ((_, _, line), parts) in &self.code {
            lines.entry(line).or_default().add(parts);
        }
        let line = |((file, line), parts): (&Line, Parts)| LineProfile {
            file: file.clone(),
            line: *line,
            parts,
        };
        let lines = lines.into_iter().filter(|(_, parts)| parts.total() > 0);
        let lines = lines.map(line).collect();
        let code = self.code.into_iter();
        let code = code.filter(|(_, parts)| parts.total() > 0);
        let code = code.map(|((function, kernel, (file, line)), parts)| CodeProfile {
            function: name(function),
            kernel: kernel.map(|k| self.spec.kernels[k].name.clone()),
            file,
            line,
            parts,
        });
        Profile {
            machine: self.spec.machine.clone(),
            cores: self.cores,
            parts: self.all,
            functions,
            loops,
            lines,
            code: code.collect(),
            frame: None,
            timeline: None,
            advice: Vec::new(),
        }
    }
}
