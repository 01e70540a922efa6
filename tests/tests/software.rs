//! Machines without units of a class: what needs its operations computes the same bits in software, on the array
//! too, and the report says so.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::isa::{Class, Kind, Opcode};
use srp_archdesc::machines::SGRT;
use srp_ir::pass::SOFTWARE;
use srp_kernels::libc;
use srp_tests::LITTLE;
use srp_tests::one_loop::{meaning, run};
use srp_toolchain::{Engine, Input, Options, compile};
use std::fmt::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// The machine without units of some classes.
fn machine(without: &[Class]) -> Arch {
    let lacks = |word: &str| without.iter().any(|class| class.name() == word);
    let mut xml = String::new();
    for line in SGRT.xml.lines() {
        match line.split_once("classes=\"") {
            Some((before, rest)) => {
                let (classes, after) = rest.split_once('"').expect("an attribute ends");
                let kept: Vec<&str> = classes.split(' ').filter(|c| !lacks(c)).collect();
                writeln!(xml, "{before}classes=\"{}\"{after}", kept.join(" ")).expect("text");
            }
            None => writeln!(xml, "{line}").expect("text"),
        }
    }
    srp_archdesc::parse("software.xml", &xml).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn all_classes() -> Vec<Class> {
    let classes = Class::ALL.iter().copied();
    classes.filter(|class| class.has_software()).collect()
}

/// Words that are hard for floats and integers alike.
const SPECIAL: [u32; 24] = [
    0,
    0x8000_0000,
    1,
    0x8000_0001,
    0x7f_ffff,
    0x80_0000,
    0x3f80_0000,
    0xbf80_0000,
    0x7f7f_ffff,
    0xff7f_ffff,
    0x7f80_0000,
    0xff80_0000,
    0x7fc0_0000,
    0x3f00_0000,
    0x4000_0000,
    0x4b00_0000,
    0x4f00_0000,
    0xcf00_0000,
    0x4f80_0000,
    0x3f7f_ffff,
    0x42fe_0000,
    0xc2fc_0000,
    0xffff_ffff,
    7,
];

fn operand(random: &mut Pcg64Mcg) -> u32 {
    let word = random.next_u32();
    match random.next_u32() % 5 {
        0 => SPECIAL[word as usize % SPECIAL.len()],
        // Floats near 1, and floats that cancel.
        1 => 0x3f80_0000 ^ (word & 0x8fff_ffff) >> 3,
        2 => 0x4048_0000 ^ (word & 0x8000_00ff),
        _ => word,
    }
}

/// An argument of this kind: the operands of case `i` from lane `lane` on.
fn argument(kind: Kind, operand: usize) -> String {
    let name = ["a", "b", "c"][operand];
    match kind {
        Kind::F => format!("number({name}[i])"),
        Kind::F4 => format!("srp_asfloat4(four({name}, i))"),
        Kind::I4 => format!("four({name}, i)"),
        _ => format!("{name}[i]"),
    }
}

/// A program that computes every operation that software stands in for on many operands, and prints the results.
fn operations(random: &mut Pcg64Mcg, cases: usize) -> String {
    let mut text = String::from("#include <srp.h>\n#include <stdio.h>\n");
    for name in ["a", "b", "c"] {
        let words: Vec<String> = (0..cases + 3)
            .map(|_| format!("{}u", operand(random)))
            .collect();
        writeln!(
            text,
            "volatile unsigned {name}[] = {{ {} }};",
            words.join(", ")
        )
        .expect("text");
    }
    text.push_str(
        "static float number(unsigned w) { union { unsigned w; float f; } x; x.w = w; return x.f; }
static void show(unsigned w) { for (int k = 28; k >= 0; k -= 4) putchar(\"0123456789abcdef\"[w >> k & 15]); }
static void word(float f) { union { float f; unsigned w; } x; x.f = f; show(x.w); }
static int4 four(volatile unsigned *a, int i) { return (int4){ a[i], a[i + 1], a[i + 2], a[i + 3] }; }
static void vector(int4 v) { for (int k = 0; k < 4; k++) show(v[k]); }
int main(void)
{
",
    );
    writeln!(text, "    for (int i = 0; i < {cases}; i++) {{").expect("text");
    for &op in Opcode::ALL.iter().filter(|op| op.class().has_software()) {
        let info = op.info();
        // The guard of a division is C's.
        let kinds = info.operands.iter().filter(|&&kind| kind != Kind::P);
        let args: Vec<String> = kinds.enumerate().map(|(n, &k)| argument(k, n)).collect();
        let value = match op {
            Opcode::Div => "(b[i] ? (int)a[i] / (int)b[i] : 0)".to_owned(),
            Opcode::Rem => "(b[i] ? (int)a[i] % (int)b[i] : 0)".to_owned(),
            Opcode::Divu => "(b[i] ? a[i] / b[i] : 0)".to_owned(),
            Opcode::Remu => "(b[i] ? a[i] % b[i] : 0)".to_owned(),
            _ => format!("__srp_{}({})", op.name(), args.join(", ")),
        };
        let show = match info.result {
            Some(Kind::F) => format!("word({value})"),
            Some(Kind::F4) => format!("vector(srp_bits4({value}))"),
            Some(Kind::I4) => format!("vector({value})"),
            _ => format!("show({value})"),
        };
        writeln!(
            text,
            "        printf(\"%d {op} \", i); {show}; putchar(10);"
        )
        .expect("text");
    }
    text.push_str("    }\n    return 0;\n}\n");
    text
}

fn input(text: &str) -> Input {
    Input::C(vec![Source::new("software.c", text)])
}

fn printed(text: &str, arch: &Arch) -> String {
    let bytes = meaning(input(text), arch, &Options::default(), true);
    String::from_utf8(bytes).expect("text")
}

fn number(variable: &str, default: u64) -> u64 {
    let given = std::env::var(variable).ok();
    given.map_or(default, |text| text.parse().expect(variable))
}

#[test]
fn software_computes_what_units_compute() {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let seed = number("SRP_RANDOM_SEED", now.map_or(0, |t| t.as_nanos() as u64));
    println!("SRP_RANDOM_SEED={seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let all = all_classes();
    // Quotients by powers of two are products, so dividers need multipliers beside them.
    let alone = all.iter().map(|class| match class {
        Class::Fmul => vec![Class::Fmul, Class::Fdiv],
        class => vec![*class],
    });
    let machines: Vec<Vec<Class>> = alone.chain([all.clone()]).collect();
    for without in machines {
        let cases = number(
            "SRP_SOFTWARE_CASES",
            if without.len() > 1 { 300 } else { 20 },
        );
        let text = operations(&mut random, cases as usize);
        let (by_units, by_software) = (
            printed(&text, &machine(&[])),
            printed(&text, &machine(&without)),
        );
        let lines = by_units.lines().zip(by_software.lines());
        for (expected, found) in lines {
            assert_eq!(found, expected, "without {without:?}, seed {seed}");
        }
        assert_eq!(by_units.lines().count(), by_software.lines().count());
    }
}

const LOOP: &str = "
#include <srp.h>
#include <stdio.h>
float in[64], out[64];
void divide(void) {
    for (int i = 0; i < 64; i++) out[i] = in[i] / (in[i] + 3.0f);
}
int main(void) {
    for (int i = 0; i < 64; i++) in[i] = (float)i * 0.37f;
    divide();
    for (int i = 0; i < 64; i++) {
        union { float f; unsigned w; } x;
        x.f = out[i];
        for (int k = 0; k < 32; k += 8) putchar(x.w >> k);
    }
    return 0;
}
";

#[test]
fn loops_with_software_run_on_the_array_and_say_so() {
    let session = srp_tests::session();
    // What the loops compute does not depend on how low their IIs are.
    let options = Options {
        effort: LITTLE,
        ..Options::default()
    };
    let ran = |without: &[Class], engine| {
        run(
            input(LOOP),
            &machine(without),
            &options,
            engine,
            &session,
            "divide",
        )
    };
    let units = ran(&[], Engine::Interpreter);
    let divisions = [Class::Idiv, Class::Fdiv];
    for without in [&divisions[..], &all_classes()] {
        let software = ran(without, Engine::Interpreter);
        assert_eq!(software.output, units.output, "without {without:?}");
        assert!(
            software.ii > units.ii,
            "software costs, without {without:?}"
        );
    }
    assert_eq!(ran(&divisions, Engine::Generated).output, units.output);

    let compiled = compile(input(LOOP), &machine(&divisions), &options, &session);
    let compiled = compiled.unwrap_or_else(|error| panic!("{error}"));
    let told: Vec<&str> = (compiled.pass_remarks.iter())
        .filter(|remark| remark.pass == SOFTWARE)
        .map(|remark| remark.message.as_str())
        .collect();
    let text = "no unit runs class `fdiv`, so divide computes in software: `fdiv` 1×";
    assert!(told.contains(&text), "{told:?}");
    let files = &compiled.schedule.program.files;
    let from_library = compiled.schedule.program.kernels.values().any(|kernel| {
        let mut nodes = kernel.dfg.nodes.values();
        nodes.any(|node| files[node.pos.file] == libc::SOFTWARE)
    });
    assert!(from_library, "its operations are those of the library");
}
