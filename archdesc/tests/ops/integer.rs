//! Integer, predicate and lane operations against wide integers and plain indexing.

use crate::values::{INTEGERS, Random, floats, result, rounds};
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::Class;
use srp_archdesc::ops::{Fault, V4, eval};
use srp_archdesc::{Opcode, Ty};

/// Returns the result of a two-operand word operation, in integers wide enough never to overflow.
fn wide(op: Opcode, a: u32, b: u32) -> Option<u32> {
    let (s, t) = (i128::from(a as i32), i128::from(b as i32));
    let (u, v) = (i128::from(a), i128::from(b));
    let power = 1i128 << (v % 32);
    let value = match op {
        Opcode::Add => s + t,
        Opcode::Sub => s - t,
        Opcode::And => u & v,
        Opcode::Or => u | v,
        Opcode::Xor => (u | v) - (u & v),
        Opcode::Shl => u * power,
        Opcode::Shr => u / power,
        Opcode::Sar => s.div_euclid(power),
        Opcode::Min => s.min(t),
        Opcode::Max => s.max(t),
        Opcode::Minu => u.min(v),
        Opcode::Maxu => u.max(v),
        Opcode::Eq => (s - t == 0).into(),
        Opcode::Ne => (s - t != 0).into(),
        Opcode::Lt => (s - t < 0).into(),
        Opcode::Le => (s - t <= 0).into(),
        Opcode::Ltu => (u - v < 0).into(),
        Opcode::Leu => (u - v <= 0).into(),
        Opcode::Mul => s * t,
        Opcode::Mulhs => (s * t).div_euclid(1 << 32),
        Opcode::Mulhu => (u * v) / (1 << 32),
        _ => return None,
    };
    Some(value as u32)
}

/// The same lane by lane, for the vector operations.
fn scalar_of(op: Opcode) -> Option<(Opcode, bool)> {
    Some(match op {
        Opcode::Vadd => (Opcode::Add, false),
        Opcode::Vsub => (Opcode::Sub, false),
        Opcode::Vand => (Opcode::And, false),
        Opcode::Vor => (Opcode::Or, false),
        Opcode::Vxor => (Opcode::Xor, false),
        Opcode::Vshl => (Opcode::Shl, false),
        Opcode::Vshr => (Opcode::Shr, false),
        Opcode::Vsar => (Opcode::Sar, false),
        Opcode::Vmin => (Opcode::Min, false),
        Opcode::Vmax => (Opcode::Max, false),
        Opcode::Vmul => (Opcode::Mul, false),
        Opcode::Veq => (Opcode::Eq, true),
        Opcode::Vlt => (Opcode::Lt, true),
        Opcode::Vltu => (Opcode::Ltu, true),
        Opcode::Vfadd => (Opcode::Fadd, false),
        Opcode::Vfsub => (Opcode::Fsub, false),
        Opcode::Vfmul => (Opcode::Fmul, false),
        Opcode::Vfma => (Opcode::Fma, false),
        Opcode::Vfmin => (Opcode::Fmin, false),
        Opcode::Vfmax => (Opcode::Fmax, false),
        Opcode::Vfneg => (Opcode::Fneg, false),
        Opcode::Vfabs => (Opcode::Fabs, false),
        Opcode::Vffloor => (Opcode::Ffloor, false),
        Opcode::Vitof => (Opcode::Itof, false),
        Opcode::Vftoi => (Opcode::Ftoi, false),
        Opcode::Vhpack => (Opcode::Hpack, false),
        Opcode::Vhlow => (Opcode::Hlow, false),
        Opcode::Vhhigh => (Opcode::Hhigh, false),
        Opcode::Vhadd => (Opcode::Hadd, false),
        Opcode::Vhsub => (Opcode::Hsub, false),
        Opcode::Vhmul => (Opcode::Hmul, false),
        Opcode::Vhfma => (Opcode::Hfma, false),
        Opcode::Vhmin => (Opcode::Hmin, false),
        Opcode::Vhmax => (Opcode::Hmax, false),
        Opcode::Vfeq => (Opcode::Feq, true),
        Opcode::Vfne => (Opcode::Fne, true),
        Opcode::Vflt => (Opcode::Flt, true),
        Opcode::Vfle => (Opcode::Fle, true),
        _ => return None,
    })
}

#[test]
fn words_against_wide_integers() {
    let mut random = Random(1);
    let mut values = INTEGERS.to_vec();
    // Every pair: a million and more with a thousand values.
    let extra = f64::from(rounds(40_000)).sqrt() as u32;
    values.extend((0..extra).map(|_| random.word()));
    let mut ops = 0;
    for &op in Opcode::ALL {
        ops += u32::from(wide(op, 0, 0).is_some());
        for (&a, &b) in values
            .iter()
            .flat_map(|a| values.iter().map(move |b| (a, b)))
        {
            if let Some(expected) = wide(op, a, b) {
                assert_eq!(result(op, &[a, b]), expected, "{op} {a:#x} {b:#x}");
            }
        }
    }
    assert_eq!(ops, 21);
}

#[test]
fn division_truncates_wraps_and_traps_under_its_guard() {
    let divisions = [Opcode::Div, Opcode::Divu, Opcode::Rem, Opcode::Remu];
    for (&a, &b) in INTEGERS
        .iter()
        .flat_map(|a| INTEGERS.iter().map(move |b| (a, b)))
    {
        for op in divisions {
            let run = |guard| {
                let args = [V4::pred(guard), V4::word(a), V4::word(b)];
                eval(op, &args, 0, &Precision::EXACT).map(|v| v.expect("it computes").as_word())
            };
            assert_eq!(run(false), Ok(0));
            let (s, t) = (i64::from(a as i32), i64::from(b as i32));
            let expected = match (b, op) {
                (0, _) => Err(Fault::DivisionByZero),
                (_, Opcode::Div) => Ok((s / t) as u32),
                (_, Opcode::Rem) => Ok((s % t) as u32),
                (_, Opcode::Divu) => Ok((u64::from(a) / u64::from(b)) as u32),
                _ => Ok((u64::from(a) % u64::from(b)) as u32),
            };
            assert_eq!(run(true), expected, "{op} {a:#x} {b:#x}");
        }
    }
}

#[test]
fn predicates_and_selections() {
    for bits in 0..8u32 {
        let [a, b, c] = [bits & 1, bits >> 1 & 1, bits >> 2];
        assert_eq!(result(Opcode::Pand, &[a, b]), a * b);
        assert_eq!(result(Opcode::Por, &[a, b]), a + b - a * b);
        assert_eq!(result(Opcode::Pxor, &[a, b]), (a + b) % 2);
        assert_eq!(result(Opcode::Pnot, &[a]), 1 - a);
        assert_eq!(result(Opcode::Ptoi, &[a]), a);
        assert_eq!(result(Opcode::Pmov, &[a]), a);
        assert_eq!(result(Opcode::Psel, &[a, b, c]), [c, b][a as usize]);
        let words = [0x7f80_0001, 0xdead_beef];
        assert_eq!(
            result(Opcode::Sel, &[a, words[0], words[1]]),
            words[1 - a as usize]
        );
        assert_eq!(result(Opcode::Mov, &[words[b as usize]]), words[b as usize]);
        let vectors = [V4([1, 2, 3, 4]), V4([5, 6, 7, 8])];
        let args = [V4::pred(a == 1), vectors[0], vectors[1]];
        let picked = eval(Opcode::Vsel, &args, 0, &Precision::EXACT);
        assert_eq!(picked, Ok(Some(vectors[1 - a as usize])));
    }
}

#[test]
fn lanes_are_independent_copies_of_the_scalar_operation() {
    let mut random = Random(2);
    let mut pool = [floats(), INTEGERS.to_vec()].concat();
    pool.extend((0..100).map(|_| random.near_one(40)));
    let mut ops = 0;
    for &op in Opcode::ALL {
        let Some((scalar, mask)) = scalar_of(op) else {
            continue;
        };
        ops += 1;
        // Special values meet special values in some lane: a quarter of all pairs, in turn.
        let specials = floats();
        let pairs = specials.len() * specials.len() / 4;
        for round in 0..(rounds(2000) as usize).max(pairs) {
            let (first, second) = (round / specials.len() * 4, round % specials.len());
            let special = |k: usize| [specials[(first + k) % specials.len()], specials[second]];
            let mut pick = || pool[random.word() as usize % pool.len()];
            // Every other round looks like a point or a colour: the last lane is zero.
            let zero = |v: [u32; 4]| {
                if round % 2 == 0 {
                    V4([v[0], v[1], v[2], 0])
                } else {
                    V4(v)
                }
            };
            let mut args = [(); 3].map(|()| zero([(); 4].map(|()| pick())));
            if round < pairs {
                args[0] = V4([0, 1, 2, 3].map(|k| special(k)[0]));
                args[1] = V4([0, 1, 2, 3].map(|k| special(k)[1]));
            }
            let args = &args[..op.info().operands.len()];
            let lane = |k: usize| {
                let words: Vec<u32> = args.iter().map(|a| a.0[k]).collect();
                let word = result(scalar, &words);
                if mask { word.wrapping_neg() } else { word }
            };
            let expected = V4([lane(0), lane(1), lane(2), lane(3)]);
            assert_eq!(
                eval(op, args, 0, &Precision::EXACT),
                Ok(Some(expected)),
                "{op} {args:x?}"
            );
        }
    }
    assert_eq!(ops, 38);
}

#[test]
fn operands_of_commutative_opcodes_may_change_places() {
    let values = [floats(), INTEGERS.to_vec()].concat();
    for &op in Opcode::ALL.iter().filter(|op| op.is_pure()) {
        let operands = op.info().operands;
        if operands.len() < 2 || operands[0] != operands[1] {
            continue;
        }
        let mut differs = false;
        for (&a, &b) in values
            .iter()
            .flat_map(|a| values.iter().map(move |b| (a, b)))
        {
            let run = |x, y| {
                eval(
                    op,
                    &[V4([x; 4]), V4([y; 4]), V4::word(9)],
                    0,
                    &Precision::EXACT,
                )
            };
            differs |= run(a, b) != run(b, a);
        }
        assert_eq!(!differs, op.info().commutative, "{op}");
    }
}

#[test]
fn lane_traffic() {
    let (a, b) = (V4([10, 11, 12, 13]), V4([20, 21, 22, 23]));
    let run = |op, args: &[V4], imm| {
        let value = eval(op, args, imm, &Precision::EXACT).expect("no division");
        value.expect("it computes")
    };
    assert_eq!(run(Opcode::Vsplat, &[b], 0), V4([20; 4]));
    assert_eq!(run(Opcode::Vmov, &[b], 0), b);
    for lane in 0..4 {
        let k = lane as usize;
        assert_eq!(run(Opcode::Vext, &[a], lane), V4::word(a.0[k]));
        let mut expected = a;
        expected.0[k] = 99;
        assert_eq!(run(Opcode::Vins, &[a, V4::word(99)], lane), expected);
    }
    for imm in 0..256 {
        let lanes = [imm % 4, imm / 4 % 4, imm / 16 % 4, imm / 64].map(|k| 10 + k as u32);
        assert_eq!(run(Opcode::Swz, &[a], imm), V4(lanes));
    }
    let mask = V4([u32::MAX, 0, 0xffff_0000, 0x0000_0001]);
    let blended = V4([10, 21, 22, (13 & 1) | (23 & !1)]);
    assert_eq!(run(Opcode::Vblend, &[mask, a, b], 0), blended);
}

/// Dot products round every step: the order shows in the last place.
#[test]
fn dot_products_round_each_step_in_order() {
    let mut random = Random(3);
    for _ in 0..rounds(10_000) {
        let vector = |random: &mut Random| V4([(); 4].map(|()| random.near_one(4)));
        let (a, b) = (vector(&mut random), vector(&mut random));
        let product = |k: usize| f32::from_bits(a.0[k]) * f32::from_bits(b.0[k]);
        let three = (product(0) + product(1)) + product(2);
        for (op, expected) in [(Opcode::Dot3, three), (Opcode::Dot4, three + product(3))] {
            let value = eval(op, &[a, b], 0, &Precision::EXACT);
            assert_eq!(value, Ok(Some(V4::word(expected.to_bits()))));
        }
    }
}

#[test]
fn every_computing_opcode_has_a_test_here_or_beside() {
    use Opcode::*;
    let by_name = [
        Div, Divu, Rem, Remu, Pand, Por, Pxor, Pnot, Ptoi, Pmov, Psel, Sel, Mov, Vsel, Vsplat,
        Vmov, Vext, Vins, Swz, Vblend, Dot3, Dot4, Rcp, Rsqrt, Sqrt, Exp2, Log2, Sin, Cos, RcpFast,
        RsqrtFast, SqrtFast, FdivFast,
    ];
    // `formats.rs` has these against exact arithmetic, `host.rs` against C.
    let of_halves = |op: Opcode| op.class() == Class::Pair;
    for &op in Opcode::ALL.iter().filter(|op| op.is_pure()) {
        let covered = wide(op, 1, 1).is_some()
            || scalar_of(op).is_some()
            || by_name.contains(&op)
            || of_halves(op)
            || crate::ieee::COVERED.contains(&op);
        assert!(covered, "{op}");
        assert!(op.result().is_some_and(|ty| Ty::ALL.contains(&ty)));
    }
}
