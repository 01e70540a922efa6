//! The functions of `float` in `kernels/libc/math.c` against binary64, which is right to far less than a
//! unit of their last place. The bounds are those that `math.c` states.
//!
//! `SRP_VECTORS` says how many operands each function is tried on.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::Arch;
use srp_archdesc::precision::{Approx, Refine};
use srp_archdesc::structure::Structure;
use srp_ir::dre;
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_tests::{compiled, machine, root};

/// A function: its name, the largest error in units of the last place, its value in binary64, and the source
/// of its operands.
struct Function {
    name: &'static str,
    bound: f64,
    value: fn(f64, f64) -> f64,
    operands: fn(&mut Pcg32) -> (f32, f32),
}

/// Any bits of a positive number; any number up to a limit; one next to 1.
fn any(from: &mut Pcg32) -> f32 {
    f32::from_bits(from.next_u32() % 0x7f80_0000)
}

fn signed(from: &mut Pcg32) -> f32 {
    let x = any(from);
    if from.next_u32() & 1 == 0 { x } else { -x }
}

fn up_to(from: &mut Pcg32, limit: f32) -> f32 {
    // Many exponents, the largest most often.
    let fraction = from.next_u32() as i32 as f32 / 2_147_483_648.0;
    let tiny = 2f32.powi(-((from.next_u32() % 64) as i32).max(32) + 32);
    limit * fraction * tiny
}

fn near_one(from: &mut Pcg32) -> f32 {
    f32::from_bits(0x3f00_0000 + from.next_u32() % 0x0100_0000)
}

const fn function(
    name: &'static str,
    bound: f64,
    value: fn(f64, f64) -> f64,
    operands: fn(&mut Pcg32) -> (f32, f32),
) -> Function {
    Function {
        name,
        bound,
        value,
        operands,
    }
}

/// In the order of `tests/math/float.c`; `powf` twice, near 1 and elsewhere.
const FUNCTIONS: [Function; 28] = [
    function("powf", 20.0, |x, y| x.powf(y), |r| (any(r), up_to(r, 3.0))),
    function("expf", 1.0, |x, _| x.exp(), |r| (up_to(r, 88.0), 0.0)),
    function("exp2f", 1.0, |x, _| x.exp2(), |r| (up_to(r, 127.0), 0.0)),
    function("logf", 3.0, |x, _| x.ln(), |r| (any(r), 0.0)),
    function("log2f", 3.0, |x, _| x.log2(), |r| (any(r), 0.0)),
    function("log10f", 4.0, |x, _| x.log10(), |r| (any(r), 0.0)),
    function("sinf", 1.6, |x, _| x.sin(), |r| (up_to(r, 1e4), 0.0)),
    function("cosf", 1.6, |x, _| x.cos(), |r| (up_to(r, 1e4), 0.0)),
    function("tanf", 3.0, |x, _| x.tan(), |r| (up_to(r, 1e4), 0.0)),
    function("asinf", 4.0, |x, _| x.asin(), |r| (up_to(r, 1.0), 0.0)),
    function("acosf", 4.0, |x, _| x.acos(), |r| (up_to(r, 1.0), 0.0)),
    function("atanf", 3.0, |x, _| x.atan(), |r| (signed(r), 0.0)),
    function("atan2f", 3.0, f64::atan2, |r| {
        (up_to(r, 9.0), up_to(r, 9.0))
    }),
    function("sinhf", 3.0, |x, _| x.sinh(), |r| (up_to(r, 88.0), 0.0)),
    function("coshf", 3.0, |x, _| x.cosh(), |r| (up_to(r, 88.0), 0.0)),
    function("tanhf", 3.0, |x, _| x.tanh(), |r| (up_to(r, 12.0), 0.0)),
    function("sqrtf", 0.5, |x, _| x.sqrt(), |r| (any(r), 0.0)),
    function("cbrtf", 1.0, |x, _| x.cbrt(), |r| (signed(r), 0.0)),
    function("hypotf", 1.2, f64::hypot, |r| {
        (up_to(r, 9.0), up_to(r, 9.0))
    }),
    function("fmodf", 0.0, |x, y| x % y, |r| (signed(r), signed(r))),
    function("floorf", 0.0, |x, _| x.floor(), |r| (up_to(r, 1e9), 0.0)),
    function("ceilf", 0.0, |x, _| x.ceil(), |r| (up_to(r, 1e9), 0.0)),
    function("truncf", 0.0, |x, _| x.trunc(), |r| (up_to(r, 1e9), 0.0)),
    function("roundf", 0.0, |x, _| x.round(), |r| (up_to(r, 1e9), 0.0)),
    function(
        "rintf",
        0.0,
        |x, _| x.round_ties_even(),
        |r| (up_to(r, 1e9), 0.0),
    ),
    function("fminf", 0.0, f64::min, |r| (signed(r), signed(r))),
    function("fmaxf", 0.0, f64::max, |r| (signed(r), signed(r))),
    function(
        "fdimf",
        0.5,
        |x, y| (x - y).max(0.0),
        |r| (signed(r), signed(r)),
    ),
];

/// Returns the results of the functions for these calls, number and operands, on `arch`.
fn results(calls: &[(usize, f32, f32)], arch: &Arch) -> Vec<f32> {
    let program = compiled(&[root().join("tests/math/float.c")], arch);
    let program = program.unwrap_or_else(|messages| panic!("{messages}"));
    let layout = Layout::of(&program, arch.system.sram_bytes).expect("it fits");
    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    let words = |call: &(usize, f32, f32)| [call.0 as u32, call.1.to_bits(), call.2.to_bits(), 0];
    let head = [calls.len() as u32, 0, 0, 0];
    let all = head.into_iter().chain(calls.iter().flat_map(words));
    world.memory = all.flat_map(u32::to_le_bytes).collect();
    let main = program.main.expect("there is a main");
    let options = interp::Options {
        precision: arch.precision,
        steps: 1 << 40,
        ..interp::Options::new(&layout)
    };
    let whole = dre::Dre {
        control: program,
        kernels: Default::default(),
    };
    dre::run(&whole, main, &[], &mut world, &options).unwrap_or_else(|t| panic!("{t:?}"));
    let word = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
    let rows = world.memory[16..].chunks_exact(16);
    rows.map(|row| word(&row[12..])).collect()
}

/// One unit of the last place of a float of this size.
fn ulp(x: f64) -> f64 {
    let exponent = (x.abs().to_bits() >> 52) as i32 - 1023;
    2f64.powi(exponent.max(-126) - 23)
}

#[test]
fn functions_of_float_keep_the_errors_that_are_stated() {
    let asked = std::env::var("SRP_VECTORS").ok();
    let count: usize = asked.map_or(4000, |n| n.parse().expect("SRP_VECTORS is a number"));
    let mut from = Pcg32::new(19, 23);
    let mut calls = Vec::new();
    for (number, function) in FUNCTIONS.iter().enumerate() {
        for _ in 0..count {
            let (x, y) = (function.operands)(&mut from);
            calls.push((number, x, y));
            // Powers near 1, and logarithms where they are small.
            if matches!(function.name, "powf" | "logf" | "log2f" | "log10f") {
                calls.push((number, near_one(&mut from), 0.1 * y + 1.0));
            }
        }
    }
    let mut worst = [(0f64, 0f32, 0f32); FUNCTIONS.len()];
    for (&(number, x, y), result) in calls.iter().zip(results(&calls, &machine("sgrt"))) {
        let exact = (FUNCTIONS[number].value)(x.into(), y.into());
        // Beyond the largest float either it or infinity is right.
        if exact.abs() > f64::from(f32::MAX) {
            assert!(result.is_infinite() || result.abs() == f32::MAX);
            continue;
        }
        let off = (f64::from(result) - exact).abs() / ulp(exact);
        let off = if off.is_nan() { f64::INFINITY } else { off };
        if off > worst[number].0 {
            worst[number] = (off, x, y);
        }
    }
    let mut wrong = Vec::new();
    for (function, (off, x, y)) in FUNCTIONS.iter().zip(worst) {
        println!("{}: {off:.3} ulp at {x:e}, {y:e}", function.name);
        if off > function.bound {
            wrong.push(function.name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?} are off by more than is stated");
}

#[test]
fn functions_that_are_exact_stay_so_where_division_is_not() {
    let mut from = Pcg32::new(23, 29);
    let mut calls = Vec::new();
    let exact = (0..).zip(&FUNCTIONS).filter(|(_, f)| f.bound == 0.0);
    for (number, function) in exact {
        for _ in 0..500 {
            let (x, y) = (function.operands)(&mut from);
            calls.push((number, x, y));
        }
    }
    for bits in [4, 8, 12, 23] {
        let mut arch = machine("sgrt");
        arch.precision.div = Approx::Table {
            structure: Structure::Table,
            bits,
            steps: 0,
            fused: true,
            refine: Refine::Unit,
        };
        for (&(number, x, y), result) in calls.iter().zip(results(&calls, &arch)) {
            let function = &FUNCTIONS[number];
            let exact = (function.value)(x.into(), y.into());
            let name = function.name;
            assert!(
                f64::from(result) == exact,
                "{name} of {x:e} and {y:e} is {result:e}, not {exact:e}, with {bits} bits"
            );
        }
    }
}
