//! Traces of frames: against the system's own account, and against cores that run by single cycles.

use super::steps::cells;
use super::timeline;
use super::waves::Waves;
use srp_archdesc::arch::Arch;
use srp_archdesc::system::BankSpec;
use srp_csimgen::{Interpreter, SimSpec, link};
use srp_ir::check::Checked;
use srp_runtime::core::{Activity, Bus, Core, CoreState, Run, Trap};
use srp_runtime::effect::{self, Guard};
use srp_runtime::scene::demo::demo;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{self, CoreView, Observer, Report, TakenTile, Timing};
use srp_tests::LITTLE;
use srp_tests::studio::Studio;
use srp_toolchain::{schedule, system_options};
use srp_traces::{Format, Trace, Tracer, Window};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex};

pub(super) struct Film {
    studio: Studio,
    pub(super) program: Checked,
    pub(super) spec: SimSpec,
}

impl Film {
    pub(super) fn of(size: (u32, u32)) -> Film {
        let mut studio = Studio::of(demo(), size);
        studio.arch.system.sram_banks = Some(BankSpec {
            count: 4,
            width: 16,
            shared: true,
        });
        let effects = effect::find(&studio.scene).into_iter().collect();
        let (program, session) = (studio.program(effects), srp_tests::session());
        let compiled = schedule(program, &studio.arch, LITTLE, &session);
        let program = compiled.expect("it compiles").schedule.program;
        let spec = link(&program).expect("it links");
        Film {
            studio,
            program,
            spec,
        }
    }

    pub(super) fn image(&self) -> SceneImage {
        self.studio.image()
    }

    pub(super) fn arch(&self) -> &Arch {
        &self.studio.arch
    }

    pub(super) fn run<'a>(
        &'a self,
        cores: Vec<Box<dyn Core>>,
        observer: Option<&'a mut dyn Observer>,
    ) -> Report {
        let session = srp_tests::session();
        let options = system::Options {
            observer,
            ..system_options(
                &self.program,
                self.arch(),
                Guard::default(),
                Timing::Full,
                &session,
            )
        };
        let rendered = system::render(self.studio.image(), cores, self.arch(), options);
        rendered.expect("the frame is finished").1
    }

    pub(super) fn interpreter(&self) -> Box<dyn Core> {
        Box::new(Interpreter::new(&self.spec))
    }

    pub(super) fn traced(&self, window: &str) -> (Trace, Report) {
        let window = Window::parse(window).expect("it is one");
        let mut tracer = Tracer::new(&self.program, window).expect("it links");
        let cores = 0..self.arch().system.cores;
        let cores = cores.map(|_| tracer.core(self.interpreter())).collect();
        let report = self.run(cores, Some(&mut tracer));
        let trace = tracer.trace().expect("the window was reached");
        assert!(!trace.is_cut);
        (trace, report)
    }

    fn by_single_cycles(&self, window: Range<u64>) -> (Log, Report) {
        let log = Arc::new(Mutex::new(Log {
            window,
            ..Log::default()
        }));
        let cores = 0..self.arch().system.cores;
        let stepping = |core| -> Box<dyn Core> {
            Box::new(Stepping {
                core,
                engine: Interpreter::new(&self.spec),
                log: Arc::clone(&log),
            })
        };
        let cores = cores.map(stepping).collect();
        let report = self.run(cores, Some(&mut Watching(Arc::clone(&log))));
        let mut log = log.lock().expect("nobody panics");
        (std::mem::take(&mut *log), report)
    }
}

/// What cores do by single cycles.
#[derive(Default)]
struct Log {
    window: Range<u64>,
    /// The state of each core after its last run.
    last: BTreeMap<u32, CoreState>,
    /// The state after a cycle of a core.
    after: BTreeMap<(u32, u64), CoreState>,
    tiles: Vec<(u32, u64)>,
}

struct Stepping {
    core: u32,
    engine: Interpreter,
    log: Arc<Mutex<Log>>,
}

impl Core for Stepping {
    fn run(&mut self, bus: &mut dyn Bus, _: u64) -> Result<Run, Trap> {
        let run = self.engine.run(bus, 1)?;
        let state = self.engine.save().expect("it saves");
        self.log
            .lock()
            .expect("nobody panics")
            .last
            .insert(self.core, state);
        Ok(run)
    }
}

struct Watching(Arc<Mutex<Log>>);

impl Observer for Watching {
    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        let mut log = self.0.lock().expect("nobody panics");
        if log.window.contains(&core.cycle) && run.activity != Activity::Switch {
            let state = log.last[&core.core].clone();
            log.after.insert((core.core, core.cycle), state);
        }
    }

    fn tile_taken(&mut self, core: &CoreView<'_>, _: Option<TakenTile>) {
        let mut log = self.0.lock().expect("nobody panics");
        log.tiles.push((core.core, core.cycle));
    }
}

#[test]
fn frames_are_traced_as_their_account_and_their_cores_say() {
    let film = Film::of((24, 16));
    let cores = (0..film.arch().system.cores).map(|_| film.interpreter());
    let plain = film.run(cores.collect(), None);
    whole_frame(&film, &plain);
    registers(&film, &plain);
    tile(&film, &plain);
}

/// The timeline of all cycles has the cycles of the account, and the rays, packets and requests of the frame.
fn whole_frame(film: &Film, plain: &Report) {
    let (trace, report) = film.traced("0..131072");
    assert!(report == *plain, "a trace changes nothing");
    let bytes = Format::Perfetto.write(&trace).expect("it can be written");
    let timeline = timeline::read(&bytes);
    super::read_by_perfetto(&bytes, timeline.packets);
    for (number, core) in report.cores.iter().enumerate() {
        let mut cycles = timeline.cycles(&format!("core {number}/activity"));
        let mut take = |name: &str| cycles.remove(name).unwrap_or(0);
        assert_eq!(take("vliw"), core.vliw);
        assert_eq!(take("switch"), core.switch);
        assert_eq!(take("memory_stall"), core.memory_stall);
        assert_eq!(take("texture_stall"), core.texture_stall);
        assert!(core.sram_stall > 0);
        assert_eq!(take("sram_stall"), core.sram_stall);
        assert_eq!(
            take("wait"),
            core.wait.iter().map(|w| w.cycles).sum::<u64>()
        );
        for kernel in &core.array {
            assert_eq!(take(&kernel.kernel), kernel.cycles, "{}", kernel.kernel);
        }
        cycles.remove("halted");
        assert!(cycles.is_empty(), "{cycles:?}");
    }
    let rays: usize = (0..report.cores.len())
        .map(|core| timeline.count(&format!("core {core}/rays/")))
        .sum();
    assert_eq!(rays as u64, report.tni().unit.rays);
    let resident: u64 = (timeline.counters.iter())
        .filter(|(path, _)| path.contains("trv") && path.ends_with("resident"))
        .map(|(_, samples)| samples.iter().map(|s| s.1 as u64).max().unwrap_or(0))
        .sum();
    assert!(resident > 0);
    // Each packet is sent, in the unit, and taken.
    let flows = timeline.flows.values();
    assert!(flows.clone().count() > 0);
    assert!(
        flows
            .clone()
            .all(|&(through, ends)| through > 2 && ends == 1)
    );
}

/// Every register of every core in every cycle of a window in the middle.
fn registers(film: &Film, plain: &Report) {
    let window = 9000..9200;
    let (log, stepped) = film.by_single_cycles(window.clone());
    let (trace, report) = film.traced(&format!("{}..{}", window.start, window.end));
    assert!(stepped == *plain, "{} cycles", stepped.cycles);
    assert!(report == *plain, "{} cycles", report.cycles);
    let bytes = Format::Fst.write(&trace).expect("it can be written");
    let mut waves = Waves::of(bytes);
    let mut cycles = 0;
    for (&(core, cycle), state) in &log.after {
        let expected = cells(&film.spec, state);
        waves.check(&film.program, &film.spec, core, cycle + 1, &expected);
        cycles += 1;
    }
    assert!(cycles > 200, "{cycles}");
}

/// A tile is from after its being taken until the next is.
fn tile(film: &Film, plain: &Report) {
    let (log, _) = film.by_single_cycles(0..0);
    let (trace, report) = film.traced("tile:2");
    assert!(report == *plain, "{} cycles", report.cycles);
    let core = trace.cores[0].core;
    assert_eq!(trace.cores.len(), 1);
    let taken: Vec<u64> = log
        .tiles
        .iter()
        .filter(|t| t.0 == core)
        .map(|t| t.1)
        .collect();
    let at = taken.iter().position(|&t| t + 1 == trace.cycles.start);
    let at = at.expect("it begins where a tile is taken");
    assert_eq!(taken[at + 1], trace.cycles.end);
}
