//! Functions of numbers, in binary64 and in integers.

use super::is_rounded;
use crate::hard_cases::call::texel;
use crate::hard_cases::catalogue::Case;

/// Checks that the numbers of a case are those of its oracle.
pub(super) fn check(case: &Case) -> Result<(), String> {
    if case.call == "bytes" {
        return bytes(case);
    }
    let stated = case.numbers();
    if let Some(word) = integer(case) {
        let found = stated[0].to_bits();
        return match found == word {
            true => Ok(()),
            false => Err(format!("{found:#x}, not {word:#x}")),
        };
    }
    let values = values(case).ok_or("there is no oracle for it")?;
    // Tables of the texture unit have 24 bits.
    let slack = if case.call == "texture" {
        2f64.powi(-24)
    } else {
        0.0
    };
    let right = |(&stated, &value): (&f32, &f64)| {
        is_rounded(stated, value) || (f64::from(stated) - value).abs() <= slack
    };
    match stated.len() == values.len() && stated.iter().zip(&values).all(right) {
        true => Ok(()),
        false => Err(format!("{stated:?}, not {values:?}")),
    }
}

fn integer(case: &Case) -> Option<u32> {
    let [x] = case.floats("of");
    match case.call.as_str() {
        "ftoi" => Some(x as i32 as u32),
        "ftou" => Some(x as u32),
        _ => None,
    }
}

fn vector(case: &Case, name: &str) -> [f64; 3] {
    case.floats::<3>(name).map(f64::from)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the values in binary64.
fn values(case: &Case) -> Option<Vec<f64>> {
    let [a, b, c] = case.floats("of");
    let [x, y, z] = [a, b, c].map(f64::from);
    let flag = |is: bool| f64::from(u8::from(is));
    let [bits] = case.words("of");
    Some(match case.call.as_str() {
        "unit" | "plain-unit" => {
            let of = [x, y, z];
            let length = dot(of, of).sqrt();
            match length > 0.0 {
                true => of.map(|v| v / length).to_vec(),
                false => vector(case, "else").to_vec(),
            }
        }
        // Products of two floats are exact.
        "difference" => {
            let [a, b, c, d] = case.floats("of").map(f64::from);
            vec![a * b - c * d]
        }
        "mirror" => {
            let (of, at) = ([x, y, z], vector(case, "at"));
            let twice = 2.0 * dot(of, at);
            [0, 1, 2].map(|i| of[i] - at[i] * twice).to_vec()
        }
        "power" | "powf" => vec![x.powf(y)],
        "rcp" => vec![1.0 / x],
        // The sign of a zero is kept.
        "rsqrt" if x == 0.0 => vec![1.0 / x],
        "rsqrt" => vec![1.0 / x.sqrt()],
        "sqrt" | "sqrtf" => vec![x.sqrt()],
        "exp2" | "exp2f" => vec![x.exp2()],
        "log2" | "log2f" => vec![x.log2()],
        "sin" | "sinf" => vec![x.sin()],
        "cos" | "cosf" => vec![x.cos()],
        "floor" => vec![x.floor()],
        "min" | "fminf" => vec![minimum(x, y)],
        "max" | "fmaxf" => vec![-minimum(-x, -y)],
        // One rounding from binary64, where it is exact, or next to it.
        "fma" => vec![f64::from(a.mul_add(b, c))],
        "add" => vec![x + y],
        "sub" => vec![x - y],
        "mul" => vec![x * y],
        "div" => vec![x / y],
        "abs" => vec![x.abs()],
        "itof" => vec![f64::from(bits as i32)],
        "utof" => vec![f64::from(bits)],
        "less" => vec![flag(x < y)],
        "less-equal" => vec![flag(x <= y)],
        "equal" => vec![flag(x == y)],
        "not-greater" => vec![flag(x <= y || x.is_nan() || y.is_nan())],
        "chain" => vec![match x > y {
            true => 3.0,
            false => 1.0,
        }],
        // Rust contracts nothing and keeps the order.
        "cross-self" => vec![0.0; 3],
        "square-less-square" => vec![0.0],
        "add-subtract" => vec![f64::from((a + b) - a)],
        "add-right" => vec![f64::from(a + (b + c))],
        "third" => vec![x / 3.0],
        "half-twice" => vec![f64::from(0.5 * a * 2.0)],
        "guarded-quotient" if y == 0.0 => vec![0.0],
        "guarded-quotient" => vec![x / y],
        "folded-reciprocal" => vec![1.0],
        "folded-sum" => vec![f64::from(0.1f32 + 0.2f32)],
        "fraction" => vec![f64::from(bits >> 8) / f64::from(1 << 24)],
        "scrambled-fraction" => vec![f64::from(scrambled(bits) >> 8) / f64::from(1 << 24)],
        "radical-inverse" => vec![first_24(radical_inverse(bits))],
        "sequence-x" => vec![place(bits, 0xc13f_a9a9, PLASTIC.recip())?],
        "sequence-y" => vec![place(bits, 0x91e1_0da5, PLASTIC.powi(-2))?],
        "bounce" => bounce(case).to_vec(),
        // The density of the direction cancels: there is nothing to divide by.
        "bounce-weight" => vector(case, "diffuse").to_vec(),
        "sum" => sum(case)?,
        "expf" => vec![x.exp()],
        "logf" => vec![x.ln()],
        "log10f" => vec![x.log10()],
        "tanf" => vec![x.tan()],
        "asinf" => vec![x.asin()],
        "acosf" => vec![x.acos()],
        "atanf" => vec![x.atan()],
        "atan2f" => vec![x.atan2(y)],
        "sinhf" => vec![x.sinh()],
        "coshf" => vec![x.cosh()],
        "tanhf" => vec![x.tanh()],
        "cbrtf" => vec![x.cbrt()],
        "hypotf" => vec![x.hypot(y)],
        "fmodf" => vec![x % y],
        "rintf" => vec![x.round_ties_even()],
        "roundf" => vec![x.round()],
        "texture" => texture(case),
        "phong" => phong(case),
        _ => return None,
    })
}

/// A NaN gives the other operand, and -0 is below 0.
fn minimum(x: f64, y: f64) -> f64 {
    match (x.is_nan(), y.is_nan()) {
        (true, _) => y,
        (_, true) => x,
        _ if x == y => match x.is_sign_negative() {
            true => x,
            false => y,
        },
        _ => x.min(y),
    }
}

/// The hash of 32 bits of Wellons (2018), `lowbias32`.
fn scrambled(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// The root of x³ = x + 1. The R2 sequence is made of its powers (Roberts 2018).
const PLASTIC: f64 = 1.324_717_957_244_746;

/// The digits of a number in base 2, mirrored at the point: exact.
fn radical_inverse(number: u32) -> f64 {
    let digit = |i: u32| f64::from(number >> i & 1) * 0.5f64.powi(i as i32 + 1);
    (0..32).map(digit).sum()
}

/// Returns the first 24 bits after the point of a number below 1.
fn first_24(x: f64) -> f64 {
    (x * f64::from(1 << 24)).floor() / f64::from(1 << 24)
}

/// A multiple of `step` in units of 2^-32, less its whole part; `None` where that is off the multiple of
/// the real number by more than the bits that the step lacks come to.
fn place(number: u32, step: u32, real: f64) -> Option<f64> {
    let product = u64::from(number) * u64::from(step) % (1 << 32);
    let exact = product as f64 / 2f64.powi(32);
    let off = (exact - f64::from(number) * real).rem_euclid(1.0);
    let bound = f64::from(number) * 2f64.powi(-32) + 1e-6;
    (off.min(1.0 - off) <= bound).then(|| first_24(exact))
}

/// The direction in which a surface scatters light, of the density of the cosine, in the basis of Duff et
/// al. (2017); and that a ray is sent.
fn bounce(case: &Case) -> [f64; 4] {
    let [seed] = case.words("seed");
    let bits = scrambled(seed.wrapping_mul(0x9e37_79b9));
    let fraction = |bits: u32| f64::from(bits >> 8) / f64::from(1 << 24);
    let (angle, y) = (
        std::f64::consts::TAU * fraction(bits),
        fraction(bits.wrapping_mul(0x2545_f491)),
    );
    let n = vector(case, "normal");
    let sign = if n[2] < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    let u = [1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]];
    let v = [b, sign + n[1] * n[1] * a, -n[1]];
    let (x, y, z) = (
        y.sqrt() * angle.cos(),
        y.sqrt() * angle.sin(),
        (1.0 - y).sqrt(),
    );
    let [i, j, k] = [0, 1, 2].map(|i| u[i] * x + v[i] * y + n[i] * z);
    [i, j, k, 1.0]
}

/// Light that comes many times, added one by one in binary32; `None` where the sum ever becomes less, or is
/// off by more than u of itself each time.
fn sum(case: &Case) -> Option<Vec<f64>> {
    let [.., times] = case.floats::<4>("of");
    let channel = |(from, light): (f32, f32)| {
        let (mut sum, mut exact) = (from, f64::from(from));
        for i in 1..=times as u32 {
            let next = sum + light;
            exact += f64::from(light);
            let bound = f64::from(i) * f64::from(next) / f64::from(1 << 24);
            if next < sum || (exact - f64::from(next)).abs() > bound {
                return None;
            }
            sum = next;
        }
        Some(f64::from(sum))
    };
    let pairs = case.floats::<3>("from").into_iter();
    pairs.zip(case.floats::<3>("of")).map(channel).collect()
}

/// sRGB to linear (IEC 61966-2-1).
fn linear(byte: u32) -> f64 {
    let c = f64::from(byte) / 255.0;
    match c <= 0.04045 {
        true => c / 12.92,
        false => ((c + 0.055) / 1.055).powf(2.4),
    }
}

/// Bilinear filtering with weights of any number of bits, of the level that is nearest to the third coordinate.
fn texture(case: &Case) -> Vec<f64> {
    let [width, height, clamp, levels] = case.floats("size").map(|x: f32| x as i64);
    if width == 0 {
        return vec![1.0; 4];
    }
    let [u, v, detail] = case.floats("at");
    let level = match detail {
        d if d.is_nan() => 0,
        // Half way up; what is out of range stays so.
        d => ((f64::from(d) + 0.5).floor() as i64).clamp(0, levels),
    };
    let [width, height] = [width, height].map(|side| (side >> level).max(1));
    let between = |c: f32, n: i64| -> ([i64; 2], f64) {
        let edge = if c < 0.0 { 0 } else { n - 1 };
        let c = match c {
            c if c.is_nan() => 0.0,
            c if c.abs() >= 8_388_608.0 && clamp != 0 => return ([edge; 2], 0.0),
            c if c.abs() >= 8_388_608.0 => 0.0,
            c => f64::from(c),
        };
        // Exact: 24 bits times at most 16, and a half that they reach down to or nearly.
        let place = c * n as f64 - 0.5;
        let first = place.floor();
        let texel = |i: i64| match clamp != 0 {
            true => i.clamp(0, n - 1),
            false => i.rem_euclid(n),
        };
        let first_texel = first as i64;
        ([texel(first_texel), texel(first_texel + 1)], place - first)
    };
    let ((xs, a), (ys, b)) = (between(u, width), between(v, height));
    let channel = |c: u32| {
        let value = |x: i64, y: i64| {
            let byte = texel(level as u32, x as u32, y as u32) >> (8 * c) & 255;
            if c == 3 {
                f64::from(byte) / 255.0
            } else {
                linear(byte)
            }
        };
        let row = |y: i64| value(xs[0], y) * (1.0 - a) + value(xs[1], y) * a;
        row(ys[0]) * (1.0 - b) + row(ys[1]) * b
    };
    (0..4).map(channel).collect()
}

/// Phong's model, as docs/shading.md has it.
fn phong(case: &Case) -> Vec<f64> {
    let [to, normal, geometric, back] =
        ["light", "normal", "geometric", "back"].map(|name| vector(case, name));
    let [diffuse, colour] = ["diffuse", "colour"].map(|name| vector(case, name));
    let [.., exponent] = case.floats::<4>("specular").map(f64::from);
    let specular = vector(case, "specular");
    let length = dot(to, to).sqrt();
    let to = to.map(|v| v / length);
    let along = dot(normal, to);
    if along <= 0.0 || dot(geometric, to) <= 0.0 {
        return vec![0.0; 4];
    }
    let mirrored = [0, 1, 2].map(|i| normal[i] * 2.0 * along - to[i]);
    let highlight = dot(mirrored, back).clamp(0.0, 1.0).powf(exponent);
    let light = |i: usize| colour[i] * (diffuse[i] * along + specular[i] * highlight);
    vec![light(0), light(1), light(2), 1.0]
}

/// Light to bytes: bent to white at 2, sRGB, the nearest byte.
fn bytes(case: &Case) -> Result<(), String> {
    let [r, g, b, scale] = case.floats("of").map(f64::from);
    let mut word = 0xff00_0000u32;
    for (i, light) in [r, g, b].into_iter().enumerate() {
        let light = match light.is_nan() {
            true => 0.0,
            false => (light * scale).clamp(0.0, 2.0),
        };
        let c = light * (1.0 - 0.25 * light);
        let curved = match c <= 0.0031308 {
            true => 12.92 * c,
            false => 1.055 * c.powf(1.0 / 2.4) - 0.055,
        };
        // From 2^-13 down everything is black.
        let level = if c < 2f64.powi(-13) {
            0.0
        } else {
            255.0 * curved
        };
        let off = (level - level.floor() - 0.5).abs();
        if level > 0.5 && level < 254.9 && off < 0.125 {
            return Err(format!("{level} is too close to half way between bytes"));
        }
        word |= (level.round() as u32) << (8 * i);
    }
    let stated = case.numbers().first().map(|x| x.to_bits());
    match stated == Some(word) {
        true => Ok(()),
        false => Err(format!("{stated:x?}, not {word:x}")),
    }
}
