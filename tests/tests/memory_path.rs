//! The way from the SRP to the memory: each switch of the machine moves cycles and never the picture.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::system::{BankSpec, CacheSpec};
use srp_archdesc::{Arch, dram};
use srp_ir::check::Checked;
use srp_ir::pass;
use srp_runtime::core::{Bus, Core, Run, Trap};
use srp_runtime::effect::{self, Guard};
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::picture::Picture;
use srp_runtime::scene::demo::demo;
use srp_runtime::system::{self, CoreReport, Report, Timing};
use srp_tests::LITTLE;
use srp_tests::studio::Studio;
use srp_toolchain::{Engine, Engines, code_sizes, schedule, system_options};
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

/// Cores that fetch their code, with too little room for it.
fn fetching(arch: &Arch) -> Arch {
    let mut arch = arch.clone();
    arch.system.instruction_cache = Some(CacheSpec {
        bytes: 1024,
        ways: 2,
        line: 64,
        latency: 1,
        banks: 1,
        misses: 1,
        blocking: false,
    });
    arch.srp.shared_contexts = true;
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
        let options = system_options(&program, arch, Guard::default(), Timing::Full, &session);
        system::render(studio.image(), cores, arch, options).expect("the frame is finished")
    };
    let cut = |arch: &Arch| cut_anywhere(run, arch, &engines);
    cut(&studio.arch);
    cut(&decoupled_at_other_clocks(&studio.arch));
    cut(&fetching(&decoupled_at_other_clocks(&studio.arch)));
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
    // Code that is fetched takes time, bytes and nothing else.
    let sizes = code_sizes(&program, &studio.arch);
    let core = |report: &Report| report.cores[0].clone();
    let fetched = core(&of(&|arch| *arch = fetching(arch)));
    let base = core(&base);
    assert_eq!(base.instruction_stall + base.context_stall, 0);
    assert_eq!((base.instruction_cache, base.contexts), (None, None));
    assert!(fetched.instruction_stall > 0 && fetched.context_stall > 0);
    let (vliw, switch) = (
        |core: &CoreReport| core.vliw,
        |core: &CoreReport| core.switch,
    );
    assert_eq!(
        (vliw(&fetched), switch(&fetched)),
        (vliw(&base), switch(&base))
    );
    // In a cache with room for all bundles, each line is missed once.
    let bytes: u32 = sizes.bundles.iter().sum();
    let roomy = core(&of(&|arch| {
        *arch = fetching(arch);
        let cache = arch.system.instruction_cache.as_mut().expect("it has one");
        cache.bytes = bytes.next_power_of_two();
    }));
    let cache = roomy.instruction_cache.expect("it has one");
    assert!(
        cache.misses <= u64::from(bytes.div_ceil(64)) + 1,
        "{cache:?}"
    );
    let small = fetched.instruction_cache.expect("it has one");
    assert_eq!(small.hits + small.misses, cache.hits + cache.misses);
    assert!(small.misses > cache.misses && roomy.instruction_stall < fetched.instruction_stall);
    // Where the memory holds all kernels, each is loaded once.
    let contexts: u32 = sizes.contexts.iter().sum();
    let deep = core(&of(&|arch| {
        *arch = fetching(arch);
        arch.srp.contexts = contexts;
    }));
    let (few, many) = (
        deep.contexts.expect("shared"),
        fetched.contexts.expect("shared"),
    );
    assert_eq!(few.launches, many.launches);
    let launched = base.array.len() as u64;
    assert!(
        few.loads == launched && few.loads <= many.loads,
        "{few:?} {many:?}"
    );
    let one = core(&of(&|arch| {
        *arch = fetching(arch);
        arch.srp.contexts = 1;
    }));
    let one = one.contexts.expect("shared");
    assert!(one.loads > few.loads && one.bytes > few.bytes, "{one:?}");
}

/// Kernels that share contexts are made to fit together at the IIs that they have alone, and a shared memory costs no
/// new schedule where they fit.
#[test]
fn kernels_that_share_contexts_fit_together() {
    let studio = Studio::of(demo(), (8, 8));
    let effects = effect::find(&studio.scene).into_iter().collect();
    let session = srp_tests::session();
    let compile = |arch: &Arch| -> Vec<(u32, u32)> {
        let program = studio.program(effects);
        let compiled = schedule(program, arch, LITTLE, &session).expect("it compiles");
        let kernels = compiled.schedule.program.kernels.values();
        kernels.map(|k| (k.ii, k.contexts())).collect()
    };
    let iis = |kernels: &[(u32, u32)]| -> Vec<u32> { kernels.iter().map(|k| k.0).collect() };
    let contexts = |kernels: &[(u32, u32)]| kernels.iter().map(|k| k.1).sum::<u32>();
    let alone = compile(&studio.arch);
    let (least, most) = (iis(&alone).iter().sum::<u32>(), contexts(&alone));
    assert!(least < most, "some kernel is repeated");
    let mut arch = studio.arch.clone();
    arch.srp.shared_contexts = true;
    arch.srp.contexts = most.max(studio.arch.srp.contexts);
    assert_eq!(contexts(&compile(&arch)), most);
    arch.srp.contexts = studio.arch.srp.contexts.min(most - 1);
    let together = compile(&arch);
    assert_eq!(iis(&together), iis(&alone));
    assert!(
        contexts(&together) <= arch.srp.contexts,
        "{together:?} for {alone:?}"
    );
}

/// Prefetches of the kernels' loops: misses become lines that were asked for ahead, cores that stand still at
/// each do so for less, and the picture is the same.
#[test]
fn prefetches_move_cycles_and_no_pixel() {
    let studio = Studio::of(demo(), (64, 48));
    let effects = effect::find(&studio.scene).into_iter().collect();
    let session = srp_tests::session();
    let plain = studio.program(effects);
    let mut ahead = plain.clone();
    let options = pass::Options {
        prefetch: Some(studio.arch.system.data_cache.line),
        ..pass::Options::new(studio.arch.precision)
    };
    let passes = pass::parse("prefetch, simplify, compact").expect("there are these passes");
    pass::run(&mut ahead, &passes, &options, &mut |_, _| {});
    let scheduled = |program| {
        let compiled = schedule(program, &studio.arch, LITTLE, &session).expect("it compiles");
        let program = compiled.schedule.program;
        let engines = Engines::of(&program, Engine::Interpreter, &session).expect("it links");
        (program, engines)
    };
    let [plain, ahead] = [plain, ahead].map(scheduled);
    for blocking in [true, false] {
        let mut arch = studio.arch.clone();
        arch.system.data_cache.blocking = blocking;
        let frame = |(program, engines): &(Checked, Engines), arch: &Arch| {
            let run = |arch: &Arch, cores: Vec<Box<dyn Core>>| -> (Picture, Report) {
                let options =
                    system_options(program, arch, Guard::default(), Timing::Full, &session);
                system::render(studio.image(), cores, arch, options).expect("the frame is finished")
            };
            cut_anywhere(run, arch, engines);
            run(arch, engines.cores(arch.system.cores))
        };
        let (picture, without) = frame(&plain, &arch);
        let (same, with) = frame(&ahead, &arch);
        assert_eq!(same.rgba, picture.rgba);
        let all = |report: &Report| {
            let mut all = CacheCounters::default();
            report.cores.iter().for_each(|c| all.add(&c.data_cache));
            all
        };
        let (before, after) = (all(&without), all(&with));
        assert_eq!((before.prefetches, before.dropped), (0, 0));
        assert!(
            after.prefetches > 0 && after.misses < before.misses,
            "{after:?}, {before:?}"
        );
        let stalls = |report: &Report| -> u64 { report.cores.iter().map(|c| c.memory_stall).sum() };
        println!(
            "blocking {blocking}: {} of {}, {} of {}",
            stalls(&without),
            without.cycles,
            stalls(&with),
            with.cycles
        );
        assert!(!blocking || stalls(&with) < stalls(&without));
    }
}

/// Banks of the SRAM: a core stands still where accesses meet, less so where there are more, and nothing else changes.
#[test]
fn banks_move_cycles_and_no_pixel() {
    let studio = Studio::of(demo(), (32, 24));
    let effects = effect::find(&studio.scene).into_iter().collect();
    let session = srp_tests::session();
    let program = studio.program(effects);
    let frame = |banks: Option<BankSpec>, cores: u32| -> (Picture, Report) {
        let mut arch = studio.arch.clone();
        arch.system.cores = cores;
        arch.system.sram_banks = banks;
        let compiled = schedule(program.clone(), &arch, LITTLE, &session).expect("it compiles");
        let program = compiled.schedule.program;
        let engines = Engines::of(&program, Engine::Interpreter, &session).expect("it links");
        let run = |arch: &Arch, cores: Vec<Box<dyn Core>>| -> (Picture, Report) {
            let options = system_options(&program, arch, Guard::default(), Timing::Full, &session);
            system::render(studio.image(), cores, arch, options).expect("the frame is finished")
        };
        if cores > 1 {
            cut_anywhere(run, &arch, &engines);
        }
        run(&arch, engines.cores(cores))
    };
    let banks = |count, shared| {
        Some(BankSpec {
            count,
            width: 16,
            shared,
        })
    };
    let (picture, free) = frame(None, 1);
    let of = |banks| {
        let (same, report) = frame(banks, 1);
        assert_eq!(same.rgba, picture.rgba);
        let (core, base) = (&report.cores[0], &free.cores[0]);
        // One core does the same in the same order: what passes beside is standing still, and other waits.
        assert_eq!(
            (core.vliw, core.switch, &core.array),
            (base.vliw, base.switch, &base.array)
        );
        report
    };
    let lost = |report: &Report| report.cores[0].sram_stall;
    assert_eq!(lost(&free), 0);
    let [one, two, many] = [1, 2, 16].map(|count| lost(&of(banks(count, false))));
    assert!(one > two && two > many && many > 0, "{one} {two} {many}");
    // Rays of 64 bytes and hits of 24 go through all banks, 256 bytes a cycle, each packet by itself.
    let shared = of(banks(16, true));
    let tni = shared.tni();
    let bytes = 64 * tni.unit.rays + 24 * tni.unit.hits;
    let moved = lost(&shared) - many;
    assert!(
        moved * 256 >= bytes && moved * 256 <= 2 * bytes + (1 << 16),
        "{moved} cycles for {bytes} bytes"
    );
    frame(banks(4, true), 4);
}
