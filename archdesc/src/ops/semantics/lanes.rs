//! Operations on vectors of four words.
//!
//! Written lane by lane without branches, so that a vectorising compiler sees four equal columns:
//! rustc does at `opt-level=3`, and at 1 with `-C passes=slp-vectorizer`.

use super::word;

/// Four words, lane 0 first. A narrower value lies in lane 0, the others zero.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[repr(C, align(16))]
pub struct V4(pub [u32; 4]);

impl V4 {
    /// A word as a value of any type.
    #[inline(always)]
    pub const fn word(a: u32) -> V4 {
        V4([a, 0, 0, 0])
    }

    /// A predicate as a value of any type: 1 or 0.
    #[inline(always)]
    pub const fn pred(a: bool) -> V4 {
        V4([a as u32, 0, 0, 0])
    }

    /// Lane 0.
    #[inline(always)]
    pub const fn as_word(self) -> u32 {
        self.0[0]
    }

    /// True if lane 0 is not 0.
    #[inline(always)]
    pub const fn as_pred(self) -> bool {
        self.0[0] != 0
    }
}

#[inline(always)]
fn each(a: V4, f: impl Fn(u32) -> u32) -> V4 {
    V4([f(a.0[0]), f(a.0[1]), f(a.0[2]), f(a.0[3])])
}

#[inline(always)]
fn pairs(a: V4, b: V4, f: impl Fn(u32, u32) -> u32) -> V4 {
    V4([
        f(a.0[0], b.0[0]),
        f(a.0[1], b.0[1]),
        f(a.0[2], b.0[2]),
        f(a.0[3], b.0[3]),
    ])
}

/// Each lane [rounded](word::narrow) to a narrower format.
pub fn vnarrow(a: V4, format: u32) -> V4 {
    each(a, |lane| word::narrow(lane, format))
}

/// Each lane, or, where it is a subnormal float, the zero of its sign.
#[inline(always)]
pub fn vflush(a: V4) -> V4 {
    each(a, word::flush)
}

/// −1 in the lanes where the relation holds, 0 in the others.
#[inline(always)]
fn mask(a: V4, b: V4, relation: impl Fn(u32, u32) -> bool) -> V4 {
    pairs(a, b, |x, y| if relation(x, y) { u32::MAX } else { 0 })
}

/// `a`.
#[inline(always)]
pub fn vmov(a: V4) -> V4 {
    a
}

/// `a` where `p` is true, else `b`.
#[inline(always)]
pub fn vsel(p: bool, a: V4, b: V4) -> V4 {
    if p { a } else { b }
}

/// The word in every lane.
#[inline(always)]
pub fn vsplat(a: u32) -> V4 {
    V4([a; 4])
}

/// Lane `lane` modulo 4.
#[inline(always)]
pub fn vext(a: V4, lane: u32) -> u32 {
    a.0[(lane & 3) as usize]
}

/// `a` with lane `lane` modulo 4 replaced by `b`.
#[inline(always)]
pub fn vins(mut a: V4, b: u32, lane: u32) -> V4 {
    a.0[(lane & 3) as usize] = b;
    a
}

/// Lane k of the result is lane `(lanes >> 2k) & 3` of `a`.
#[inline(always)]
pub fn swz(a: V4, lanes: u32) -> V4 {
    V4([
        vext(a, lanes),
        vext(a, lanes >> 2),
        vext(a, lanes >> 4),
        vext(a, lanes >> 6),
    ])
}

/// Bits of `a` where the mask is 1, of `b` where it is 0.
#[inline(always)]
pub fn vblend(mask: V4, a: V4, b: V4) -> V4 {
    let picked = pairs(mask, a, |m, x| m & x);
    let others = pairs(mask, b, |m, y| !m & y);
    pairs(picked, others, word::or)
}

/// Sums, wrapping.
#[inline(always)]
pub fn vadd(a: V4, b: V4) -> V4 {
    pairs(a, b, word::add)
}

/// Differences, wrapping.
#[inline(always)]
pub fn vsub(a: V4, b: V4) -> V4 {
    pairs(a, b, word::sub)
}

/// Bitwise and.
#[inline(always)]
pub fn vand(a: V4, b: V4) -> V4 {
    pairs(a, b, word::and)
}

/// Bitwise or.
#[inline(always)]
pub fn vor(a: V4, b: V4) -> V4 {
    pairs(a, b, word::or)
}

/// Bitwise exclusive or.
#[inline(always)]
pub fn vxor(a: V4, b: V4) -> V4 {
    pairs(a, b, word::xor)
}

/// [`word::shl`] of each lane.
#[inline(always)]
pub fn vshl(a: V4, b: V4) -> V4 {
    pairs(a, b, word::shl)
}

/// [`word::shr`] of each lane.
#[inline(always)]
pub fn vshr(a: V4, b: V4) -> V4 {
    pairs(a, b, word::shr)
}

/// [`word::sar`] of each lane.
#[inline(always)]
pub fn vsar(a: V4, b: V4) -> V4 {
    pairs(a, b, word::sar)
}

/// Signed minima.
#[inline(always)]
pub fn vmin(a: V4, b: V4) -> V4 {
    pairs(a, b, word::min)
}

/// Signed maxima.
#[inline(always)]
pub fn vmax(a: V4, b: V4) -> V4 {
    pairs(a, b, word::max)
}

/// Where the words are equal.
#[inline(always)]
pub fn veq(a: V4, b: V4) -> V4 {
    mask(a, b, word::eq)
}

/// Where signed less.
#[inline(always)]
pub fn vlt(a: V4, b: V4) -> V4 {
    mask(a, b, word::lt)
}

/// Where unsigned less.
#[inline(always)]
pub fn vltu(a: V4, b: V4) -> V4 {
    mask(a, b, word::ltu)
}

/// Low words of the products.
#[inline(always)]
pub fn vmul(a: V4, b: V4) -> V4 {
    pairs(a, b, word::mul)
}

/// Sums.
#[inline(always)]
pub fn vfadd(a: V4, b: V4) -> V4 {
    pairs(a, b, word::fadd)
}

/// Differences.
#[inline(always)]
pub fn vfsub(a: V4, b: V4) -> V4 {
    pairs(a, b, word::fsub)
}

/// [`word::fmin`] of each lane.
#[inline(always)]
pub fn vfmin(a: V4, b: V4) -> V4 {
    pairs(a, b, word::fmin)
}

/// [`word::fmax`] of each lane.
#[inline(always)]
pub fn vfmax(a: V4, b: V4) -> V4 {
    pairs(a, b, word::fmax)
}

/// The other signs.
#[inline(always)]
pub fn vfneg(a: V4) -> V4 {
    each(a, word::fneg)
}

/// Without signs.
#[inline(always)]
pub fn vfabs(a: V4) -> V4 {
    each(a, word::fabs)
}

/// [`word::ffloor`] of each lane.
#[inline(always)]
pub fn vffloor(a: V4) -> V4 {
    each(a, word::ffloor)
}

/// Where equal; not on NaN.
#[inline(always)]
pub fn vfeq(a: V4, b: V4) -> V4 {
    mask(a, b, word::feq)
}

/// Where not equal, or NaN.
#[inline(always)]
pub fn vfne(a: V4, b: V4) -> V4 {
    mask(a, b, word::fne)
}

/// Where less; not on NaN.
#[inline(always)]
pub fn vflt(a: V4, b: V4) -> V4 {
    mask(a, b, word::flt)
}

/// Where less or equal; not on NaN.
#[inline(always)]
pub fn vfle(a: V4, b: V4) -> V4 {
    mask(a, b, word::fle)
}

/// Signed integers to the nearest floats.
#[inline(always)]
pub fn vitof(a: V4) -> V4 {
    each(a, word::itof)
}

/// [`word::ftoi`] of each lane.
#[inline(always)]
pub fn vftoi(a: V4) -> V4 {
    each(a, word::ftoi)
}

/// Products.
#[inline(always)]
pub fn vfmul(a: V4, b: V4) -> V4 {
    pairs(a, b, word::fmul)
}

/// `a·b + c` of each lane, rounded once.
#[inline(always)]
pub fn vfma(a: V4, b: V4, c: V4) -> V4 {
    let of = |k: usize| (a.0[k], b.0[k], c.0[k]);
    let lanes = [of(0), of(1), of(2), of(3)];
    if word::FUSED {
        return V4(lanes.map(|(x, y, z)| word::fma(x, y, z)));
    }
    let sums = lanes.map(|(x, y, z)| word::product_sum(x, y, z));
    let [x, y, z, w] = sums.map(word::may_round_twice);
    if x | y | z | w {
        return vfma_lane_by_lane(a, b, c);
    }
    V4(sums.map(|sum| word::canonical(sum as f32)))
}

#[cold]
#[inline(never)]
fn vfma_lane_by_lane(a: V4, b: V4, c: V4) -> V4 {
    let lane = |k: usize| word::fma(a.0[k], b.0[k], c.0[k]);
    V4([lane(0), lane(1), lane(2), lane(3)])
}

/// `(x·x′ + y·y′) + z·z′`, each step rounded.
#[inline(always)]
pub fn dot3(a: V4, b: V4) -> u32 {
    let product = vfmul(a, b).0;
    word::fadd(word::fadd(product[0], product[1]), product[2])
}

/// `((x·x′ + y·y′) + z·z′) + w·w′`, each step rounded.
#[inline(always)]
pub fn dot4(a: V4, b: V4) -> u32 {
    let product = vfmul(a, b).0;
    word::fadd(dot3(a, b), product[3])
}

/// Floats of two vectors as halves, those of the first in the lower bits of each lane.
pub fn vhpack(a: V4, b: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hpack(a.0[i], b.0[i])))
}

/// The halves in the lower bits of each lane.
pub fn vhlow(a: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hlow(a.0[i])))
}

/// The halves in the upper bits of each lane.
pub fn vhhigh(a: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hhigh(a.0[i])))
}

/// Sums of halves.
pub fn vhadd(a: V4, b: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hadd(a.0[i], b.0[i])))
}

/// Differences of halves.
pub fn vhsub(a: V4, b: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hsub(a.0[i], b.0[i])))
}

/// Products of halves.
pub fn vhmul(a: V4, b: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hmul(a.0[i], b.0[i])))
}

/// `a·b + c` of halves, rounded once.
pub fn vhfma(a: V4, b: V4, c: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hfma(a.0[i], b.0[i], c.0[i])))
}

/// The less of halves.
pub fn vhmin(a: V4, b: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hmin(a.0[i], b.0[i])))
}

/// The greater of halves.
pub fn vhmax(a: V4, b: V4) -> V4 {
    V4(std::array::from_fn(|i| word::hmax(a.0[i], b.0[i])))
}
