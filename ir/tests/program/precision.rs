//! Special functions refined in code, and transformations beyond C that may be asked for.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::{Approx, Precision, Refine};
use srp_archdesc::structure::Structure;
use srp_ir::interp::{self, End, FlatWorld, Options};
use srp_ir::layout::Layout;
use srp_ir::pass;
use srp_ir::program::{Bits, InstKind, Program};
use srp_ir::text::read;

/// 1/x, 1/√x, √x and y/x, and the same of a constant.
const FUNCTIONS: &str = "main fn0
fn0 main(v0: w, v1: w) -> (w, w, w, w, w) {
bb0:
  v2 = rcp v0
  v3 = rsqrt v0
  v4 = sqrt v0
  v5 = fdiv v1, v0
  v6 = const 0x40490fdb
  v7 = rcp v6
  v8 = fadd v7, v0
  ret v2, v3, v4, v5, v8
}
";

fn words(program: &Program, args: &[u32], precision: Precision) -> Vec<u32> {
    let layout = Layout::of(program, 8192).expect("it has no data");
    let options = Options {
        precision,
        ..Options::new(&layout)
    };
    let args: Vec<Bits> = args.iter().map(|&word| Bits::Word(word)).collect();
    let main = program.main.expect("there is a main");
    let mut world = FlatWorld::new(&layout, 8192);
    let outcome = interp::run(program, main, &args, &mut world, &options);
    let End::Returned(values) = outcome.expect("it does not trap").end else {
        panic!("it returns");
    };
    let word = |bits: &Bits| match bits {
        Bits::Word(word) => *word,
        other => panic!("{other:?} is not a word"),
    };
    values.iter().map(word).collect()
}

/// Where something special happens, with neighbours, and random words.
fn operands() -> Vec<u32> {
    let edges = [
        0u32,
        0x0000_0001,
        0x0020_0000,
        0x0040_0000,
        0x0080_0000,
        0x3f80_0000,
        0x7e80_0000,
        0x7f00_0000,
        0x7f80_0000,
        0x7fc0_0000,
    ];
    let near = |x: u32| (-40i32..40).map(move |d| x.wrapping_add_signed(d));
    let near = edges.into_iter().flat_map(near);
    let mut random = Pcg32::new(6, 6);
    let random = (0..20_000).map(move |_| random.next_u32());
    near.flat_map(|x| [x, x ^ 1 << 31]).chain(random).collect()
}

#[test]
fn steps_in_code_give_the_bits_of_the_unit() {
    let before = read(FUNCTIONS).expect("it is a program");
    for (bits, steps, fused) in [
        (12, 1, true),
        (12, 1, false),
        (5, 3, true),
        (8, 2, false),
        (23, 1, true),
        (9, 0, false),
    ] {
        let refine = Refine::Code;
        let approx = Approx::Table {
            structure: Structure::Table,
            bits,
            steps,
            fused,
            refine,
        };
        let precision = Precision {
            rcp: approx,
            rsqrt: approx,
            sqrt: approx,
            div: approx.in_unit(),
            ..Precision::EXACT
        };
        let mut after = before.clone();
        pass::optimise(&mut after, &pass::Options::new(precision));
        srp_ir::verify(&after).expect("it is still a program");
        for x in operands() {
            let args = [x, x.wrapping_mul(0x9e37_79b9)];
            let unit = words(&before, &args, precision.in_units());
            let code = words(&after, &args, precision);
            assert_eq!(code, unit, "{x:#x}: {bits} bits, {steps} steps, {fused}");
        }
    }
}

/// How many operations of this name a program has.
fn count(program: &Program, name: &str) -> usize {
    let func = &program.funcs[program.main.expect("there is a main")];
    let insts = func.layout.iter().flat_map(|&b| &func.blocks[b].insts);
    let is = |&&inst: &&srp_ir::program::Inst| matches!(&func.insts[inst].kind, InstKind::Op { op, .. } if op.name() == name);
    insts.filter(is).count()
}

#[test]
fn quotients_become_products_when_asked() {
    let text = "main fn0
fn0 main(v0: w, v1: w, v2: w) -> (w, w, w, w) {
bb0:
  v3 = const 0x3f800000
  v4 = const 0x40a00000
  v5 = const 0x7f000001
  v6 = fdiv v0, v2
  v7 = fdiv v1, v2
  v8 = fdiv v3, v2
  v9 = fdiv v0, v4
  v10 = fdiv v1, v5
  v11 = fadd v8, v10
  ret v6, v7, v11, v9
}
";
    let before = read(text).expect("it is a program");
    let precision = Precision {
        rcp: Approx::table(12, 1),
        ..Precision::EXACT
    };
    let mut options = pass::Options::new(precision);
    let mut kept = before.clone();
    assert_eq!(pass::optimise(&mut kept, &options), []);
    assert_eq!((count(&kept, "fdiv"), count(&kept, "rcp")), (5, 0));
    options.fast_math.reciprocal = true;
    let mut after = before.clone();
    let told = pass::optimise(&mut after, &options);
    assert_eq!(told.len(), 2, "each kind once, for there are no positions");
    // By the constant whose reciprocal is denormal it stays a quotient.
    assert_eq!((count(&after, "fdiv"), count(&after, "rcp")), (1, 1));
    let (a, b, c) = (7.3f32, -0.4f32, 3.7f32);
    let found = words(&after, &[a, b, c].map(f32::to_bits), precision);
    let rcp = srp_archdesc::ops::semantics::elementary::rcp(c.to_bits(), 12, 1);
    let rcp = f32::from_bits(rcp);
    let big = f32::from_bits(0x7f00_0001);
    let expected = [a * rcp, b * rcp, rcp + b / big, a * (1.0 / 5.0)];
    assert_eq!(found, expected.map(f32::to_bits));
}

#[test]
fn sums_take_in_products_when_asked() {
    let text = "main fn0
fn0 main(v0: w, v1: w, v2: w) -> (w, w, w) {
bb0:
  v3 = fmul v0, v1
  v4 = fadd v3, v2
  v5 = fmul v1, v2
  v6 = fadd v0, v5
  v7 = fmul v0, v2
  v8 = fadd v7, v7
  ret v4, v6, v8
}
";
    let before = read(text).expect("it is a program");
    let mut options = pass::Options::new(Precision::EXACT);
    let mut kept = before.clone();
    assert_eq!(pass::optimise(&mut kept, &options), []);
    assert_eq!(count(&kept, "fma"), 0);
    options.fast_math.contract = true;
    let mut after = before.clone();
    assert!(!pass::optimise(&mut after, &options).is_empty());
    // A product that is needed twice is made once.
    assert_eq!((count(&after, "fma"), count(&after, "fmul")), (2, 1));
    let (a, b, c) = (1.000_000_1f32, 0.999_999_9f32, -1.0f32);
    let found = words(&after, &[a, b, c].map(f32::to_bits), Precision::EXACT);
    let expected = [a.mul_add(b, c), b.mul_add(c, a), a * c + a * c];
    assert_eq!(found, expected.map(f32::to_bits));
    assert_ne!(found[0], (a * b + c).to_bits(), "the rounding shows");
}
