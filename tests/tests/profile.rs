//! Profiles: the same cycles as the account, given to the lines that took them.

use srp_archdesc::system::{BankSpec, CacheSpec};
use srp_archdesc::{Arch, Unwatched};
use srp_ir::check::Checked;
use srp_runtime::effect::{self, Guard};
use srp_runtime::scene::demo::demo;
use srp_runtime::solo::{self, Finish, Solo, SoloError};
use srp_runtime::system::{self, Report, Timing};
use srp_studies::energy::{Energy, Use, energy, moved};
use srp_studies::profile::{ObjectProfile, Parts, Profile, Profiler, Surroundings, add_account};
use srp_tests::studio::Studio;
use srp_tests::{LITTLE, compiled, machine};
use srp_toolchain::{Effort, code_sizes, schedule, system_options};
use std::fs;

/// A program with a loop on the array, one that the VLIW engine runs, and a function that is called.
const PROGRAM: &str = "\
float a[64], b[64];
int next[64];
int hops(int from) {
    int n = 0;
    while (next[from]) { from = next[from]; n++; }
    return n;
}
int main(void) {
    for (int i = 0; i < 64; i++) next[i] = i < 40 ? i + 1 : 0;
    for (int times = 0; times < 5; times++)
#pragma srp kernel
        for (int i = 0; i < 64; i++)
            b[i] += a[i] * 2.0f;
    return hops(1) + hops(2);
}
";

fn sums(profile: &Profile) {
    let mut lines = Parts::default();
    profile.lines.iter().for_each(|line| lines += line.parts);
    assert_eq!(lines, profile.parts, "lines sum to all cycles");
    let mut functions = Parts::default();
    profile.functions.iter().for_each(|f| functions += f.parts);
    assert_eq!(functions, profile.parts, "functions sum to all cycles");
}

fn run(text: &str) -> (Profile, Finish) {
    run_on(&machine("sgrt"), text)
}

fn run_on(arch: &Arch, text: &str) -> (Profile, Finish) {
    let (profile, finish, ended) = run_anyhow(arch, text);
    ended.expect("it ends");
    (profile, finish)
}

fn run_anyhow(arch: &Arch, text: &str) -> (Profile, Finish, Result<(), SoloError>) {
    let folder = std::env::temp_dir().join(format!("srp-profile-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    let file = folder.join("program.c");
    fs::write(&file, text).expect("a temporary file");
    let program = compiled(&[file], arch).expect("it compiles");
    let session = srp_tests::session();
    let program = schedule(program, arch, Effort::default(), &session).expect("it is scheduled");
    let program = &program.schedule.program;
    let mut profiler = Profiler::new(program).expect("it links");
    let mut core = profiler.core();
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let mut finish = Finish::default();
    let ended = solo::run_until(core.as_mut(), &mut bus, 1 << 30, &Unwatched, &mut finish);
    let _ = fs::remove_dir_all(folder);
    (profiler.profile(), finish, ended)
}

/// A bank of the SRAM that all accesses meet in: loop and lines have the cycles.
#[test]
fn conflicts_of_banks_are_of_their_loop() {
    let mut arch = machine("sgrt");
    arch.system.sram_banks = Some(BankSpec {
        count: 1,
        width: 16,
        shared: false,
    });
    let (profile, finish) = run_on(&arch, PROGRAM);
    sums(&profile);
    assert_eq!(profile.parts.total(), finish.cycles());
    assert_eq!(profile.parts.sram_stall, finish.sram_stall);
    let (free, _) = run(PROGRAM);
    assert_eq!(free.parts.total() + finish.sram_stall, finish.cycles());
    // Each of 64 iterations, five times, loads two words and stores one; the II is less than three.
    let of_loops: u64 = profile.loops.iter().map(|l| l.parts.sram_stall).sum();
    assert!(
        of_loops >= 5 * 64 && of_loops <= finish.sram_stall,
        "{of_loops}"
    );
}

#[test]
fn a_trap_leaves_all_cycles_before_it() {
    // On the array, and on the VLIW engine.
    for (from, to) in [
        (
            "i < 64; i++)\n            b",
            "i < 900000; i++)\n            b",
        ),
        ("hops(2)", "hops(next[9999999])"),
    ] {
        let text = PROGRAM.replace(from, to);
        assert_ne!(text, PROGRAM);
        let (profile, finish, ended) = run_anyhow(&machine("sgrt"), &text);
        assert!(matches!(ended, Err(SoloError::Trap(_))), "{ended:?}");
        let parts = profile.parts;
        assert_eq!(parts.total(), finish.cycles());
        assert_eq!(parts.vliw + parts.empty, finish.vliw);
        let array = finish.kernels.values().sum::<u64>();
        assert_eq!(parts.array, array);
        assert!(array > 100 && finish.vliw > 10, "{finish:?}");
        // Iterations are those that began.
        for looped in &profile.loops {
            let iterations = looped.iterations.all;
            assert!(iterations * u64::from(looped.ii) <= looped.parts.array + u64::from(looped.ii));
        }
    }
}

#[test]
fn a_program_is_profiled_to_the_cycle() {
    let (profile, finish) = run(PROGRAM);
    sums(&profile);
    let parts = profile.parts;
    assert_eq!(parts.total(), finish.cycles());
    assert_eq!(parts.vliw + parts.empty, finish.vliw);
    assert_eq!(parts.switch, finish.switch);
    assert_eq!(parts.array, finish.kernels.values().sum::<u64>());
    assert_eq!(finish.status, 38 + 39 - 2 + 2);
    let of = |line: u32| {
        let mut parts = Parts::default();
        let lines = profile
            .lines
            .iter()
            .filter(|l| l.line == line && l.file.ends_with("program.c"));
        lines.for_each(|l| parts += l.parts);
        parts
    };
    // A walk along a list is control code's.
    assert!(of(5).vliw > 0 && of(5).array == 0, "{:?}", of(5));
    let looped = profile
        .loops
        .iter()
        .max_by_key(|l| l.launches)
        .expect("a loop is on the array");
    assert_eq!((looped.launches, looped.iterations.all), (5, 5 * 64));
    assert_eq!((looped.iterations.fewest, looped.iterations.most), (64, 64));

    // The loop's cycles are those of its body and of its own counting.
    assert!(of(13).array > 0 && of(13).vliw == 0, "{:?}", of(13));
    assert_eq!(of(12).array + of(13).array, looped.parts.array);

    // A longer walk moves the cycles of its line, and no other's by as much.
    let (longer, _) = run(&PROGRAM.replace("i < 40", "i < 60"));
    let walk = |p: &Profile| -> u64 {
        let lines = p.lines.iter().filter(|l| l.line == 5);
        lines.map(|l| l.parts.total()).sum()
    };
    let (more, all) = (
        walk(&longer) - walk(&profile),
        longer.parts.total() - profile.parts.total(),
    );
    assert!(more * 10 >= all * 9, "{more} of {all}");
}

/// The frame's own account.
fn account(report: &Report) -> Parts {
    let mut all = Parts::default();
    for core in &report.cores {
        all += Parts {
            vliw: core.vliw,
            empty: 0,
            array: core.array.iter().map(|k| k.cycles).sum(),
            switch: core.switch,
            memory_stall: core.memory_stall,
            texture_stall: core.texture_stall,
            instruction_stall: core.instruction_stall,
            context_stall: core.context_stall,
            sram_stall: core.sram_stall,
            wait: core.wait.iter().map(|w| w.cycles).sum(),
        };
    }
    all
}

fn profiled(studio: &Studio, arch: &Arch, program: &Checked) -> (Profile, Report) {
    let session = srp_tests::session();
    let mut profiler = Profiler::new(program).expect("it links");
    let image = studio.image();
    let surroundings = Surroundings::of(&image, &studio.scene, &arch.system);
    let cores = profiler.frame(surroundings, arch.system.cores);
    let options = system::Options {
        observer: Some(&mut profiler),
        ..system_options(program, arch, Guard::default(), Timing::Full, &session)
    };
    let (picture, report) =
        system::render(image, cores, arch, options).expect("the frame is finished");
    let engines = srp_toolchain::Engines::of(program, srp_toolchain::Engine::Interpreter, &session);
    let cores = engines.expect("it links").cores(arch.system.cores);
    let options = system_options(program, arch, Guard::default(), Timing::Full, &session);
    let plain = system::render(studio.image(), cores, arch, options).expect("it is finished");
    assert!(
        plain.0.rgba == picture.rgba && plain.1 == report,
        "a profile changes nothing"
    );
    let mut profile = profiler.profile();
    add_account(&mut profile, &report, program, arch);
    (profile, report)
}

/// The work of caches and T&I units is that of the account.
fn frame_sums(profile: &Profile, report: &Report, energy: &Energy) {
    let frame = profile.frame.as_ref().expect("it is a frame");
    let still = profile.parts.memory_stall + profile.parts.texture_stall;
    assert_eq!(frame.objects.iter().map(|o| o.stall).sum::<u64>(), still);
    assert_eq!(frame.accesses.iter().map(|a| a.stall).sum::<u64>(), still);
    let read = |o: &ObjectProfile| o.by_data + o.by_texture + o.by_tni;
    let dram = &report.dram.counters;
    assert_eq!(frame.objects.iter().map(read).sum::<u64>(), dram.bytes_read);
    let written = frame.objects.iter().map(|o| o.written);
    assert_eq!(written.sum::<u64>(), dram.bytes_written);
    let asked = frame.objects.iter().map(|o| o.by_data + o.by_texture);
    assert_eq!(
        frame.accesses.iter().map(|a| a.bytes).sum::<u64>(),
        asked.sum::<u64>()
    );
    let (tni, of) = (report.tni(), &frame.materials);
    assert_eq!(of.iter().map(|m| m.rays).sum::<u64>(), tni.unit.results);
    let cycles = of.iter().map(|m| m.cycles).sum::<u64>();
    assert_eq!(cycles, tni.unit.resident_cycles);
    let tests = of.iter().map(|m| m.tests).sum::<u64>();
    assert_eq!(tests, tni.triangle_tests);
    let missed = of.iter().filter(|m| m.material.is_empty());
    let missed: u64 = missed.map(|m| m.rays).sum();
    assert_eq!(missed, tni.unit.results - tni.unit.hits);
    let visits: u64 = of.iter().map(|m| m.visits).sum();
    let by_level = frame.levels.iter().map(|l| l.visits + l.leaf_visits);
    assert_eq!(by_level.sum::<u64>(), visits);
    let by_level: u64 = frame.levels.iter().map(|l| l.tests).sum();
    assert_eq!(by_level, tests);
    let by_tni: u64 = frame.objects.iter().map(|o| o.by_tni).sum();
    assert_eq!(frame.levels.iter().map(|l| l.bytes).sum::<u64>(), by_tni);
    let names: Vec<&str> = frame
        .pipelines
        .iter()
        .map(|p| p.pipeline.as_str())
        .collect();
    assert_eq!(names, ["TRV_PRE", "TRV_AABB", "TRV_POST", "IST"]);
    assert_eq!(frame.pipelines[3].account, tni.ist.account);
    let all: f64 = frame.energy.iter().map(|of| of.mj).sum();
    assert!((all / energy.total_mj - 1.0).abs() < 1e-9, "{all} mJ");
    for l in &profile.loops {
        let has_energy = frame.energy.iter().any(|of| of.of == l.kernel);
        assert!(has_energy, "{}", l.kernel);
    }
    let lines: f64 = frame.energy_of_lines.iter().map(|l| l.mj).sum();
    let is_code =
        |of: &&Use| profile.loops.iter().any(|l| l.kernel == of.of) || of.of == "VLIW code";
    let code = frame.energy.iter().filter(is_code);
    let asked: u64 = frame.accesses.iter().map(|a| a.bytes).sum();
    let code = code.map(|of| of.mj).sum::<f64>() + moved(asked);
    assert!((lines / code - 1.0).abs() < 1e-9, "{lines} mJ of {code}");
    let mut code = Parts::default();
    profile.code.iter().for_each(|of| code += of.parts);
    assert_eq!(code, profile.parts);
}

/// Bytes that the memory gave data caches of an object.
fn of_object(profile: &Profile, name: &str) -> u64 {
    let frame = profile.frame.as_ref().expect("it is a frame");
    let object = frame.objects.iter().find(|o| o.object == name);
    object.map_or(0, |o| o.by_data)
}

#[test]
fn a_frame_is_profiled_to_the_cycle() {
    for name in ["sgrt", "decoupled"] {
        let mut studio = Studio::of(demo(), (48, 32));
        studio.arch = machine(name);
        let effects = effect::find(&studio.scene).into_iter().collect();
        let session = srp_tests::session();
        let program = studio.program(effects);
        let compiled = schedule(program, &studio.arch, LITTLE, &session).expect("it compiles");
        let program = compiled.schedule.program;
        let (profile, report) = profiled(&studio, &studio.arch, &program);
        sums(&profile);
        let energy = energy(&report, &program, &studio.arch);
        frame_sums(&profile, &report, &energy);
        let parts = Parts {
            vliw: profile.parts.vliw + profile.parts.empty,
            empty: 0,
            ..profile.parts
        };
        assert_eq!(parts, account(&report), "{name}");
        for l in &profile.loops {
            let runs = report.cores.iter().flat_map(|core| &core.array);
            let runs = runs.filter(|k| k.kernel == l.kernel);
            let cycles = runs.clone().map(|k| k.cycles);
            assert_eq!(l.parts.array, cycles.sum::<u64>(), "{name}: {}", l.kernel);
            let mut kernels = program.kernels.values();
            let kernel = kernels.find(|kernel| kernel.dfg.name == l.kernel);
            let nodes = kernel.expect("it ran").dfg.nodes.len() as u64;
            let operations = runs.map(|k| k.operations).sum::<u64>();
            assert_eq!(operations, l.iterations.all * nodes, "{name}: {}", l.kernel);
            let stalls = report.cores.iter().flat_map(|core| &core.kernel_stalls);
            let stalls = stalls.filter(|k| k.kernel == l.kernel).map(|k| k.cycles);
            let still = l.parts.memory_stall + l.parts.texture_stall;
            assert_eq!(still, stalls.sum::<u64>(), "{name}: {}", l.kernel);
        }
        // The course of time has the same cycles, core by core.
        let timeline = profile.timeline.as_ref().expect("a frame has one");
        assert_eq!(timeline.cores.len(), report.cores.len());
        for (core, of) in timeline.cores.iter().zip(&report.cores) {
            let cycles = |name: &str| -> u64 {
                let doings = core.doings.iter().filter(|d| d.doing == name);
                doings.flat_map(|doing| &doing.cycles).sum()
            };
            assert_eq!(cycles("VLIW"), of.vliw, "{name}");
            assert_eq!(cycles("memory"), of.memory_stall, "{name}");
            assert_eq!(cycles("texture"), of.texture_stall, "{name}");
            let waits = of.wait.iter().map(|wait| wait.cycles);
            assert_eq!(cycles("wait"), waits.sum::<u64>(), "{name}");
            for kernel in &of.array {
                assert_eq!(
                    cycles(&kernel.kernel),
                    kernel.cycles,
                    "{name}: {}",
                    kernel.kernel
                );
            }
            for step in 0..core.rays.len() {
                let all: u64 = core.doings.iter().map(|doing| doing.cycles[step]).sum();
                assert!(all <= timeline.step, "{name}: {all} cycles in a step");
            }
        }
        let rays = timeline.cores.iter().flat_map(|core| &core.rays);
        assert_eq!(rays.sum::<u64>(), report.tni().unit.results, "{name}");
        // The core stands still at lines of kernels.
        let still = profile.lines.iter().filter(|l| l.parts.memory_stall > 0);
        let (lines, nowhere): (Vec<_>, Vec<_>) = still.partition(|l| l.line > 0);
        assert!(lines.len() > 3 && nowhere.is_empty(), "{nowhere:?}");
        // A larger cache asks for fewer lines of what is read again.
        let mut larger = studio.arch.clone();
        larger.system.data_cache.bytes *= 8;
        let (larger, _) = profiled(&studio, &larger, &program);
        for object in ["materials", "shading data of triangles"] {
            let [few, many] = [&larger, &profile].map(|of| of_object(of, object));
            assert!(
                few < many,
                "{name}, {object}: {few} instead of {many} bytes"
            );
        }
    }
}

/// Cores that fetch their code, with too little room for it, stand still at the lines of their bundles; more room is
/// advised, and helps.
#[test]
fn code_that_is_fetched_is_in_the_profile() {
    let studio = Studio::of(demo(), (48, 32));
    let effects = effect::find(&studio.scene).into_iter().collect();
    let session = srp_tests::session();
    let program = studio.program(effects);
    let compiled = schedule(program, &studio.arch, LITTLE, &session).expect("it compiles");
    let program = compiled.schedule.program;
    let mut arch = studio.arch.clone();
    arch.srp.shared_contexts = true;
    // Half of what they all have.
    let all: u32 = code_sizes(&program, &arch).contexts.iter().sum();
    arch.srp.contexts = all.div_ceil(2);
    arch.system.instruction_cache = Some(CacheSpec {
        bytes: 1024,
        ways: 2,
        line: 64,
        ..arch.system.data_cache
    });
    let (profile, report) = profiled(&studio, &arch, &program);
    sums(&profile);
    let parts = Parts {
        vliw: profile.parts.vliw + profile.parts.empty,
        empty: 0,
        ..profile.parts
    };
    assert_eq!(parts, account(&report));
    assert!(parts.instruction_stall > 0 && parts.context_stall > 0);
    // Bundles are not those of loops on the array.
    for l in &profile.loops {
        let of_code = l.parts.instruction_stall + l.parts.context_stall;
        assert_eq!(of_code, 0, "{}", l.kernel);
    }
    let is_advised = |attribute: &str| {
        let mut set = profile.advice.iter().flat_map(|advice| &advice.set);
        set.any(|(name, _)| name == attribute)
    };
    assert!(is_advised("instruction-cache.size") && is_advised("array.contexts"));
    let mut roomy = [arch.clone(), arch];
    let cache = roomy[0].system.instruction_cache.as_mut();
    cache.expect("it has one").bytes *= 2;
    roomy[1].srp.contexts *= 2;
    for arch in roomy {
        let cycles = profiled(&studio, &arch, &program).1.cycles;
        assert!(cycles < report.cycles, "{cycles} of {}", report.cycles);
    }
}
