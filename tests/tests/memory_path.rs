//! The way from the SRP to the memory: each switch of the machine moves cycles and never the picture.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::{Arch, dram};
use srp_runtime::core::{Bus, Core, Run, Trap};
use srp_runtime::effect::{self, Guard};
use srp_runtime::picture::Picture;
use srp_runtime::scene::demo::demo;
use srp_runtime::system::{self, Report, Timing};
use srp_tests::LITTLE;
use srp_tests::studio::Studio;
use srp_toolchain::{Engine, Engines, schedule, system_options};
use std::time::{SystemTime, UNIX_EPOCH};

/// Cycles for which the cores stood still for a cache.
fn stalled(report: &Report) -> u64 {
    let of_core = |core: &system::CoreReport| core.memory_stall + core.texture_stall;
    report.cores.iter().map(of_core).sum()
}

/// A core whose runs end sooner than they have to.
struct Cut {
    core: Box<dyn Core>,
    random: Pcg32,
}

impl Core for Cut {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let most = 1 << (self.random.next_u32() % 10);
        self.core.run(bus, budget.min(most))
    }
}

/// How far a core runs before the others do is the simulator's business: no cycle and no counter depends on it.
fn cut_anywhere(
    run: impl Fn(&Arch, Vec<Box<dyn Core>>) -> (Picture, Report),
    arch: &Arch,
    engines: &Engines,
) {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let seed = since.map_or(0, |since| since.as_secs());
    println!("cut with seed {seed}");
    let cut = |(number, core)| -> Box<dyn Core> {
        let random = Pcg32::seed_from_u64(seed + number);
        Box::new(Cut { core, random })
    };
    let cores = (0..).zip(engines.cores(arch.system.cores)).map(cut);
    let cut = run(arch, cores.collect()).1;
    let whole = run(arch, engines.cores(arch.system.cores)).1;
    assert!(cut == whole, "{} cycles of {}", cut.cycles, whole.cycles);
}

/// Cores that go on under misses, beside units of another clock.
fn decoupled_at_other_clocks(arch: &Arch) -> Arch {
    let mut arch = arch.clone();
    let system = &mut arch.system;
    system.data_cache.blocking = false;
    system.texture_cache.blocking = false;
    system.tni_mhz = system.srp_mhz * 3 / 4;
    system.bus.mhz = system.srp_mhz * 7 / 5;
    arch
}

#[test]
fn the_memory_path_moves_cycles_and_no_pixel() {
    let studio = Studio::of(demo(), (64, 48));
    let effects = effect::find(&studio.scene).into_iter().collect();
    let session = srp_tests::session();
    let program = studio.program(effects);
    let compiled = schedule(program, &studio.arch, LITTLE, &session).expect("it compiles");
    let program = compiled.schedule.program;
    let engines = Engines::of(&program, Engine::Interpreter, &session).expect("it links");
    let run = |arch: &Arch, cores: Vec<Box<dyn Core>>| -> (Picture, Report) {
        let options = system_options(&program, Guard::default(), Timing::Full, &session);
        system::render(studio.image(), cores, arch, options).expect("the frame is finished")
    };
    let cut = |arch: &Arch| cut_anywhere(run, arch, &engines);
    cut(&studio.arch);
    cut(&decoupled_at_other_clocks(&studio.arch));
    let render = |change: &dyn Fn(&mut Arch)| -> (Picture, Report) {
        // One core, so that who gets which tile does not matter.
        let mut arch = studio.arch.clone();
        arch.system.cores = 1;
        change(&mut arch);
        run(&arch, engines.cores(1))
    };
    let (picture, base) = render(&|_| {});
    // Nearly all loads are those of loops on the array, most of them those of triangles' records.
    let stalls = &base.cores[0].kernel_stalls;
    let in_kernels: u64 = stalls.iter().map(|k| k.cycles).sum();
    assert!(in_kernels <= stalled(&base) && in_kernels * 10 > stalled(&base) * 9);
    let most = stalls.iter().max_by_key(|k| k.cycles);
    assert_eq!(most.map(|k| k.kernel.as_str()), Some("shade_hit"));
    let of = |change: &dyn Fn(&mut Arch)| {
        let (same, report) = render(change);
        assert_eq!(same.rgba, picture.rgba);
        report
    };
    let decoupled = of(&|arch| {
        arch.system.data_cache.blocking = false;
        arch.system.texture_cache.blocking = false;
    });
    assert!(decoupled.cycles < base.cycles && stalled(&decoupled) < stalled(&base));
    let one_miss = of(&|arch| {
        for cache in [&mut arch.system.data_cache, &mut arch.system.texture_cache] {
            (cache.blocking, cache.misses) = (false, 1);
        }
    });
    assert!(stalled(&one_miss) > stalled(&decoupled) && stalled(&one_miss) < stalled(&base));
    let short_lines = of(&|arch| arch.system.data_cache.line = 32);
    assert!(stalled(&short_lines) > stalled(&base));
    let rows = of(&|arch| arch.system.tile_block = 1);
    let misses =
        |report: &Report| -> u64 { report.cores.iter().map(|c| c.data_cache.misses).sum() };
    assert!(misses(&rows) > misses(&base));
    let slow = of(&|arch| {
        let [_, slow, ..] = dram::presets();
        arch.system.dram = slow.spec;
    });
    assert!(slow.cycles > base.cycles && stalled(&slow) > 2 * stalled(&base));
}
