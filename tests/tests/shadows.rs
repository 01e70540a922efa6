//! Shadows of programs whose errors are known.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::arch::{Approx, Fast, Precision};
use srp_archdesc::choice::Choices;
use srp_archdesc::diagnostic::Source;
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile};
use srp_ir::interp::{self, Code, FlatWorld, SYSTEM_BASE};
use srp_ir::layout::Layout;
use srp_ir::shadow::tape::{Contributions, Sweep};
use srp_ir::shadow::{Decision, Shadows, Sources};
use srp_ir::{Program, pass};
use std::fmt::Write;

/// Bytes of the SRAM.
const SRAM: u32 = 1 << 16;

/// Where results go, in words behind the first of system memory; before them are the inputs.
const RESULTS: u32 = 64;

/// A program around some lines, which find their numbers in `in` and leave others in `out`.
fn program(lines: &str) -> Program {
    let text = format!(
        "#include \"srp.h\"\n\
         #define in ((SRP_GLOBAL const float *)0x80000000u)\n\
         #define out ((SRP_GLOBAL float *)0x80000100u)\n\
         int main(void) {{\n{lines}\nreturn 0; }}\n"
    );
    let header = |name: &str| std::fs::read_to_string(srp_tests::root().join("kernels").join(name));
    let resolve =
        |include: &Include<'_>| Some(Source::new(include.name, header(include.name).ok()?));
    let options = Options {
        resolve: &|include| resolve(include).into(),
        auto_kernel: false,
        ..Options::default()
    };
    let compiled = compile(&[Source::new("case.c", text.as_str())], &options);
    let shown = |_: &str| Some(text.clone());
    let (mut program, _) = compiled.unwrap_or_else(|messages| {
        panic!("{}", render_all(&messages, &shown, false));
    });
    pass::optimise(&mut program, &pass::Options::new(Precision::EXACT));
    program
}

/// A result: its value, its error, and what each source contributes, by line and operation.
struct Found {
    value: f32,
    error: f64,
    contributions: Vec<(u32, String, f64)>,
}

/// Returns the results of a run of a program, and the lines on which decisions flip.
fn run(
    program: &Program,
    inputs: &[f32],
    results: u32,
    precision: Precision,
) -> (Vec<Found>, Vec<(Decision, u32)>) {
    let layout = Layout::of(program, SRAM).expect("it fits");
    let mut world = FlatWorld::new(&layout, SRAM);
    world.memory = inputs.iter().flat_map(|x| x.to_le_bytes()).collect();
    world.memory.resize(4 * (RESULTS + results) as usize, 0);
    let sources = Sources::of(program, &[]);
    let mut shadows = Shadows::new(&sources, SRAM, precision.texture_weight_bits);
    let options = interp::Options {
        precision,
        ..interp::Options::new(&layout)
    };
    let main = program.main.expect("a main function");
    let code = Code::of(program, &layout);
    let ran = interp::run_observed(&code, main, &[], &mut world, &mut shadows, &options);
    ran.unwrap_or_else(|trap| panic!("{}", trap.show(program)));
    let place = |source: u32| {
        let source = sources.get(source).expect("a source");
        (
            source.at.map_or(0, |(_, line)| line),
            source.what.to_string(),
        )
    };
    let found = found(&shadows, &world, results, &place);
    let flips = shadows.flips.iter();
    let flips = flips
        .map(|flip| (flip.decision, place(flip.source).0))
        .collect();
    // Contributions that are known without the history are the same.
    let before: Vec<_> = found.iter().map(|found| &found.contributions).collect();
    shadows.collapse(Vec::new());
    let after = self::found(&shadows, &world, results, &place);
    assert!(after.iter().map(|found| &found.contributions).eq(before));
    (found, flips)
}

/// Returns the results, with their errors and contributions.
fn found(
    shadows: &Shadows<'_>,
    world: &FlatWorld,
    results: u32,
    place: &dyn Fn(u32) -> (u32, String),
) -> Vec<Found> {
    let (mut sweep, mut contributions) = (Sweep::default(), Contributions::default());
    let mut found = Vec::new();
    for i in 0..results {
        let at = 4 * (RESULTS + i);
        let node = shadows.written_node(SYSTEM_BASE + at);
        contributions.collect(&mut sweep, &shadows.tape, &[(node, [1.0, 0.0, 0.0])]);
        let bytes = &world.memory[at as usize..at as usize + 4];
        found.push(Found {
            value: f32::from_le_bytes(bytes.try_into().expect("4 bytes")),
            error: shadows.tape.error(node),
            contributions: contributions
                .sources
                .iter()
                .map(|&source| {
                    let (line, what) = place(source);
                    (line, what, contributions.of(source)[0])
                })
                .filter(|(.., error)| *error != 0.0)
                .collect(),
        });
    }
    found
}

/// The line, behind the four of the frame, and the operation that contributes most.
fn worst(found: &Found) -> (u32, &str) {
    let by_size =
        |a: &&(u32, String, f64), b: &&(u32, String, f64)| a.2.abs().total_cmp(&b.2.abs());
    let worst = found.contributions.iter().max_by(by_size);
    worst.map_or((0, ""), |(line, what, _)| (line - 4, what))
}

#[test]
fn what_a_sum_has_lost_is_the_sums() {
    let program = program("float sum = in[0] + in[1];\nfloat left = sum - in[0];\nout[0] = left;");
    let (found, flips) = run(&program, &[16_777_216.0, 1.0], 1, Precision::EXACT);
    assert_eq!((found[0].value, found[0].error), (0.0, -1.0));
    assert_eq!(worst(&found[0]), (1, "fadd"));
    assert_eq!(flips, []);
}

#[test]
fn cancellation_shows_what_was_rounded_before() {
    // a a - b: the product is rounded, and nothing else.
    let a = 1.0 + f32::EPSILON;
    let program =
        program("float square = in[0] * in[0];\nfloat rest = square - in[1];\nout[0] = rest;");
    let (found, _) = run(&program, &[a, a * a], 1, Precision::EXACT);
    let exact = f64::from(a) * f64::from(a) - f64::from(a * a);
    assert!(exact != 0.0 && found[0].value == 0.0);
    assert_eq!(found[0].error, -exact);
    assert_eq!(found[0].contributions, [(5, "fmul".to_owned(), -exact)]);
}

#[test]
fn a_coarse_unit_is_named() {
    let lines = "float x = in[0] * in[1];\nfloat y = srp_rcp(x);\n\
                 out[0] = y * in[2];\nout[1] = srp_sqrt(y) + in[3];";
    let program = program(lines);
    let precision = Precision {
        rcp: Approx::table(12, 0),
        ..Precision::EXACT
    };
    let (found, _) = run(&program, &[1.7, 2.9, 3.3, 5.1], 2, precision);
    assert_eq!(worst(&found[0]), (2, "rcp"));
    assert_eq!(worst(&found[1]), (2, "rcp"));
    let exact = 1.0 / (f64::from(1.7f32) * f64::from(2.9f32)) * f64::from(3.3f32);
    let error = f64::from(found[0].value) - exact;
    assert!(
        (found[0].error - error).abs() < 1e-15,
        "{} {error}",
        found[0].error
    );
}

#[test]
fn a_fast_unit_is_named() {
    let lines = "float x = in[0] * in[1];\nout[0] = srp_rcp_fast(x) + srp_sqrt(x);";
    let text = format!(
        "#include \"srp.h\"\n#define in ((SRP_GLOBAL const float *)0x80000000u)\n\
         #define out ((SRP_GLOBAL float *)0x80000100u)\nint main(void) {{\n{lines}\nreturn 0; }}\n"
    );
    let header = |name: &str| std::fs::read_to_string(srp_tests::root().join("kernels").join(name));
    let precision = Precision {
        fast: Fast {
            rcp: Some(Approx::table(6, 0)),
            ..Fast::default()
        },
        ..Precision::EXACT
    };
    let mut arch = srp_archdesc::parse("sgrt", srp_archdesc::machines::SGRT.xml).expect("shipped");
    arch.precision = precision;
    let options = Options {
        resolve: &|include| {
            let text = header(include.name).ok();
            text.map(|text| Source::new(include.name, text)).into()
        },
        auto_kernel: false,
        choices: Choices::of(&arch),
        ..Options::default()
    };
    let compiled = compile(&[Source::new("case.c", text.as_str())], &options);
    let (mut program, _) = compiled.expect("it is C");
    pass::optimise(&mut program, &pass::Options::new(precision));
    let (found, _) = run(&program, &[1.7, 2.9], 1, precision);
    assert_eq!(worst(&found[0]), (2, "rcp_fast"));
}

#[test]
fn a_decision_is_a_flip_when_something_comes_of_it() {
    // The product, in binary32, is b; in fact it is more.
    let a = 1.0 + 3.0 * f32::EPSILON;
    let b = a * a;
    assert!(f64::from(a) * f64::from(a) > f64::from(b));
    let lines = "float square = in[0] * in[0];\n\
                 int more = square > in[1];\n\
                 out[0] = srp_select(more, in[2], in[3]);";
    let (_, flips) = run(&program(lines), &[a, b, 1.0, 2.0], 1, Precision::EXACT);
    assert_eq!(flips, [(Decision::Comparison, 6)]);
    // Where both sides are the same, nothing does.
    let (_, flips) = run(&program(lines), &[a, b, 1.0, 1.0], 1, Precision::EXACT);
    assert_eq!(flips, []);
    let branches = "float square = in[0] * in[0];\nif (square > in[1])\n\
                    out[0] = srp_sin(in[2]);\nelse\nout[1] = 1.0f;";
    let (_, flips) = run(&program(branches), &[a, b, 1.0], 2, Precision::EXACT);
    assert_eq!(flips, [(Decision::Comparison, 6)]);
}

#[test]
fn a_float_that_becomes_another_integer_is_a_flip() {
    let lines = "float x = in[0] * in[1];\nint i = srp_ftoi(x);\nout[0] = in[i];";
    let program = program(lines);
    // 1/n · n is 1 in binary32, and in fact less, or not.
    let less = |n: &f32| f64::from(1.0 / n) * f64::from(*n) < 1.0;
    let numbers = (3..100u8).map(f32::from).filter(|n| 1.0 / n * n == 1.0);
    let (below, above): (Vec<f32>, Vec<f32>) = numbers.partition(less);
    let flips = |n: f32| run(&program, &[1.0 / n, n, 2.0], 1, Precision::EXACT).1;
    assert_eq!(flips(below[0]), [(Decision::Integer, 6)]);
    assert_eq!(flips(above[0]), []);
}

/// A float that is taken apart as an integer and put together otherwise is itself times a power of two.
#[test]
fn another_exponent_keeps_the_error() {
    let lines = "float x = in[0] * in[1];\nunsigned bits = srp_bits(x);\n\
                 out[0] = srp_float(bits & 0x7fffffu | 0x3f800000u);\n\
                 out[1] = srp_float(bits + (5u << 23));\n\
                 out[2] = srp_float(0x40000000u);\n\
                 out[3] = srp_float(bits ^ 0x80000000u);";
    let inputs = [13.7f32, 0.9];
    let (found, flips) = run(&program(lines), &inputs, 4, Precision::EXACT);
    let product = inputs[0] * inputs[1];
    let error = f64::from(product) - f64::from(inputs[0]) * f64::from(inputs[1]);
    assert!(error != 0.0);
    let errors: Vec<f64> = found.iter().map(|found| found.error).collect();
    assert_eq!(errors, [error / 8.0, error * 32.0, 0.0, -error]);
    assert_eq!(flips, []);
}

/// Rounding to bfloat16 by integer operations is an error of theirs, and places that are added are none.
#[test]
fn places_are_rounded_off_or_added() {
    let lines = "float x = in[0] * in[1];\nunsigned bits = srp_bits(x);\n\
                 unsigned odd = bits >> 16 & 1u;\n\
                 float half = srp_float((bits + odd + 0x7fffu) & 0xffff0000u);\n\
                 out[0] = half + 1.0f;\n\
                 out[1] = srp_float(bits + 256u);";
    let inputs = [13.7f32, 0.9];
    let (found, _) = run(&program(lines), &inputs, 2, Precision::EXACT);
    let exact = f64::from(inputs[0]) * f64::from(inputs[1]);
    assert!((found[0].error - (f64::from(found[0].value) - (exact + 1.0))).abs() < 1e-15);
    assert!(found[0].error.abs() > 1e-3);
    assert_eq!(worst(&found[0]), (4, "and"));
    let before = f64::from(inputs[0] * inputs[1]) - exact;
    assert!(before != 0.0 && (found[1].error - before).abs() < 1e-14);
}

/// A random program of float operations, and what it gives in binary64.
struct Random {
    lines: String,
    exact: Vec<f64>,
}

fn random(rng: &mut Pcg64Mcg, inputs: &[f32]) -> Random {
    let mut lines = String::new();
    let mut exact: Vec<f64> = inputs.iter().map(|&x| f64::from(x)).collect();
    for i in 0..inputs.len() {
        write!(lines, "float v{i} = in[{i}];").expect("a string takes everything");
    }
    for i in inputs.len()..inputs.len() + 40 {
        let mut pick = || rng.next_u32() as usize % i;
        let (a, b, c) = (pick(), pick(), pick());
        let (x, y, z) = (exact[a], exact[b], exact[c]);
        let (text, value) = match rng.next_u32() % 10 {
            0 => (format!("v{a} + v{b}"), x + y),
            1 => (format!("v{a} - v{b}"), x - y),
            2 => (format!("0.5f * v{a} * v{b}"), 0.5 * x * y),
            3 => (format!("srp_fma(v{a}, 0.25f, v{c})"), x * 0.25 + z),
            4 => (format!("srp_rcp(v{a} * v{a} + 1.0f)"), 1.0 / (x * x + 1.0)),
            5 => (
                format!("srp_rsqrt(srp_fabs(v{a}) + 0.5f)"),
                (x.abs() + 0.5).sqrt().recip(),
            ),
            6 => (
                format!("srp_sqrt(v{a} * v{a} + 0.125f)"),
                (x * x + 0.125).sqrt(),
            ),
            7 => (
                format!("srp_fmin(v{a}, srp_fmax(v{b}, -v{c}))"),
                x.min(y.max(-z)),
            ),
            8 => (format!("srp_sin(v{a}) - srp_cos(v{b})"), x.sin() - y.cos()),
            _ => (
                format!("srp_exp2(srp_sin(v{a})) / srp_log2(srp_fabs(v{b}) + 2.0f)"),
                x.sin().exp2() / (y.abs() + 2.0).log2(),
            ),
        };
        write!(lines, "\nfloat v{i} = {text};").expect("a string takes everything");
        exact.push(value);
    }
    for i in 0..exact.len() - inputs.len() {
        write!(lines, "\nout[{i}] = v{};", i + inputs.len()).expect("a string takes everything");
    }
    let exact = exact.split_off(inputs.len());
    Random { lines, exact }
}

#[test]
fn contributions_add_up_to_the_error_of_random_programs() {
    let mut rng = Pcg64Mcg::seed_from_u64(0x5ad0);
    let mut compared = 0;
    for _ in 0..60 {
        let inputs: [f32; 6] = std::array::from_fn(|_| rng.next_u32() as f32 / 1e9 - 2.0);
        let case = random(&mut rng, &inputs);
        let results = case.exact.len() as u32;
        let (found, flips) = run(&program(&case.lines), &inputs, results, Precision::EXACT);
        assert_eq!(flips, []);
        let mut largest = 1.0f64;
        for (found, exact) in found.iter().zip(&case.exact) {
            largest = largest.max(exact.abs());
            if largest > 1e6 {
                break;
            }
            let shadow = f64::from(found.value) - found.error;
            assert!(
                (shadow - exact).abs() <= 1e-9 * largest,
                "{shadow} {exact}\n{}",
                case.lines
            );
            let sum: f64 = found.contributions.iter().map(|(.., error)| error).sum();
            let size: f64 = found
                .contributions
                .iter()
                .map(|(.., error)| error.abs())
                .sum();
            assert!(
                (sum - found.error).abs() <= 1e-9 * size,
                "{sum} {}\n{}",
                found.error,
                case.lines
            );
            compared += usize::from(found.error != 0.0);
        }
    }
    assert!(compared > 500, "{compared}");
}
