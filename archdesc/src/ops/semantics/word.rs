//! Operations on words and predicates.
//!
//! A word is its bits, whatever an operation reads in them. Floats are binary32, rounded to
//! nearest even, denormals kept; a float result that is NaN is always [`NAN`], so that the bits of
//! a result never depend on the host.

/// The one NaN that operations give.
pub const NAN: u32 = 0x7fc0_0000;

#[inline(always)]
fn float(x: u32) -> f32 {
    f32::from_bits(x)
}

/// The bits of a result.
#[inline(always)]
pub fn canonical(x: f32) -> u32 {
    if x.is_nan() { NAN } else { x.to_bits() }
}

/// `a`.
#[inline(always)]
pub fn mov(a: u32) -> u32 {
    a
}

/// `a`.
#[inline(always)]
pub fn pmov(a: bool) -> bool {
    a
}

/// `a` where `p` is true, else `b`.
#[inline(always)]
pub fn sel(p: bool, a: u32, b: u32) -> u32 {
    if p { a } else { b }
}

/// `a` where `p` is true, else `b`.
#[inline(always)]
pub fn psel(p: bool, a: bool, b: bool) -> bool {
    if p { a } else { b }
}

/// Sum, wrapping.
#[inline(always)]
pub fn add(a: u32, b: u32) -> u32 {
    a.wrapping_add(b)
}

/// Difference, wrapping.
#[inline(always)]
pub fn sub(a: u32, b: u32) -> u32 {
    a.wrapping_sub(b)
}

/// Bitwise and.
#[inline(always)]
pub fn and(a: u32, b: u32) -> u32 {
    a & b
}

/// Bitwise or.
#[inline(always)]
pub fn or(a: u32, b: u32) -> u32 {
    a | b
}

/// Bitwise exclusive or.
#[inline(always)]
pub fn xor(a: u32, b: u32) -> u32 {
    a ^ b
}

/// `a` shifted left by `b` modulo 32.
#[inline(always)]
pub fn shl(a: u32, b: u32) -> u32 {
    a.wrapping_shl(b)
}

/// `a` shifted right by `b` modulo 32, zeros in.
#[inline(always)]
pub fn shr(a: u32, b: u32) -> u32 {
    a.wrapping_shr(b)
}

/// `a` shifted right by `b` modulo 32, sign bits in.
#[inline(always)]
pub fn sar(a: u32, b: u32) -> u32 {
    (a as i32).wrapping_shr(b) as u32
}

/// Signed minimum.
#[inline(always)]
pub fn min(a: u32, b: u32) -> u32 {
    (a as i32).min(b as i32) as u32
}

/// Signed maximum.
#[inline(always)]
pub fn max(a: u32, b: u32) -> u32 {
    (a as i32).max(b as i32) as u32
}

/// Unsigned minimum.
#[inline(always)]
pub fn minu(a: u32, b: u32) -> u32 {
    a.min(b)
}

/// Unsigned maximum.
#[inline(always)]
pub fn maxu(a: u32, b: u32) -> u32 {
    a.max(b)
}

/// True if the words are equal.
#[inline(always)]
pub fn eq(a: u32, b: u32) -> bool {
    a == b
}

/// True if the words differ.
#[inline(always)]
pub fn ne(a: u32, b: u32) -> bool {
    a != b
}

/// Signed less.
#[inline(always)]
pub fn lt(a: u32, b: u32) -> bool {
    (a as i32) < b as i32
}

/// Signed less or equal.
#[inline(always)]
pub fn le(a: u32, b: u32) -> bool {
    a as i32 <= b as i32
}

/// Unsigned less.
#[inline(always)]
pub fn ltu(a: u32, b: u32) -> bool {
    a < b
}

/// Unsigned less or equal.
#[inline(always)]
pub fn leu(a: u32, b: u32) -> bool {
    a <= b
}

/// Low word of the product.
#[inline(always)]
pub fn mul(a: u32, b: u32) -> u32 {
    a.wrapping_mul(b)
}

/// High word of the signed product.
#[inline(always)]
pub fn mulhs(a: u32, b: u32) -> u32 {
    ((i64::from(a as i32) * i64::from(b as i32)) >> 32) as u32
}

/// High word of the unsigned product.
#[inline(always)]
pub fn mulhu(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

/// Signed quotient, toward zero; −2³¹ / −1 wraps to −2³¹. 0 where the guard is false; `None` for a
/// division by zero where it is true.
#[inline(always)]
pub fn div(guard: bool, a: u32, b: u32) -> Option<u32> {
    match (guard, b) {
        (false, _) => Some(0),
        (true, 0) => None,
        (true, _) => Some((a as i32).wrapping_div(b as i32) as u32),
    }
}

/// Unsigned quotient; guard and zero as for [`div`].
#[inline(always)]
pub fn divu(guard: bool, a: u32, b: u32) -> Option<u32> {
    if guard { a.checked_div(b) } else { Some(0) }
}

/// Signed remainder, with the sign of `a`; −2³¹ by −1 leaves 0. Guard and zero as for [`div`].
#[inline(always)]
pub fn rem(guard: bool, a: u32, b: u32) -> Option<u32> {
    match (guard, b) {
        (false, _) => Some(0),
        (true, 0) => None,
        (true, _) => Some((a as i32).wrapping_rem(b as i32) as u32),
    }
}

/// Unsigned remainder; guard and zero as for [`div`].
#[inline(always)]
pub fn remu(guard: bool, a: u32, b: u32) -> Option<u32> {
    if guard { a.checked_rem(b) } else { Some(0) }
}

/// Both.
#[inline(always)]
pub fn pand(a: bool, b: bool) -> bool {
    a & b
}

/// Either.
#[inline(always)]
pub fn por(a: bool, b: bool) -> bool {
    a | b
}

/// One of both.
#[inline(always)]
pub fn pxor(a: bool, b: bool) -> bool {
    a ^ b
}

/// Not.
#[inline(always)]
pub fn pnot(a: bool) -> bool {
    !a
}

/// 1 where true, else 0.
#[inline(always)]
pub fn ptoi(a: bool) -> u32 {
    u32::from(a)
}

/// Sum.
#[inline(always)]
pub fn fadd(a: u32, b: u32) -> u32 {
    canonical(float(a) + float(b))
}

/// Difference.
#[inline(always)]
pub fn fsub(a: u32, b: u32) -> u32 {
    canonical(float(a) - float(b))
}

/// Minimum; −0 is less than +0, and a NaN gives the other operand.
#[inline(always)]
pub fn fmin(a: u32, b: u32) -> u32 {
    let (x, y) = (float(a), float(b));
    // Equal floats have equal bits, but for the two zeros.
    let unequal = if x < y { a } else { b };
    let ordered = if x == y { a | b } else { unequal };
    let number = if y.is_nan() { a } else { ordered };
    canonical(float(if x.is_nan() { b } else { number }))
}

/// Maximum; −0 is less than +0, and a NaN gives the other operand.
#[inline(always)]
pub fn fmax(a: u32, b: u32) -> u32 {
    let (x, y) = (float(a), float(b));
    let unequal = if x > y { a } else { b };
    let ordered = if x == y { a & b } else { unequal };
    let number = if y.is_nan() { a } else { ordered };
    canonical(float(if x.is_nan() { b } else { number }))
}

/// The other sign.
#[inline(always)]
pub fn fneg(a: u32) -> u32 {
    canonical(float(a ^ 0x8000_0000))
}

/// Without sign.
#[inline(always)]
pub fn fabs(a: u32) -> u32 {
    canonical(float(a & 0x7fff_ffff))
}

/// The largest integer not above; −0 stays −0.
#[inline(always)]
pub fn ffloor(a: u32) -> u32 {
    // From here on every float is an integer; and adding it to less rounds that to an integer.
    const INTEGERS: f32 = 8_388_608.0;
    let x = float(a);
    let sign = a & 0x8000_0000;
    let magnitude = float(a & 0x7fff_ffff);
    let nearest = float(((magnitude + INTEGERS) - INTEGERS).to_bits() | sign);
    let below = nearest - 1.0;
    let floor = if nearest > x { below } else { nearest };
    canonical(if magnitude < INTEGERS { floor } else { x })
}

/// Equal; false on NaN.
#[inline(always)]
pub fn feq(a: u32, b: u32) -> bool {
    float(a) == float(b)
}

/// Not equal; true on NaN.
#[inline(always)]
pub fn fne(a: u32, b: u32) -> bool {
    float(a) != float(b)
}

/// The float rounded to a narrower format, to nearest and ties to even: exponent bits in the lowest byte of `format`,
/// those of the significand with the hidden one in the next, and above them 1 where numbers below the normal ones are zeros.
/// Beyond the largest number, results are infinite; infinities and NaNs stay.
pub fn narrow(a: u32, format: u32) -> u32 {
    let (exponent, significand, flushes) = (format & 0xff, format >> 8 & 0xff, format >> 16 != 0);
    let (sign, magnitude) = (a & 0x8000_0000, a & 0x7fff_ffff);
    if magnitude >= 0x7f80_0000 {
        return a;
    }
    // Exponents with binary32's bias.
    let bias = (1 << (exponent - 1)) - 1;
    let least = 128 - bias;
    let own = (magnitude >> 23).max(1);
    if flushes && magnitude < least << 23 {
        return sign;
    }
    let hidden = u32::from(magnitude >= 0x0080_0000) << 23;
    let whole = magnitude & 0x007f_ffff | hidden;
    let dropped = 24 - significand + least.saturating_sub(own);
    if dropped > 25 {
        return sign;
    }
    if dropped == 0 {
        return a;
    }
    let (kept, rest, half) = (
        whole >> dropped,
        whole & ((1 << dropped) - 1),
        1 << (dropped - 1),
    );
    let up = rest > half || rest == half && kept & 1 == 1;
    // A whole number times a power of two, both exact in binary64.
    let power = f64::from_bits(u64::from(1023 + own + dropped - 150) << 52);
    let rounded = (f64::from(kept + u32::from(up)) * power) as f32;
    match rounded.to_bits() >> 23 > 127 + bias {
        true => sign | 0x7f80_0000,
        false => sign | rounded.to_bits(),
    }
}

/// The float, or, where it is subnormal, the zero of its sign.
#[inline(always)]
pub fn flush(a: u32) -> u32 {
    if a & 0x7f80_0000 == 0 {
        a & 0x8000_0000
    } else {
        a
    }
}

/// Less; false on NaN.
#[inline(always)]
pub fn flt(a: u32, b: u32) -> bool {
    float(a) < float(b)
}

/// Less or equal; false on NaN.
#[inline(always)]
pub fn fle(a: u32, b: u32) -> bool {
    float(a) <= float(b)
}

/// Product.
#[inline(always)]
pub fn fmul(a: u32, b: u32) -> u32 {
    canonical(float(a) * float(b))
}

/// True if the host that this is compiled for multiplies and adds in one instruction. Elsewhere [`fma`] gets
/// the same result from binary64.
pub(super) const FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

/// `a·b + c`, rounded once.
#[inline(always)]
pub fn fma(a: u32, b: u32, c: u32) -> u32 {
    if FUSED {
        return canonical(float(a).mul_add(float(b), float(c)));
    }
    let sum = product_sum(a, b, c);
    canonical(if may_round_twice(sum) {
        odd_sum(a, b, c) as f32
    } else {
        sum as f32
    })
}

/// `a·b + c` in binary64, where the product is exact and the sum is rounded.
#[inline(always)]
pub(super) fn product_sum(a: u32, b: u32, c: u32) -> f64 {
    f64::from(float(a)) * f64::from(float(b)) + f64::from(float(c))
}

/// True if rounding this sum to binary32 might differ from rounding the exact sum: a normal result only where
/// the sum lies half way between two floats, a denormal one in more ways.
#[inline(always)]
pub(super) fn may_round_twice(sum: f64) -> bool {
    const LEAST_NORMAL: u32 = 0x3810_0000;
    let low = sum.to_bits() as u32;
    let high = (sum.to_bits() >> 32) as u32 & 0x7fff_ffff;
    // Not 0 and less than the least normal float: 0 wraps to the largest word.
    let denormal = high.wrapping_sub(1) < LEAST_NORMAL - 1;
    (low & 0x1fff_ffff == 0x1000_0000) | denormal
}

/// [`product_sum`] rounded to odd where it is inexact, which makes a second rounding harmless
/// (Boldo and Melquiond, *Emulation of FMA and correctly rounded sums*, 2008).
#[cold]
#[inline(never)]
pub(super) fn odd_sum(a: u32, b: u32, c: u32) -> f64 {
    let product = f64::from(float(a)) * f64::from(float(b));
    let addend = f64::from(float(c));
    let sum = product + addend;
    let back = sum - product;
    let lost = (product - (sum - back)) + (addend - back);
    let even = sum.to_bits() & 1 == 0;
    // Where the sum is ∞ or NaN, what is lost is NaN.
    if even && lost.abs() > 0.0 {
        let outward = (lost > 0.0) == (sum > 0.0);
        f64::from_bits(if outward {
            sum.to_bits() + 1
        } else {
            sum.to_bits() - 1
        })
    } else {
        sum
    }
}

/// Signed integer to the nearest float.
#[inline(always)]
pub fn itof(a: u32) -> u32 {
    (a as i32 as f32).to_bits()
}

/// Unsigned integer to the nearest float.
#[inline(always)]
pub fn utof(a: u32) -> u32 {
    (a as f32).to_bits()
}

/// Float to signed integer: toward zero, saturating, 0 for NaN.
#[inline(always)]
pub fn ftoi(a: u32) -> u32 {
    float(a) as i32 as u32
}

/// Float to unsigned integer: toward zero, saturating, 0 for NaN.
#[inline(always)]
pub fn ftou(a: u32) -> u32 {
    float(a) as u32
}

/// Returns the result of a signed load of a byte.
#[inline(always)]
pub fn extend_byte(a: u32) -> u32 {
    a as u8 as i8 as u32
}

/// Returns the result of a signed load of two bytes.
#[inline(always)]
pub fn extend_half(a: u32) -> u32 {
    a as u16 as i16 as u32
}

/// binary16 in the words of [`narrow`].
const HALF: u32 = 5 | 11 << 8;

/// The float that the half in the lower bits is.
fn of_half(a: u32) -> u32 {
    let (sign, exponent, fraction) = ((a & 0x8000) << 16, a >> 10 & 0x1f, a & 0x3ff);
    match exponent {
        0 => sign | (fraction as f32 / 16_777_216.0).to_bits(),
        31 => canonical(float(sign | 0x7f80_0000 | fraction << 13)),
        _ => sign | (exponent + 112) << 23 | fraction << 13,
    }
}

/// The half that is nearest to a float.
fn to_half(a: u32) -> u32 {
    let rounded = narrow(a, HALF);
    let (sign, magnitude) = (rounded >> 16 & 0x8000, rounded & 0x7fff_ffff);
    match magnitude {
        0x7f80_0001.. => 0x7e00,
        0x7f80_0000 => sign | 0x7c00,
        0x3880_0000.. => sign | ((magnitude >> 13) - (112 << 10)),
        _ => sign | (float(magnitude) * 16_777_216.0) as u32,
    }
}

/// A function of floats of both halves of some words.
#[inline(always)]
fn of_pairs<const N: usize>(words: [u32; N], function: impl Fn([u32; N]) -> u32) -> u32 {
    let low = to_half(function(words.map(of_half)));
    let high = to_half(function(words.map(|word| of_half(word >> 16))));
    low | high << 16
}

/// Two floats as halves, the first in the lower bits.
pub fn hpack(a: u32, b: u32) -> u32 {
    to_half(a) | to_half(b) << 16
}

/// The half in the lower bits.
pub fn hlow(a: u32) -> u32 {
    of_half(a)
}

/// The half in the upper bits.
pub fn hhigh(a: u32) -> u32 {
    of_half(a >> 16)
}

/// Sums of halves: 24 bits hold enough of them to round once (Figueroa 1995).
pub fn hadd(a: u32, b: u32) -> u32 {
    of_pairs([a, b], |[a, b]| fadd(a, b))
}

/// Differences of halves.
pub fn hsub(a: u32, b: u32) -> u32 {
    of_pairs([a, b], |[a, b]| fsub(a, b))
}

/// Products of halves, which 24 bits hold exactly.
pub fn hmul(a: u32, b: u32) -> u32 {
    of_pairs([a, b], |[a, b]| fmul(a, b))
}

/// `a·b + c` of halves, rounded once.
pub fn hfma(a: u32, b: u32, c: u32) -> u32 {
    of_pairs([a, b, c], |[a, b, c]| {
        let sum = odd_sum(a, b, c);
        let nearest = sum as f32;
        let (bits, back) = (nearest.to_bits(), f64::from(nearest));
        // Odd where it is inexact, again: then rounding to 11 bits sees on which side of a tie it was.
        if back == sum || bits & 1 == 1 || sum.is_nan() {
            return canonical(nearest);
        }
        match back.abs() < sum.abs() {
            true => bits + 1,
            false => bits - 1,
        }
    })
}

/// The less of two halves, as [`fmin`].
pub fn hmin(a: u32, b: u32) -> u32 {
    of_pairs([a, b], |[a, b]| fmin(a, b))
}

/// The greater of two halves, as [`fmax`].
pub fn hmax(a: u32, b: u32) -> u32 {
    of_pairs([a, b], |[a, b]| fmax(a, b))
}
