//! Trip counts against the loop run step by step, at the edges of the number range too.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::interp::{self, End, FlatWorld, Kernels, Options, Trap, World};
use srp_ir::layout::Layout;
use srp_ir::program::*;
use srp_ir::split;

/// A loop to count: `x` starts at the first argument; the test is made on `x` or its next value.
#[derive(Clone, Copy, Debug)]
struct Form {
    test: Opcode,
    stride: u32,
    /// Test the value that the next iteration has, as loops that count in their head do.
    tests_next: bool,
    /// `bound test x` rather than `x test bound`.
    swapped: bool,
    /// The loop goes on while the test fails.
    negated: bool,
    /// The loop is entered only where the test holds one step before.
    guarded: bool,
    /// The start, where it is a constant.
    start: Option<u32>,
    /// The bound, where it is a constant.
    bound: Option<u32>,
}

impl Form {
    fn goes_on(self, x: u32, bound: u32) -> bool {
        let (a, b) = if self.swapped { (bound, x) } else { (x, bound) };
        let holds = match self.test {
            Opcode::Eq => a == b,
            Opcode::Ne => a != b,
            Opcode::Lt => (a as i32) < b as i32,
            Opcode::Le => a as i32 <= b as i32,
            Opcode::Ltu => a < b,
            _ => a <= b,
        };
        holds != self.negated
    }

    /// Iterations; `None` if there are many.
    fn count(self, start: u32, bound: u32) -> Option<u32> {
        let before = if self.tests_next {
            start
        } else {
            start.wrapping_sub(self.stride)
        };
        if self.guarded && !self.goes_on(before, bound) {
            return Some(0);
        }
        let mut x = start;
        for count in 1..5000 {
            let next = x.wrapping_add(self.stride);
            if !self.goes_on(if self.tests_next { next } else { x }, bound) {
                return Some(count);
            }
            x = next;
        }
        None
    }

    /// A function of start and bound that gives the number of iterations.
    fn program(self) -> Program {
        let mut program = Program::default();
        program.files.push("trip.c".to_owned());
        let pos = Pos::nowhere();
        let mut func = Function::new("trip", &[Ty::Word; 2], vec![Ty::Word], pos);
        let entry = func.entry();
        let (body, after) = (func.add_block(), func.add_block());
        let params = func.blocks[entry].params.clone();
        let mut given = |constant: Option<u32>, param| match constant {
            Some(w) => func.append_const(entry, Bits::Word(w), pos),
            None => param,
        };
        let (start, bound) = (given(self.start, params[0]), given(self.bound, params[1]));
        let zero = func.append_const(entry, Bits::Word(0), pos);
        let (x, count) = (
            func.add_param(body, Ty::Word),
            func.add_param(body, Ty::Word),
        );
        let result = func.add_param(after, Ty::Word);
        func.blocks[body].kernel = Some(KernelMark {
            name: "trip".to_owned(),
            pos,
            required: true,
            nest: false,
            slower: None,
            restrict: Vec::new(),
            independence: Default::default(),
        });
        let constant = |func: &mut Function, block, w| func.append_const(block, Bits::Word(w), pos);
        let op = |func: &mut Function, block, op, args: [Value; 2]| {
            func.append_op(block, op, &args, 0, pos).expect("a result")
        };
        let in_order = |x| if self.swapped { [bound, x] } else { [x, bound] };
        let jump = |block, args: &[Value]| Target {
            block,
            args: args.to_vec(),
        };
        let enter = jump(body, &[start, zero]);
        func.blocks[entry].end = if self.guarded {
            let before = if self.tests_next {
                start
            } else {
                let stride = constant(&mut func, entry, self.stride);
                op(&mut func, entry, Opcode::Sub, [start, stride])
            };
            let cond = op(&mut func, entry, self.test, in_order(before));
            let skip = jump(after, &[zero]);
            let (then, other) = if self.negated {
                (skip, enter)
            } else {
                (enter, skip)
            };
            Terminator::Branch { cond, then, other }
        } else {
            Terminator::Jump(enter)
        };
        let one = constant(&mut func, body, 1);
        let counted = op(&mut func, body, Opcode::Add, [count, one]);
        let stride = constant(&mut func, body, self.stride);
        let next = op(&mut func, body, Opcode::Add, [x, stride]);
        let tested = if self.tests_next { next } else { x };
        let cond = op(&mut func, body, self.test, in_order(tested));
        let (back, exit) = (jump(body, &[next, counted]), jump(after, &[counted]));
        let (then, other) = if self.negated {
            (exit, back)
        } else {
            (back, exit)
        };
        func.blocks[body].end = Terminator::Branch { cond, then, other };
        func.blocks[after].end = Terminator::Return(vec![result]);
        program.funcs.push(func);
        program
    }
}

/// Answers a launch with the trip count alone.
struct Count(u32);

impl Kernels for Count {
    fn launch(
        &mut self,
        _: Kernel,
        args: &[Bits],
        _: &mut dyn World,
        _: &mut u64,
    ) -> Result<Vec<Bits>, Trap> {
        Ok(vec![args[self.0 as usize]])
    }
}

fn random_form(rng: &mut Pcg32) -> Form {
    let mut below = |n: u32| rng.next_u32() % n;
    let tests = [
        Opcode::Ne,
        Opcode::Eq,
        Opcode::Lt,
        Opcode::Le,
        Opcode::Ltu,
        Opcode::Leu,
    ];
    let strides = [1, -1, 1, 2, -2, 3, -3, 4, 7, 8, 12, -12, 16, -20, 24, 100];
    let word = |w: u32| (w < 4).then(|| [0, 1, 5, u32::MAX - 2][w as usize]);
    Form {
        test: tests[below(6) as usize],
        stride: strides[below(16) as usize] as u32,
        tests_next: below(2) == 0,
        swapped: below(2) == 0,
        negated: below(2) == 0,
        guarded: below(2) == 0,
        start: word(below(8)),
        bound: word(below(8)),
    }
}

/// A start near an edge of the number range, and a bound near it.
fn random_ends(rng: &mut Pcg32) -> (u32, u32) {
    let edges = [0, 0, 1 << 31, i32::MAX as u32, u32::MAX, 1000];
    let edge = edges[(rng.next_u32() % 6) as usize];
    let near = |spread: u32, rng: &mut Pcg32| (rng.next_u32() % (2 * spread)).wrapping_sub(spread);
    let start = near(40, rng).wrapping_add(edge);
    (start, start.wrapping_add(near(300, rng)))
}

/// True if the variable leaves the range of its test's numbers. The count of an ordered test need
/// not be exact then.
fn wraps(form: Form, start: u32, bound: u32, count: u32) -> bool {
    if matches!(form.test, Opcode::Eq | Opcode::Ne) {
        return false;
    }
    let signed = matches!(form.test, Opcode::Lt | Opcode::Le);
    let wide = |w: u32| {
        if signed {
            i64::from(w as i32)
        } else {
            i64::from(w)
        }
    };
    let stride = i64::from(form.stride as i32);
    let first = wide(start);
    let last = first + stride * i64::from(count);
    let limits = if signed {
        i64::from(i32::MIN)..=i64::from(i32::MAX)
    } else {
        0..=i64::from(u32::MAX)
    };
    // Counting an unsigned variable down past zero by one is an idiom, and exact.
    let idiom = !signed && stride == -1 && wide(bound) > 0;
    !limits.contains(&last) && !idiom
}

#[test]
fn trip_counts_are_exact() {
    let mut rng = Pcg32::new(11, 4);
    let (mut counted, mut compared, mut guarded) = (0, 0, 0);
    for _ in 0..6000 {
        let form = random_form(&mut rng);
        let program = form.program();
        srp_ir::verify(&program).expect("the forms are valid");
        let split = split::split(&program).dre;
        let Some(dfg) = split.kernels.values().next() else {
            continue;
        };
        counted += 1;
        let layout = Layout::of(&program, 8 << 10).expect("fits");
        for _ in 0..6 {
            let (start, bound) = random_ends(&mut rng);
            let args = [Bits::Word(start), Bits::Word(bound)];
            let (start, bound) = (form.start.unwrap_or(start), form.bound.unwrap_or(bound));
            let Some(expected) = form.count(start, bound) else {
                continue;
            };
            if wraps(form, start, bound, expected) {
                continue;
            }
            let mut world = FlatWorld::new(&layout, 8 << 10);
            let outcome = interp::run_with(
                &split.control,
                Func::new(0),
                &args,
                &mut world,
                &mut Count(dfg.trip.expect("loops of programs have one")),
                &Options::new(&layout),
            );
            let found = outcome.expect("runs").end;
            let expected = End::Returned(vec![Bits::Word(expected)]);
            assert_eq!(found, expected, "{form:?} from {start:#x} to {bound:#x}");
            compared += 1;
            guarded += u32::from(form.guarded);
        }
    }
    assert!(counted > 3000, "{counted} of 6000 loops are counted");
    assert!(
        compared > 8000 && guarded > 3000,
        "{compared} comparisons, {guarded} guarded"
    );
}
