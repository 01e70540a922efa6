//! Halves by pairs in a word: every engine and the host's compiler compute the same bits, a loop takes half as many
//! cycles, and a machine pays for the units in area.

use srp_archdesc::Arch;
use srp_archdesc::chip;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::machines::SGRT;
use srp_tests::one_loop::{Ran, meaning, run};
use srp_tests::{has_host_compiler, root};
use srp_toolchain::{Engine, Input, Options, compile, files};
use std::process::Command;

fn machine(classes: &str) -> Arch {
    let xml = SGRT
        .xml
        .replace("vfma vdot", &format!("vfma vdot {classes}"));
    srp_archdesc::parse("pairs.xml", &xml).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn source() -> Input {
    let path = root().join("tests/precision/halves.c");
    Input::C(vec![
        files::read_source(&path, files::Kind::Source).expect("the kernel"),
    ])
}

fn options(defines: &[&str]) -> Options {
    Options {
        defines: (defines.iter())
            .map(|name| ((*name).to_owned(), "1".to_owned()))
            .collect(),
        ..Options::default()
    }
}

fn ran(arch: &Arch, defines: &[&str], engine: Engine) -> Ran {
    let session = srp_tests::session();
    run(
        source(),
        arch,
        &options(defines),
        engine,
        &session,
        "filter",
    )
}

#[test]
fn every_engine_computes_the_same_halves() {
    let arch = machine("pair vpair");
    let expected = ran(&arch, &[], Engine::Interpreter).output;
    assert_eq!(expected.len(), 4 * (8 + 128));
    assert_eq!(expected, ran(&arch, &[], Engine::Generated).output);
    for passes in [false, true] {
        assert_eq!(
            expected,
            meaning(source(), &arch, &options(&[]), passes),
            "passes: {passes}"
        );
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

/// Where subnormal floats are flushed, a pair is none, though its bits may be those of one.
#[test]
fn pairs_are_not_flushed() {
    let xml = SGRT.xml.replace("vfma vdot", "vfma vdot pair vpair");
    let flushing = "  <float subnormals=\"flush\"/>\n  <fu-type ";
    let xml = xml.replacen("  <fu-type ", flushing, 1);
    let arch = srp_archdesc::parse("flush.xml", &xml).unwrap_or_else(|e| panic!("{e:?}"));
    let source = || Input::C(vec![Source::new("pairs.c", PAIRS)]);
    // The lower half is −∞, which a zero in place of the word would not have.
    let expected = 0x8000_fc00_u32.to_le_bytes().repeat(64);
    assert_eq!(meaning(source(), &arch, &options(&[]), false), expected);
    let session = srp_tests::session();
    for engine in [Engine::Interpreter, Engine::Generated] {
        let ran = run(source(), &arch, &options(&[]), engine, &session, "pack");
        assert_eq!(ran.output, expected, "{engine:?}");
    }
}

/// Pairs of −∞ and a zero below all halves.
const PAIRS: &str = "
#include \"srp.h\"

float low[64], high[64];
unsigned pairs[64];

static void pack(void)
{
#pragma srp kernel
    for (int i = 0; i < 64; i++)
        pairs[i] = srp_floats2half2(low[i], high[i]);
}

int main(void)
{
    for (int i = 0; i < 64; i++) {
        low[i] = -1.0e16f;
        high[i] = -1.0e-20f;
    }
    pack();
    for (int i = 0; i < 64; i++)
        for (int k = 0; k < 4; k++)
            srp_out(SRP_PORT_PUTCHAR, pairs[i] >> 8 * k & 255);
    return 0;
}
";

#[test]
fn pairs_halve_the_cycles_and_cost_area() {
    let (plain, pairs) = (machine(""), machine("pair"));
    let single = ran(&plain, &["SINGLE"], Engine::Interpreter);
    let halves = ran(&pairs, &[], Engine::Interpreter);
    let ratio = halves.cycles as f64 / single.cycles as f64;
    assert!(
        (0.4..0.65).contains(&ratio),
        "{} {}",
        halves.cycles,
        single.cycles
    );
    // As near as eleven bits are.
    let floats = |bytes: &[u8]| -> Vec<f32> {
        let words = bytes.chunks_exact(4);
        words
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect()
    };
    for (a, b) in floats(&halves.output)
        .into_iter()
        .zip(floats(&single.output))
    {
        assert!((a - b).abs() < 3e-3, "{a} {b}");
    }
    let area = |arch: &Arch| chip::srp(arch).total_mm2;
    assert!(area(&pairs) > area(&plain));
    assert!(area(&machine("pair vpair")) > area(&pairs));
}

#[test]
fn a_machine_without_pairs_refuses_them() {
    let refused = compile(source(), &machine(""), &options(&[]), &srp_tests::session());
    let said = refused
        .err()
        .map(|error| error.to_string())
        .unwrap_or_default();
    assert!(
        said.contains("halves.c:") && said.contains("`pair`"),
        "{said}"
    );
}
