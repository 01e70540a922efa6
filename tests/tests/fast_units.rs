//! Machines with two units for reciprocal, roots and quotient: every engine computes the same bits, and the
//! fast units' bits show in initiation interval, cycles, area, energy and error. The table is
//! `tests/precision/fast.txt`; `BLESS=1` writes it anew.

use srp_archdesc::Arch;
use srp_archdesc::chip;
use srp_archdesc::diagnostic::{Severity, Source};
use srp_archdesc::isa::Opcode;
use srp_archdesc::machines::SGRT;
use srp_ir::program::{InstKind, Program};
use srp_tests::one_loop::{Ran, meaning, run};
use srp_tests::root;
use srp_toolchain::{Engine, Error, Input, Options, files, front_end};
use std::fmt::Write as _;

const KERNELS: [&str; 4] = ["normalise", "project", "ratio", "mean"];
const FAST: [&str; 4] = ["rcp_fast", "rsqrt_fast", "sqrt_fast", "div_fast"];

/// The machine that comes along, with fast units of so many bits beside the ordinary ones.
fn machine(bits: u32) -> Arch {
    let units = FAST.map(|name| format!("<special function=\"{name}\" bits=\"{bits}\"/>"));
    let xml = SGRT
        .xml
        .replace("<array rows", &(units.concat() + "<array rows"));
    let xml = xml.replace("fdiv sfu cvt", "fdiv sfu fast cvt");
    srp_archdesc::parse("fast.xml", &xml).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn plain() -> Arch {
    srp_archdesc::parse("sgrt.xml", SGRT.xml).expect("it is shipped")
}

/// How a kernel is compiled where pragmas ask for so many bits.
fn options(kernel: &str, asked: u32) -> Options {
    let define = |name: &str, value: String| (name.to_owned(), value);
    Options {
        defines: vec![
            define("RUN", kernel.to_owned()),
            define("BITS", asked.to_string()),
        ],
        ..Options::default()
    }
}

fn source() -> Input {
    let path = root().join("tests/precision/fast.c");
    Input::C(vec![
        files::read_source(&path, files::Kind::Source).expect("the kernels"),
    ])
}

fn ran(kernel: &str, arch: &Arch, asked: u32, engine: Engine) -> Ran {
    let session = srp_tests::session();
    run(
        source(),
        arch,
        &options(kernel, asked),
        engine,
        &session,
        kernel,
    )
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    let words = bytes.chunks_exact(4);
    words
        .map(|b| f32::from_le_bytes(b.try_into().expect("four bytes")))
        .collect()
}

/// The largest error in units in the last place of what exact units give.
fn ulps(found: &[u8], exact: &[u8]) -> f64 {
    let pairs = floats(found).into_iter().zip(floats(exact));
    let errors = pairs.map(|(found, exact)| {
        let place = 2f64.powi(f64::from(exact).abs().log2().floor() as i32 - 23);
        (f64::from(found) - f64::from(exact)).abs() / place
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn every_engine_computes_the_same_bits() {
    for (bits, asked) in [(8, 8), (14, 24)] {
        let arch = machine(bits);
        for kernel in KERNELS {
            let expected = ran(kernel, &arch, asked, Engine::Interpreter).output;
            assert_eq!(expected.len(), 4 * 96, "{kernel}");
            for passes in [false, true] {
                let meant = meaning(source(), &arch, &options(kernel, asked), passes);
                assert!(expected == meant, "{kernel}, {bits} bits, passes: {passes}");
            }
            let generated = ran(kernel, &arch, asked, Engine::Generated).output;
            assert!(expected == generated, "{kernel}, {bits} bits, generated");
        }
    }
}

#[test]
fn bits_of_the_fast_unit_move_every_figure() {
    let mut table = String::from(
        "bits of the fast units; cycles (II) and error in ulp of each loop; area of the SRP; energy of a reciprocal\n",
    );
    let _ = write!(table, "{:8}", "fast");
    KERNELS.iter().for_each(|kernel| {
        let _ = write!(table, "{kernel:>26}");
    });
    table.push_str("        mm²       pJ\n");
    let exact: Vec<Vec<u8>> = KERNELS
        .iter()
        .map(|kernel| ran(kernel, &plain(), 24, Engine::Interpreter).output)
        .collect();
    let mut last: Option<(f64, f64)> = None;
    let mut first_ulps = None;
    for bits in [0, 6, 10, 14, 18] {
        let arch = match bits {
            0 => plain(),
            bits => machine(bits),
        };
        let name = match bits {
            0 => "none".to_owned(),
            bits => bits.to_string(),
        };
        let _ = write!(table, "{name:8}");
        let mut all = Vec::new();
        for (kernel, exact) in KERNELS.iter().zip(&exact) {
            let ran = ran(kernel, &arch, bits.max(1), Engine::Interpreter);
            let off = ulps(&ran.output, exact);
            let cell = format!("{} ({}) {off:.1}", ran.cycles, ran.ii);
            let _ = write!(table, "{cell:>26}");
            all.push(off);
        }
        let area = chip::srp(&arch).total_mm2;
        let energy = chip::operation_energy(Opcode::RcpFast, &arch);
        let _ = writeln!(table, "{area:>11.4}{energy:>9.2}");
        if bits > 0 {
            if let Some(last) = last {
                assert!(area > last.0 && energy > last.1, "{bits} bits");
            }
            last = Some((area, energy));
            if let Some(before) = first_ulps.replace(all.clone()) {
                let pairs = all.iter().zip(&before);
                assert!(
                    pairs.into_iter().all(|(now, before)| now < before),
                    "{bits} bits"
                );
            }
        }
    }
    let path = root().join("tests/precision/fast.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &table).expect("the table can be written");
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(table, golden);
}

/// How often a program has an operation.
fn count(program: &Program, wanted: Opcode) -> usize {
    let insts = program.funcs.values().flat_map(|func| {
        let insts = func
            .layout
            .iter()
            .flat_map(|&block| &func.blocks[block].insts);
        insts.map(|&inst| &func.insts[inst].kind)
    });
    insts
        .filter(|kind| matches!(kind, InstKind::Op { op, .. } if *op == wanted))
        .count()
}

/// The program of a source before the passes, and the messages about it.
fn front(text: &str, arch: &Arch, options: &Options) -> Result<(Program, Vec<String>), String> {
    let text = format!("#include \"srp.h\"\n{text}");
    let sources = [Source::new("case.c", text.as_str())];
    match front_end(&sources, arch, options) {
        Ok((program, messages)) => {
            let notes = messages.diagnostics.iter();
            let notes = notes.filter(|m| m.severity == Severity::Note);
            Ok((program, notes.map(|m| m.message.clone()).collect()))
        }
        Err(Error::Messages(messages)) => {
            let first = &messages.diagnostics[0];
            let help = first.help.clone();
            Err(format!("{} / {help:?}", first.message))
        }
        Err(error) => panic!("{error}"),
    }
}

const LOOPS: &str = "
float a[8], b[8];
static float helper(float x) { return 1.0f / x + x / 4.0f; }
int main(void) {
#pragma srp precision(div, ASKED)
    for (int i = 0; i < 8; i++) {
        a[i] = helper(b[i]);
#pragma srp precision(div, 24)
        for (int k = 0; k < 3; k++) a[i] += b[i] / a[i];
    }
    for (int i = 0; i < 8; i++) b[i] = helper(a[i]);
    return 0;
}";

#[test]
fn pragmas_hold_for_their_loops_and_what_these_call() {
    let arch = machine(12);
    let options = Options::default();
    let asked = |bits: &str| LOOPS.replace("ASKED", bits);
    let (program, notes) = front(&asked("12"), &arch, &options).expect("it compiles");
    // One in the copy for the loop; those of the helper itself and of the inner loop are exact, and a
    // quotient by 4 becomes a product in both.
    assert_eq!(count(&program, Opcode::FdivFast), 1);
    assert_eq!(count(&program, Opcode::Fdiv), 4);
    assert_eq!(notes, [""; 0]);
    let (program, _) = front(&asked("13"), &arch, &options).expect("it compiles");
    assert_eq!(count(&program, Opcode::FdivFast), 0);
    // On a machine whose ordinary unit is coarser than asked for, there is none.
    let mut coarse = machine(12);
    coarse.precision.div = srp_archdesc::arch::Approx::table(14, 0);
    coarse.derive_cycles();
    assert_eq!(
        front(&asked("15"), &coarse, &options).err().as_deref(),
        Some(
            "no unit of the machine computes `div` to 15 bits / \
             Some(\"it has `fdiv_fast` to 12 and `fdiv` to 14\")"
        )
    );
}

#[test]
fn a_stated_error_chooses_the_cheapest_unit() {
    let arch = machine(12);
    let text = LOOPS.replace("ASKED", "24");
    let with = |max_ulp| Options {
        max_ulp,
        ..Options::default()
    };
    let fast = |max_ulp| {
        let (program, _) = front(&text, &arch, &with(max_ulp)).expect("it compiles");
        count(&program, Opcode::FdivFast)
    };
    // Two to the power of 12 units, and one of rounding; only the helper of the last loop is free.
    assert_eq!(fast(None), 0);
    assert_eq!(fast(Some(4096.0)), 0);
    assert_eq!(fast(Some(4097.0)), 1);
}

#[test]
fn without_a_fast_unit_the_ordinary_one_computes_it() {
    let text = "float x, y; int main(void) { x = srp_rcp_fast(y) + srp_div_fast(x, y); return 0; }";
    let options = Options::default();
    let (program, notes) = front(text, &plain(), &options).expect("it compiles");
    assert_eq!(
        notes,
        [
            "the machine has no unit for `rcp_fast`: its `rcp` computes this",
            "the machine has no unit for `fdiv_fast`: its `fdiv` computes this"
        ]
    );
    assert_eq!(
        (count(&program, Opcode::Rcp), count(&program, Opcode::Fdiv)),
        (1, 1)
    );
    let (program, notes) = front(text, &machine(10), &options).expect("it compiles");
    assert_eq!(notes, [""; 0]);
    assert_eq!(
        (
            count(&program, Opcode::RcpFast),
            count(&program, Opcode::FdivFast)
        ),
        (1, 1)
    );
}
