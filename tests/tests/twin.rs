//! The kernels of the frame and the texture unit have a native twin: the same C, compiled by the
//! host's compiler. Both engines and the intermediate form must fill the same buffers with the same
//! bits.

use srp_csimgen::{Interpreter, link};
use srp_ir::dre;
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_kernels::form::{self, Forms};
use srp_runtime::core::Core;
use srp_runtime::effect::Effects;
use srp_runtime::solo::{self, Solo};
use srp_tests::{LITTLE, compiled_for, machine, root, session};
use srp_toolchain::schedule;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Bytes of system memory that the test uses.
const MEMORY: usize = 32768;

/// The macros of kernels that are built for a set of effects, in some forms.
fn defines((effects, forms): (Effects, Forms)) -> Vec<(String, String)> {
    effects.defines().chain(forms.defines()).collect()
}

/// Returns the output of a program that the host's compiler builds; `None` where there is none.
fn native(sources: &[PathBuf], build: (Effects, Forms)) -> Option<Vec<u8>> {
    let stem = sources[0].file_stem().unwrap_or_default().to_string_lossy();
    let (count, forms) = (build.0.iter().count(), build.1.to_string());
    let name = format!("twin-{stem}-{}-{count}{forms}", std::process::id());
    let exe = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let defined = defines(build);
    let defined: Vec<String> = defined.iter().map(|(n, v)| format!("-D{n}={v}")).collect();
    let host = root().join("tests/twin/host.h");
    let flags = [
        "-std=gnu11",
        "-O2",
        "-ffp-contract=off",
        "-fwrapv",
        "-Wno-unknown-pragmas",
    ];
    let mut command = Command::new("cc");
    command
        .args(flags)
        .args(&defined)
        .arg("-I")
        .arg(root().join("kernels"));
    let main = &sources[0];
    // Only the program itself has the host's memory; the kernels refer to it.
    command
        .arg("-include")
        .arg(&host)
        .arg("-c")
        .arg(main)
        .arg("-o")
        .arg(exe.with_extension("o"));
    let compiled = command.output().ok()?;
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );
    let mut command = Command::new("cc");
    command
        .args(flags)
        .args(&defined)
        .arg("-I")
        .arg(root().join("kernels"))
        .args(&sources[1..]);
    command
        .arg(exe.with_extension("o"))
        .arg("-lm")
        .arg("-o")
        .arg(&exe);
    let linked = command.output().expect("cc has just run");
    assert!(
        linked.status.success(),
        "{}",
        String::from_utf8_lossy(&linked.stderr)
    );
    let output = Command::new(&exe)
        .output()
        .expect("the twin has just been linked");
    let _ = std::fs::remove_file(exe.with_extension("o")).and(std::fs::remove_file(&exe));
    Some(output.stdout)
}

/// The globals named `out_*`, one after the other in their order.
fn outputs(symbols: &[(String, u32, u32)], sram: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, address, size) in symbols {
        if name.starts_with("out_") {
            bytes.extend_from_slice(&sram[*address as usize..(address + size) as usize]);
        }
    }
    bytes
}

/// Words, any NaN as the one.
fn words(bytes: &[u8]) -> Vec<u32> {
    let word = |b: &[u8]| u32::from_le_bytes(b.try_into().expect("four bytes"));
    let canonical = |w: u32| {
        if f32::from_bits(w).is_nan() {
            0x7fc0_0000
        } else {
            w
        }
    };
    bytes.chunks_exact(4).map(word).map(canonical).collect()
}

fn compare(engine: &str, twin: &[u32], ours: &[u8]) {
    let ours = words(ours);
    assert_eq!(twin.len(), ours.len(), "{engine}");
    let differing = twin.iter().zip(&ours).position(|(a, b)| a != b);
    assert_eq!(
        differing, None,
        "{engine}: this word of the buffers differs from the host's"
    );
}

#[test]
fn kernels_equal_their_native_twin() {
    all_are_equal(
        &kernels_of_the_frame(),
        (Effects::all(), Forms::default()),
        10,
    );
}

#[test]
fn kernels_of_few_effects_equal_theirs() {
    let few = "normals,emission,light,highlight,shadow";
    let (few, _) = Effects::NONE.parse(few).expect("they are names");
    all_are_equal(&kernels_of_the_frame(), (few, Forms::default()), 6);
}

/// Every value of every form, in as many builds as the form with most has values: one of them at a time, another in
/// each run, or that of number `SRP_TWIN_BUILD`; 0 stands for all.
#[test]
fn kernels_in_other_forms_equal_theirs() {
    let few = "normals,emission,light,highlight,shadow";
    let (few, _) = Effects::NONE.parse(few).expect("they are names");
    let most = form::TABLE.iter().map(|form| form.values.len()).max();
    let builds = 1..most.unwrap_or(2);
    let asked = std::env::var("SRP_TWIN_BUILD").ok();
    let chosen = match asked.and_then(|number| number.parse().ok()) {
        Some(number) => number,
        None => {
            let now = std::time::UNIX_EPOCH.elapsed();
            1 + now.map_or(0, |d| d.as_secs() as usize) % builds.len()
        }
    };
    println!("SRP_TWIN_BUILD={chosen}");
    for number in builds.filter(|&number| chosen == 0 || number == chosen) {
        let choose = |forms: Forms, form: &form::Form| {
            let (value, _) = form.values[number % form.values.len()];
            let chosen = forms.with(&format!("{}={value}", form.name));
            chosen.expect("it is in the table")
        };
        let forms = form::TABLE.iter().fold(Forms::default(), choose);
        let tables = usize::from(forms.to_string().contains("power=table"));
        let (effects, kernels) = match number % 2 {
            0 => (few, 6),
            _ => (Effects::all(), 10),
        };
        all_are_equal(&kernels_of_the_frame(), (effects, forms), kernels + tables);
    }
}

#[test]
fn textures_equal_their_native_twin() {
    all_are_equal(
        &[root().join("tests/twin/texture.c")],
        (Effects::all(), Forms::default()),
        1,
    );
}

/// The test's program and the kernels that it calls.
fn kernels_of_the_frame() -> Vec<PathBuf> {
    let kernels = ["light.c", "secondary.c", "shade.c", "tile.c"];
    let mut sources = vec![root().join("tests/twin/rgs.c")];
    sources.extend(kernels.map(|k| root().join("kernels").join(k)));
    sources
}

/// Runs a program, the first of the files, so many of whose functions have kernels when it is built for these
/// effects and forms, in every way there is.
fn all_are_equal(sources: &[PathBuf], build: (Effects, Forms), kernels: usize) {
    let Some(twin) = native(sources, build) else {
        println!("skipped: there is no C compiler `cc`");
        return;
    };
    let twin = words(&twin);
    let arch = machine("sgrt");
    let program = compiled_for(sources, &arch, defines(build));
    let program = program.unwrap_or_else(|messages| panic!("{messages}"));
    let layout = Layout::of(&program, arch.system.sram_bytes).expect("the buffers fit");
    let symbols: Vec<(String, u32, u32)> = layout
        .symbols(&program)
        .into_iter()
        .map(|s| (s.name, s.address, s.size))
        .collect();

    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    world.memory = vec![0; MEMORY];
    let options = interp::Options {
        precision: arch.precision,
        ..interp::Options::new(&layout)
    };
    let whole = dre::Dre {
        control: program.clone(),
        kernels: Default::default(),
    };
    let main = program.main.expect("there is a main");
    dre::run(&whole, main, &[], &mut world, &options).unwrap_or_else(|t| panic!("{t:?}"));
    compare(
        "the intermediate form",
        &twin,
        &outputs(&symbols, &world.sram),
    );

    // What is compared are values, which schedules of little effort have too.
    let compiled = schedule(program, &arch, LITTLE, &session());
    let compiled = compiled.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(compiled.not_pipelined, [], "every kernel runs on the array");
    let scheduled = compiled.schedule;
    // A function that is called twice may have its loops twice, `shade_miss` and `shade_miss_2`.
    let of = |name: &str| {
        name.trim_end_matches(|c: char| c == '_' || c.is_ascii_digit())
            .to_owned()
    };
    let kernels_found = scheduled.program.kernels.values();
    let found: BTreeSet<String> = kernels_found.map(|k| of(&k.dfg.name)).collect();
    assert_eq!(found.len(), kernels, "{found:?}");
    let spec = link(&scheduled.program).unwrap_or_else(|e| panic!("{e}"));
    let simulate = |engine: &str, core: &mut dyn Core| {
        let mut bus = Solo::new(&scheduled.program.image, arch.system.sram_bytes);
        bus.memory = vec![0; MEMORY];
        let finish = solo::run(core, &mut bus, 100_000_000).unwrap_or_else(|e| panic!("{e}"));
        let symbols = scheduled.program.symbols.iter();
        let symbols: Vec<_> = symbols
            .map(|s| (s.name.clone(), s.address, s.size))
            .collect();
        compare(engine, &twin, &outputs(&symbols, &bus.sram));
        finish
    };
    let interpreted = simulate("the table interpreter", &mut Interpreter::new(&spec));
    if let Some(simulator) = srp_tests::generated(&scheduled.program) {
        let generated = simulate("the generated simulator", &mut simulator.core());
        assert_eq!(interpreted, generated, "both engines take the same cycles");
    }
}
