//! The semantics of programs, and the limits of a run.

use crate::generate;
use srp_archdesc::isa::{Opcode, Space};
use srp_archdesc::ops::Value;
use srp_archdesc::ports;
use srp_ir::interp::{
    End, FlatWorld, Kernels, Options, Outcome, SYSTEM_BASE, Trap, TrapKind, World, run, run_with,
};
use srp_ir::layout::Layout;
use srp_ir::program::{Bits, Func, InstKind, Kernel, Program};
use srp_ir::text::read;
use srp_ir::verify;
use std::collections::BTreeSet;

const SRAM: u32 = 16 << 10;

fn parse(text: &str) -> Program {
    let program = read(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    if let Err(found) = verify(&program) {
        panic!("{found:?}\n{text}");
    }
    program
}

/// Runs the first function with words as arguments.
fn run_words(
    text: &str,
    args: &[u32],
    setup: impl Fn(&mut FlatWorld),
) -> (Result<Outcome, Trap>, FlatWorld) {
    let program = parse(text);
    let layout = Layout::of(&program, SRAM).expect("small programs fit");
    let mut world = FlatWorld::new(&layout, SRAM);
    setup(&mut world);
    let args: Vec<Bits> = args.iter().map(|&w| Bits::Word(w)).collect();
    let func = program.funcs.keys().next().expect("a function");
    let mut options = Options::new(&layout);
    options.steps = 100_000;
    options.depth = 1000;
    (run(&program, func, &args, &mut world, &options), world)
}

fn result(text: &str, args: &[u32]) -> u32 {
    let (outcome, _) = run_words(text, args, |_| {});
    outcome.expect("the program does not trap").status() as u32
}

fn trap(text: &str, args: &[u32]) -> String {
    let (outcome, _) = run_words(text, args, |_| {});
    outcome.expect_err("the program traps").show(&parse(text))
}

#[test]
fn loops_calls_and_slots() {
    let text = "
        fn0 factorial(v0: w) -> w {
          ss0 saved size 4 align 4
        bb0:
          v1 = const true
          v2 = const 1
          v3 = slot ss0
          sw v1, v3, v0
          v4 = lt v2, v0
          br v4, bb1, bb2
        bb1:
          v5 = sub v0, v2
          v6: w = call fn0(v5)
          v7 = lw v1, v3
          v8 = mul v6, v7
          ret v8
        bb2:
          ret v2
        }";
    assert_eq!(result(text, &[10]), 3_628_800);
    // Parameters of a block change all at once.
    let swap = "
        fn0 fibonacci(v0: w) -> w {
        bb0:
          v1 = const 0
          v2 = const 1
          jump bb1(v0, v1, v2)
        bb1(v3: w, v4: w, v5: w):
          v6 = add v4, v5
          v7 = sub v3, v2
          v8 = ne v7, v1
          br v8, bb1(v7, v5, v6), bb2
        bb2:
          ret v5
        }";
    assert_eq!(result(swap, &[20]), 6765);
    let (outcome, _) = run_words(swap, &[20], |_| {});
    let profile = outcome.expect("no trap").profile;
    assert_eq!(profile.calls.values().sum::<u64>(), 1);
    let blocks: Vec<u64> = profile
        .blocks
        .values()
        .next()
        .expect("a function")
        .values()
        .copied()
        .collect();
    assert_eq!(blocks, [1, 20, 1]);
    assert_eq!(profile.steps, 3 + 20 * 4 + 1);
}

#[test]
fn memory_is_little_endian_and_guarded() {
    let text = "
        g0 data size 32 align 16 {
          hex 80ff7f01 02030405
        }
        fn0 f(v0: w) -> w {
        bb0:
          v1 = const 0
          v2 = ne v0, v1
          v3 = symbol g0
          v4 = lb v2, v3
          v5 = lbu v2, v3 +1
          v6 = lh v2, v3
          v7 = add v4, v5
          v8 = add v6, v7
          sh v2, v3, v8 +8
          v9 = const 1
          sw v2, v9, v9
          v10 = lw v2, v3 +8
          ret v10
        }";
    // Nothing is accessed under a false guard, not even at an unaligned address.
    assert_eq!(result(text, &[0]), 0);
    let (outcome, _) = run_words(text, &[1], |_| {});
    let expected = TrapKind::Access {
        space: Space::Sram,
        address: 1,
        bytes: 4,
    };
    assert_eq!(outcome.expect_err("unaligned").kind, expected);
    let fine = text.replace("sw v2, v9, v9", "v11 = mov v9");
    // -128 + 255 + -128
    assert_eq!(result(&fine, &[1]), u32::from((-1i16) as u16));
}

#[test]
fn ports_and_system_memory() {
    let text = "
        fn0 f(v0: w) -> w {
        bb0:
          v1 = const true
          v2 = in +4
          out v2 +9
          v3 = glw v1, v0 +4
          gsw v1, v0, v2
          out v3 +20
          out v2 +10
          unreachable
        }";
    let (outcome, world) = run_words(text, &[SYSTEM_BASE], |world| {
        world.memory = vec![0, 0, 0, 0, 1, 2, 3, 4];
        world
            .inputs
            .entry(4)
            .or_default()
            .push_back(u32::from(b'x'));
    });
    assert_eq!(outcome.expect("no trap").end, End::Exited(i32::from(b'x')));
    assert_eq!(world.output, b"x");
    assert_eq!(world.outputs[&20], [0x0403_0201]);
    assert!(!world.outputs.contains_key(&ports::EXIT));
    assert_eq!(world.memory, [b'x', 0, 0, 0, 1, 2, 3, 4]);
    let (outcome, _) = run_words(text, &[SYSTEM_BASE], |_| {});
    assert_eq!(
        outcome.expect_err("nothing to read").kind,
        TrapKind::Port(4)
    );
}

#[test]
fn traps_say_where() {
    let line = |body: &str| {
        format!(
            "file0 \"t.c\"\nfn0 f(v0: w) -> w {{\nbb0:\n  v1 = const true\n  {body} ; t.c:3:4\n  ret v0\n}}\n"
        )
    };
    let null = trap(&line("v2 = lw v1, v0"), &[0]);
    assert_eq!(
        null,
        "t.c:3:4: access of 4 bytes at 0x00000000 is outside SRAM or unaligned (in f)"
    );
    let outside = trap(&line("v2 = glw v1, v0"), &[16]);
    assert_eq!(
        outside,
        "t.c:3:4: access of 4 bytes at 0x00000010 is outside system memory or unaligned (in f)"
    );
    assert_eq!(
        trap(&line("v2 = div v1, v0, v0"), &[0]),
        "t.c:3:4: integer division by zero (in f)"
    );
    let no_function = "t.c:3:4: call of 0x40000004, which is no function of this type (in f)";
    assert_eq!(
        trap(&line("v2: w = call v0(v0)"), &[0x4000_0004]),
        no_function
    );
    let signature = "t.c:3:4: call of 0x40000000, which is no function of this type (in f)";
    assert_eq!(
        trap(&line("v2: w = call v0(v1)"), &[0x4000_0000]),
        signature
    );
    assert_eq!(
        trap(&line("launch k2(v0)"), &[0]),
        "t.c:3:4: there is no kernel k2 (in f)"
    );
}

#[test]
fn runs_are_bounded() {
    let forever = "fn0 f() {\nbb0:\njump bb1\nbb1:\njump bb1\n}\n";
    assert_eq!(trap(forever, &[]), "the limit on steps is reached (in f)");
    let deep = "fn0 f() {\nbb0:\ncall fn0()\nret\n}\n";
    assert_eq!(trap(deep, &[]), "stack overflow (in f)");
    let large = "fn0 f() {\nss0 x size 5000 align 4\nbb0:\nv0 = slot ss0\ncall fn0()\nret\n}\n";
    let (outcome, _) = run_words(large, &[], |_| {});
    assert_eq!(
        outcome.expect_err("three frames of 16 KB").kind,
        TrapKind::StackOverflow
    );
    assert_eq!(
        trap("fn0 f() {\nbb0:\nunreachable\n}\n", &[]),
        "unreachable code was reached (in f)"
    );
}

/// A kernel that adds its arguments up and leaves the sum in SRAM.
struct Adder;

impl Kernels for Adder {
    fn launch(
        &mut self,
        kernel: Kernel,
        args: &[Bits],
        world: &mut dyn World,
        steps: &mut u64,
    ) -> Result<Vec<Bits>, Trap> {
        *steps = steps.checked_sub(1).ok_or(TrapKind::StepLimit.nowhere())?;
        let sum = args.iter().map(|a| a.lanes()[0]).sum();
        let stored = world.store(Space::Sram, 64, 4, Value::word(sum));
        stored.ok_or(TrapKind::NoKernel(kernel).nowhere())?;
        Ok(vec![Bits::Word(sum), Bits::Pred(true)])
    }
}

#[test]
fn launches_go_through_the_hook() {
    let program =
        parse("fn0 f(v0: w) -> (p, w) {\nbb0:\nv1: w, v2: p = launch k0(v0, v0)\nret v2, v1\n}\n");
    let layout = Layout::of(&program, SRAM).expect("small programs fit");
    let mut world = FlatWorld::new(&layout, SRAM);
    let options = Options::new(&layout);
    let func = program.func("f").expect("f");
    let outcome = run_with(
        &program,
        func,
        &[Bits::Word(21)],
        &mut world,
        &mut Adder,
        &options,
    );
    let results = vec![Bits::Pred(true), Bits::Word(42)];
    assert_eq!(outcome.expect("no trap").end, End::Returned(results));
    assert_eq!(world.sram[64], 42);
}

/// The random programs do what the tests of the passes need: they never trap, they end, and among
/// them they run every opcode.
#[test]
fn random_programs_run_every_opcode() {
    let mut run_ops = BTreeSet::new();
    for seed in 0..200 {
        let program = generate::program(seed);
        let (outcome, _) = generate::run(&program);
        let outcome = outcome.unwrap_or_else(|trap| panic!("seed {seed}: {}", trap.show(&program)));
        for (func, counts) in outcome.profile.blocks.iter() {
            for (block, &count) in counts.iter() {
                if count > 0 {
                    run_ops.extend(opcodes(&program, func, block));
                }
            }
        }
    }
    let missing: Vec<&Opcode> = Opcode::ALL
        .iter()
        .filter(|op| !run_ops.contains(op))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

fn opcodes(program: &Program, func: Func, block: srp_ir::program::Block) -> Vec<Opcode> {
    let func = &program.funcs[func];
    let insts = func.blocks[block].insts.iter();
    insts
        .filter_map(|&inst| match func.insts[inst].kind {
            InstKind::Op { op, .. } => Some(op),
            _ => None,
        })
        .collect()
}
