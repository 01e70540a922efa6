//! Halves by pairs in a word: every engine and the host's compiler compute the same bits, a loop takes half as many
//! cycles, and a machine pays for the units in area.

use srp_archdesc::Arch;
use srp_archdesc::chip;
use srp_archdesc::machines::SGRT;
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_runtime::solo::{self, Finish, Solo};
use srp_tests::{has_host_compiler, root};
use srp_toolchain::{
    Engine, Engines, Input, Options, Session, compile, files, front_end, optimise,
};
use std::process::Command;

fn machine(classes: &str) -> Arch {
    let xml = SGRT
        .xml
        .replace("vfma vdot", &format!("vfma vdot {classes}"));
    srp_archdesc::parse("pairs.xml", &xml).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn source() -> Input {
    let path = root().join("tests/precision/halves.c");
    Input::C(vec![files::read_source(&path).expect("the kernel")])
}

fn options(defines: &[&str]) -> Options {
    Options {
        defines: (defines.iter())
            .map(|name| ((*name).to_owned(), "1".to_owned()))
            .collect(),
        ..Options::default()
    }
}

/// The words that a run writes, and the cycles of its loop on the array.
fn run(arch: &Arch, defines: &[&str], engine: Engine) -> (Vec<u8>, u64) {
    let session = Session::default();
    let compiled = compile(source(), arch, &options(defines), &session);
    let compiled = compiled.unwrap_or_else(|error| panic!("{error}"));
    let program = compiled.runnable().expect("it has a main");
    let engines = Engines::of(program, engine, &session).expect("it links");
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let mut finish = Finish::default();
    let mut core = engines.core();
    solo::run_until(
        core.as_mut(),
        &mut bus,
        1_000_000,
        session.watch,
        &mut finish,
    )
    .expect("it ends");
    let (number, _) = (program.kernels.iter())
        .find(|(_, k)| k.dfg.name == "filter")
        .expect("its loop is on the array");
    let number = srp_archdesc::entity::Entity::index(number) as u32;
    (bus.output, finish.kernels[&number])
}

/// What the intermediate form means, before or after the passes.
fn meaning(arch: &Arch, passes: bool) -> Vec<u8> {
    let Input::C(sources) = source() else {
        unreachable!("it is C")
    };
    let (mut program, _) = front_end(&sources, arch, &options(&[])).expect("it compiles");
    if passes {
        optimise(&mut program, arch, &options(&[]));
    }
    let layout = Layout::of(&program, arch.system.sram_bytes).expect("it fits");
    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    let main = program.main.expect("a main function");
    let ran = interp::run(
        &program,
        main,
        &[],
        &mut world,
        &interp::Options::new(&layout),
    );
    ran.unwrap_or_else(|trap| panic!("{}", trap.show(&program)));
    world.output
}

#[test]
fn every_engine_computes_the_same_halves() {
    let arch = machine("pair vpair");
    let expected = run(&arch, &[], Engine::Interpreter).0;
    assert_eq!(expected.len(), 4 * (8 + 128));
    assert_eq!(expected, run(&arch, &[], Engine::Generated).0);
    for passes in [false, true] {
        assert_eq!(expected, meaning(&arch, passes), "passes: {passes}");
    }
    if !has_host_compiler() {
        println!("skipped: no host compiler");
        return;
    }
    let folder = std::env::temp_dir().join(format!("srp-halves-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let built = Command::new("cc")
        .args(["-std=gnu11", "-O2", "-ffp-contract=off", "-fwrapv", "-w"])
        .arg("-I")
        .arg(root().join("kernels"))
        .arg(root().join("tests/precision/halves.c"))
        .args(["-lm", "-o", "host"])
        .current_dir(&folder)
        .output()
        .expect("cc runs");
    assert!(
        built.status.success(),
        "{}",
        String::from_utf8_lossy(&built.stderr)
    );
    let ran = Command::new(folder.join("host")).output().expect("it runs");
    std::fs::remove_dir_all(&folder).expect("removed");
    assert_eq!(ran.stdout, expected);
}

#[test]
fn pairs_halve_the_cycles_and_cost_area() {
    let (plain, pairs) = (machine(""), machine("pair"));
    let single = run(&plain, &["SINGLE"], Engine::Interpreter);
    let halves = run(&pairs, &[], Engine::Interpreter);
    let ratio = halves.1 as f64 / single.1 as f64;
    assert!((0.4..0.65).contains(&ratio), "{} {}", halves.1, single.1);
    // As near as eleven bits are.
    let floats = |bytes: &[u8]| -> Vec<f32> {
        let words = bytes.chunks_exact(4);
        words
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect()
    };
    for (a, b) in floats(&halves.0).into_iter().zip(floats(&single.0)) {
        assert!((a - b).abs() < 3e-3, "{a} {b}");
    }
    let area = |arch: &Arch| chip::srp(arch).total_mm2;
    assert!(area(&pairs) > area(&plain));
    assert!(area(&machine("pair vpair")) > area(&pairs));
}

#[test]
fn a_machine_without_pairs_refuses_them() {
    let refused = compile(source(), &machine(""), &options(&[]), &Session::default());
    let said = refused
        .err()
        .map(|error| error.to_string())
        .unwrap_or_default();
    assert!(
        said.contains("halves.c:") && said.contains("`pair`"),
        "{said}"
    );
}
