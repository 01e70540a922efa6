//! Narrow formats: rounding against all numbers of a format, and what a machine file makes of them.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::{Approx, Arch, Precision, Refine, Subnormals};
use srp_archdesc::format::{Format, Formats};
use srp_archdesc::isa::Opcode;
use srp_archdesc::machines;
use srp_archdesc::ops::semantics::word::narrow;
use srp_archdesc::ops::{self, Value};
use srp_archdesc::structure::{Special, Structure};

fn word(format: Format, flushes: bool) -> u32 {
    format.exponent | format.significand << 8 | u32::from(flushes) << 16
}

/// All numbers of a format that are not negative, by the definition of IEEE 754: 3.3 and 3.4.
fn numbers(format: Format) -> Vec<f64> {
    let stored = format.significand - 1;
    let bias = (1 << (format.exponent - 1)) - 1;
    let ends = (1u32 << format.exponent) - 1;
    let of = |exponent: u32, fraction: u32| {
        let part = f64::from(fraction) / f64::from(1u32 << stored);
        match exponent {
            0 => part * 2f64.powi(1 - bias),
            _ => (1.0 + part) * 2f64.powi(exponent as i32 - bias),
        }
    };
    let of_exponent = |e: u32| (0..1u32 << stored).map(move |f| of(e, f));
    (0..ends).flat_map(of_exponent).collect()
}

/// The nearest of some numbers that rise, of two the one whose place is even; infinite beyond the last by half a step.
fn nearest(numbers: &[f64], x: f64) -> f64 {
    let step = numbers[numbers.len() - 1] - numbers[numbers.len() - 2];
    let above = numbers.partition_point(|&n| n < x);
    let upper = match numbers.get(above) {
        Some(&upper) => upper,
        None => numbers[above - 1] + step,
    };
    let rounded = match above {
        0 => 0,
        _ if x - numbers[above - 1] < upper - x => above - 1,
        _ if x - numbers[above - 1] > upper - x => above,
        _ => above - above % 2,
    };
    numbers.get(rounded).copied().unwrap_or(f64::INFINITY)
}

#[test]
fn every_number_is_rounded_to_the_nearest() {
    let mut random = Pcg32::new(std::process::id().into(), 5);
    let others = ["e4m3", "e5m2", "e6m9", "e8m1", "e7m10"];
    let others = others.map(|name| Format::parse(name).expect("a format"));
    let named = [Format::HALF, Format::BFLOAT16, Format::TF32];
    for format in named.into_iter().chain(others) {
        let numbers = numbers(format);
        let least = numbers
            .iter()
            .copied()
            .find(|&n| n >= format.least_normal());
        assert_eq!(least, Some(format.least_normal()), "{}", format.name());
        assert_eq!(numbers.last(), Some(&format.largest()), "{}", format.name());
        let check = |bits: u32| {
            let x = f32::from_bits(bits);
            for flushes in [false, true] {
                let found = f32::from_bits(narrow(bits, word(format, flushes)));
                if x.is_nan() {
                    assert!(found.is_nan());
                    continue;
                }
                let magnitude = f64::from(x.abs());
                let wanted = match flushes && magnitude < format.least_normal() {
                    true => 0.0,
                    false if x.is_infinite() => f64::INFINITY,
                    false => nearest(&numbers, magnitude),
                };
                let name = format.name();
                assert_eq!(f64::from(found.abs()), wanted, "{x:e} in {name} {flushes}");
                assert_eq!(
                    found.is_sign_negative(),
                    x.is_sign_negative(),
                    "{x:e} in {name}"
                );
            }
        };
        for _ in 0..20_000 {
            check(random.next_u32());
            // Near a number, and near the middle of two.
            let at = random.next_u32() as usize % (numbers.len() - 1);
            for near in [numbers[at], 0.5 * (numbers[at] + numbers[at + 1])] {
                let bits = (near as f32).to_bits();
                (0..5).for_each(|off| check((bits + off).saturating_sub(2)));
            }
        }
        [
            0,
            1,
            0x8000_0000,
            0x007f_ffff,
            0x7f7f_ffff,
            0x7f80_0000,
            0x7fc0_0000,
        ]
        .into_iter()
        .for_each(check);
    }
}

#[test]
fn sums_and_products_are_rounded_once() {
    let mut random = Pcg32::new(std::process::id().into(), 6);
    let mut precision = sgrt("").precision;
    for format in [Format::HALF, Format::BFLOAT16, Format::TF32] {
        let numbers = numbers(format);
        precision.formats.add = format;
        precision.formats.multiply = format;
        for _ in 0..50_000 {
            let mut pick = || {
                let n = numbers[random.next_u32() as usize % numbers.len()] as f32;
                if random.next_u32() & 1 == 0 { n } else { -n }
            };
            let (x, y) = (pick(), pick());
            for (op, exact) in [
                (Opcode::Fadd, f64::from(x) + f64::from(y)),
                (Opcode::Fsub, f64::from(x) - f64::from(y)),
                (Opcode::Fmul, f64::from(x) * f64::from(y)),
            ] {
                // Sums of far exponents are not exact in binary64, and then far from the middle of two numbers. Below
                // its normal numbers, binary32 has too few digits for all products.
                let exact = match exact.abs() < f64::from(f32::MIN_POSITIVE) {
                    true => f64::from(exact as f32),
                    false => exact,
                };
                let args = [Value::word(x.to_bits()), Value::word(y.to_bits())];
                let found = ops::eval(op, &args, 0, &precision).expect("a result");
                let found = f32::from_bits(found.expect("a value").as_word());
                let wanted = nearest(&numbers, exact.abs());
                assert_eq!(
                    f64::from(found.abs()),
                    wanted,
                    "{x:e} {op} {y:e}, {}",
                    format.name()
                );
            }
        }
    }
}

/// The exception that `docs/numerics.md` states.
#[test]
fn products_below_binary32s_normal_numbers_may_be_rounded_twice() {
    let mut precision = sgrt("").precision;
    let product = |precision: &_, x: f64, y: f64| {
        let args = [x, y].map(|x| Value::word((x as f32).to_bits()));
        let found = ops::eval(Opcode::Fmul, &args, 0, precision).expect("a result");
        f64::from(f32::from_bits(found.expect("a value").as_word()))
    };
    let (x, y) = (1044.0 * 2f64.powi(-80), 2009.0 * 2f64.powi(-78));
    precision.formats.multiply = Format::TF32;
    let once = nearest(&numbers(Format::TF32), x * y);
    let twice = nearest(&numbers(Format::TF32), f64::from((x * y) as f32));
    assert_ne!(once, twice);
    assert_eq!(product(&precision, x, y), twice);
    // Eight digits are few enough.
    precision.formats.multiply = Format::BFLOAT16;
    let numbers = numbers(Format::BFLOAT16);
    for (a, b) in (128..256).flat_map(|a| (a..256).map(move |b| (a, b))) {
        for shift in 146..150 {
            let (x, y) = (
                f64::from(a) * 2f64.powi(-74),
                f64::from(b) * 2f64.powi(74 - shift),
            );
            assert_eq!(
                product(&precision, x, y),
                nearest(&numbers, x * y),
                "{x:e} {y:e}"
            );
        }
    }
}

fn sgrt(float: &str) -> Arch {
    let text = machines::SGRT
        .xml
        .replace("<array ", &format!("{float}<array "));
    srp_archdesc::parse("sgrt", &text).unwrap_or_else(|e| panic!("{e:?}"))
}

#[test]
fn a_format_moves_cycles_area_and_energy() {
    let plain = sgrt("");
    let narrow =
        sgrt("<float add=\"bfloat16\" multiply=\"half\" fused=\"e5m2\" subnormals=\"flush\"/>");
    assert_eq!(narrow.precision.formats.add, Format::BFLOAT16);
    assert_eq!(narrow.precision.subnormals, Subnormals::Flush);
    let written = srp_archdesc::xml::write(&narrow);
    assert_eq!(
        srp_archdesc::parse("written", &written).ok().as_ref(),
        Some(&narrow)
    );
    let area = |arch: &Arch| srp_archdesc::chip::srp(arch).total_mm2;
    assert!(
        area(&narrow) < 0.97 * area(&plain),
        "{} {}",
        area(&narrow),
        area(&plain)
    );
    for op in [Opcode::Fadd, Opcode::Vfmul, Opcode::Fma, Opcode::Dot3] {
        let energy = |arch: &Arch| srp_archdesc::chip::operation_energy(op, arch);
        assert!(energy(&narrow) < 0.6 * energy(&plain), "{op}");
    }
    let latency = |arch: &Arch, op: Opcode| {
        let units = arch.srp.fus.values();
        let cycles = units.filter_map(|fu| fu.timing(op).map(|how| how.latency));
        cycles.min().expect("a unit")
    };
    assert_eq!(
        (latency(&plain, Opcode::Fma), latency(&narrow, Opcode::Fma)),
        (4, 3)
    );
    assert_eq!(
        (
            latency(&plain, Opcode::Dot3),
            latency(&narrow, Opcode::Dot3)
        ),
        (6, 4)
    );
    // What compares is as it was.
    assert_eq!(
        latency(&narrow, Opcode::Fmin),
        latency(&plain, Opcode::Fmin)
    );
    // Cycles that the file gives stand.
    let given = machines::SGRT
        .xml
        .replace("<op class=\"fma\"/>", "<op class=\"fma\" latency=\"4\"/>");
    let given = given.replace("<array ", "<float fused=\"e5m2\"/><array ");
    let given = srp_archdesc::parse("given", &given).expect("a machine");
    assert_eq!(latency(&given, Opcode::Fma), 4);
}

/// A half as a whole number of 2⁻²⁴; `None` for infinities and NaNs.
fn units(half: u32) -> Option<i128> {
    let (exponent, fraction) = (half >> 10 & 0x1f, i128::from(half & 0x3ff));
    let magnitude = match exponent {
        0 => fraction,
        31 => return None,
        _ => (1024 + fraction) << (exponent - 1),
    };
    Some(if half & 0x8000 != 0 {
        -magnitude
    } else {
        magnitude
    })
}

/// The half nearest to a whole number of 2⁻⁴⁸, without its sign.
fn nearest_half(value: i128) -> u32 {
    let magnitude = value.abs();
    let mut bits = 0;
    // The halves rise with their bits.
    for bit in (0..15).rev() {
        let candidate = bits | 1 << bit;
        if units(candidate).is_some_and(|u| u << 24 <= magnitude) {
            bits = candidate;
        }
    }
    let below = units(bits).expect("a number") << 24;
    let above = units(bits + 1).map_or(1 << 64, |u| u << 24);
    match (magnitude - below).cmp(&(above - magnitude)) {
        std::cmp::Ordering::Less => bits,
        std::cmp::Ordering::Greater => bits + 1,
        std::cmp::Ordering::Equal => bits + bits % 2,
    }
}

#[test]
fn pairs_of_halves_are_rounded_once() {
    use srp_archdesc::ops::semantics::word::{hadd, hfma, hhigh, hlow, hmul, hpack, hsub};
    for half in 0..1u32 << 16 {
        let float = f32::from_bits(hlow(half));
        assert_eq!(hhigh(half << 16), hlow(half));
        match units(half) {
            Some(units) => assert_eq!(f64::from(float), units as f64 / 2f64.powi(24)),
            None => assert!(!float.is_finite() && float.is_nan() == (half & 0x3ff != 0)),
        }
        let back = if float.is_nan() { 0x7e00 } else { half };
        assert_eq!(hpack(float.to_bits(), 0), back, "{half:x}");
        assert_eq!(hpack(0, float.to_bits()), back << 16, "{half:x}");
    }
    let seed = u64::from(std::process::id());
    let mut random = Pcg32::new(seed, 9);
    let mut rounded = 0;
    for _ in 0..400_000 {
        // Numbers near each other in magnitude and far from it, of both signs.
        let mut pick = || match random.next_u32() % 3 {
            0 => 0x3c00 ^ (random.next_u32() & 0x83ff),
            1 => random.next_u32() & 0x83ff,
            _ => random.next_u32() & 0xffff,
        };
        let (a, b, c) = (pick(), pick(), pick());
        let (Some(x), Some(y), Some(z)) = (units(a), units(b), units(c)) else {
            continue;
        };
        let cases = [
            (hadd(a, b), (x + y) << 24),
            (hsub(a, b), (x - y) << 24),
            (hmul(a, b), x * y),
            (hfma(a, b, c), x * y + (z << 24)),
        ];
        for (found, exact) in cases {
            let expected = nearest_half(exact);
            let sign = if exact < 0 { 0x8000 } else { 0 };
            rounded += u32::from(units(expected).is_none_or(|u| u << 24 != exact.abs()));
            let found = match exact {
                // The signs of zeros are those of binary32.
                0 => found & 0x7fff,
                _ => found & 0xffff,
            };
            assert_eq!(found, expected | sign, "seed {seed}: {a:x} {b:x} {c:x}");
        }
    }
    assert!(rounded > 100_000, "{rounded} results were not exact");
}

/// A reciprocal, or a root or its reciprocal, with steps that are operations of the machine: Newton's, as
/// `ir/src/pass/refine.rs` writes them.
fn in_code(special: Special, x: f32, precision: &Precision) -> f32 {
    let calc = |op: Opcode, args: &[f32]| {
        let args: Vec<Value> = args.iter().map(|x| Value::word(x.to_bits())).collect();
        let value = ops::eval(op, &args, 0, precision).expect("it is an operation of floats");
        f32::from_bits(value.expect("it has a result").as_word())
    };
    use Opcode::{Fma, Fmul, Fsub};
    let Approx::Table { steps, fused, .. } = precision.of(special) else {
        unreachable!("it is approximate")
    };
    let is_reciprocal = special == Special::Rcp;
    let first = if is_reciprocal {
        Opcode::Rcp
    } else {
        Opcode::Rsqrt
    };
    let y = (0..steps).fold(calc(first, &[x]), |y, _| {
        let (along, part) = match is_reciprocal {
            true => (x, y),
            false => (calc(Fmul, &[x, y]), calc(Fmul, &[y, 0.5])),
        };
        match fused {
            true => calc(Fma, &[part, calc(Fma, &[-along, y, 1.0]), y]),
            false => {
                let (square, whole) = (
                    calc(Fmul, &[along, y]),
                    if is_reciprocal { 2.0 } else { 3.0 },
                );
                calc(Fmul, &[part, calc(Fsub, &[whole, square])])
            }
        }
    });
    match special {
        Special::Sqrt => calc(Fmul, &[x, y]),
        _ => y,
    }
}

#[test]
fn steps_in_code_keep_to_the_bound_of_their_formats() {
    let mut random = Pcg32::new(std::process::id().into(), 9);
    let format = |name| Format::parse(name).expect("a format");
    let (single, coarse) = (Format::SINGLE, format("e8m4"));
    for [add, multiply, fused] in [
        [single; 3],
        [Format::TF32; 3],
        [Format::BFLOAT16; 3],
        [Format::BFLOAT16, Format::BFLOAT16, Format::TF32],
        [single, Format::BFLOAT16, single],
        [coarse; 3],
    ] {
        for (special, way, steps) in [Special::Rcp, Special::Rsqrt, Special::Sqrt]
            .into_iter()
            .flat_map(|special| [true, false].map(|way| (special, way)))
            .flat_map(|(special, way)| [1, 2].map(|steps| (special, way, steps)))
        {
            let approx = Approx::Table {
                structure: Structure::Table,
                bits: 8,
                steps,
                fused: way,
                refine: Refine::Code,
            };
            let precision = Precision {
                rcp: approx,
                rsqrt: approx,
                sqrt: approx,
                formats: Formats {
                    add,
                    multiply,
                    fused,
                },
                ..Precision::EXACT
            };
            let bound = precision.error_in_code(special);
            let worst = (0..4000).fold(0f64, |worst, _| {
                let x = f32::from_bits(0x3000_0000 + random.next_u32() % 0x1f00_0000);
                let exact = match special {
                    Special::Rcp => 1.0 / f64::from(x),
                    Special::Rsqrt => 1.0 / f64::from(x).sqrt(),
                    _ => f64::from(x).sqrt(),
                };
                let off = f64::from(in_code(special, x, &precision)) / exact - 1.0;
                worst.max(off.abs())
            });
            let what = format!("{special:?}, {way}, {steps} of {add:?}, {multiply:?}, {fused:?}");
            assert!(worst <= bound, "{what}: {worst:e}, at most {bound:e}");
            // Five digits leave no room for bounds that are linear in what rounds.
            assert!(
                add == coarse || 20.0 * worst > bound,
                "{what}: {worst:e}, at most {bound:e}"
            );
        }
    }
}
