//! Elementary functions to about 90 bits: sums of two binary64 numbers, plain Taylor series, and a
//! long division for the angle. Slow, and unlike what it is a reference for.

/// A number as the sum of two, the second at most half a place of the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dd(pub(crate) f64, pub(crate) f64);

pub(crate) const LN_2: Dd = Dd(std::f64::consts::LN_2, 2.3190468138462996e-17);

fn two_sum(a: f64, b: f64) -> Dd {
    let s = a + b;
    let back = s - a;
    Dd(s, (a - (s - back)) + (b - back))
}

impl Dd {
    pub(crate) fn add(self, other: Dd) -> Dd {
        let (s, t) = (two_sum(self.0, other.0), two_sum(self.1, other.1));
        let u = two_sum(s.0, s.1 + t.0);
        two_sum(u.0, u.1 + t.1)
    }

    pub(crate) fn mul(self, other: Dd) -> Dd {
        let p = self.0 * other.0;
        let e = self.0.mul_add(other.0, -p);
        two_sum(p, e + (self.0 * other.1 + self.1 * other.0))
    }

    /// Division by a small integer.
    fn over(self, n: f64) -> Dd {
        let q = self.0 / n;
        let rest = (-q).mul_add(n, self.0) + self.1;
        two_sum(q, rest / n)
    }

    fn neg(self) -> Dd {
        Dd(-self.0, -self.1)
    }
}

/// 2^x for |x| < 1000.
pub(crate) fn exp2(x: Dd) -> Dd {
    let n = x.0.round();
    // e^(r/256) − 1, then squared eight times: (1 + p)² − 1 = p·(2 + p).
    let r = x.add(Dd(-n, 0.0)).mul(LN_2).mul(Dd(1.0 / 256.0, 0.0));
    let (mut p, mut term) = (r, r);
    for k in 2..12 {
        term = term.mul(r).over(f64::from(k));
        p = p.add(term);
    }
    for _ in 0..8 {
        p = p.mul(p.add(Dd(2.0, 0.0)));
    }
    p.add(Dd(1.0, 0.0)).mul(Dd(2f64.powi(n as i32), 0.0))
}

/// log2 x for normal x > 0: one step from what the host says, of third order.
pub(crate) fn log2(x: f64) -> Dd {
    let guess = x.log2();
    // x / 2^guess is 1 but for d.
    let d = Dd(x, 0.0).mul(exp2(Dd(-guess, 0.0))).add(Dd(-1.0, 0.0));
    let log = d.add(d.mul(d).over(-2.0)).add(d.mul(d).mul(d).over(3.0));
    let inverse = Dd(std::f64::consts::LOG2_E, 2.0355273740931033e-17);
    Dd(guess, 0.0).add(log.mul(inverse))
}

/// π/2 in units of 2⁻²⁸⁸, least word first.
const HALF_PI: [u64; 5] = [
    0x7627_3644_a294_10f3,
    0x14cf_98e8_0417_7d4c,
    0x01b8_39a2_5204_9c11,
    0x42d1_8469_898c_c517,
    0x0000_0001_921f_b544,
];

fn less(a: &[u64; 5], b: &[u64; 5]) -> bool {
    a.iter().rev().lt(b.iter().rev())
}

fn subtract(a: &mut [u64; 5], b: &[u64; 5]) {
    let mut borrow = false;
    for (x, &y) in a.iter_mut().zip(b) {
        let (d, first) = x.overflowing_sub(y);
        let (d, second) = d.overflowing_sub(u64::from(borrow));
        (*x, borrow) = (d, first | second);
    }
}

/// 2a + bit, the bit of weight 1.
fn doubled(a: &mut [u64; 5], bit: u64) {
    let mut carry = 0;
    for x in a.iter_mut() {
        (*x, carry) = (*x << 1 | carry, *x >> 63);
    }
    a[4] += bit << 32;
}

/// |x| less a multiple of π/2, from −π/4 to π/4, and that multiple modulo 4.
pub(crate) fn reduce(x: f32) -> (Dd, u32) {
    let bits = x.abs().to_bits();
    let exponent = (bits >> 23).max(1) as i32 - 150;
    let mantissa = u64::from(bits & 0x7f_ffff) | if bits >> 23 > 0 { 0x80_0000 } else { 0 };
    let (mut rest, mut quadrant) = ([0u64; 5], 0u32);
    // The integer part bit by bit, as in a long division.
    for weight in (0..128).rev() {
        let shift = weight - exponent;
        let bit = if (0..24).contains(&shift) {
            mantissa >> shift & 1
        } else {
            0
        };
        doubled(&mut rest, bit);
        quadrant = quadrant.wrapping_mul(2);
        while !less(&rest, &HALF_PI) {
            subtract(&mut rest, &HALF_PI);
            quadrant = quadrant.wrapping_add(1);
        }
    }
    let mut value = fixed(&rest);
    if exponent < 0 {
        let unit = 2f64.powi(exponent);
        let fraction = mantissa as f64 * unit;
        value = value.add(Dd(fraction.fract(), 0.0));
    }
    let half_pi = fixed(&HALF_PI);
    // Once where the fraction carried it over π/2, once to come nearest to 0.
    while value.0 > half_pi.0 / 2.0 {
        value = value.add(half_pi.neg());
        quadrant = quadrant.wrapping_add(1);
    }
    (value, quadrant % 4)
}

/// The value of a fixed-point number in units of 2⁻²⁸⁸.
fn fixed(a: &[u64; 5]) -> Dd {
    let mut sum = Dd(0.0, 0.0);
    for (k, &x) in a.iter().enumerate().rev() {
        let unit = 2f64.powi(64 * k as i32 - 288);
        sum = sum.add(Dd((x >> 32) as f64 * 2f64.powi(32) * unit, 0.0));
        sum = sum.add(Dd((x & 0xffff_ffff) as f64 * unit, 0.0));
    }
    sum
}

/// The series r^k/k! − r^(k+2)/(k+2)! + … from k = `first`.
fn alternating(r: Dd, first: u32) -> Dd {
    let mut term = if first == 0 { Dd(1.0, 0.0) } else { r };
    let mut sum = term;
    for k in (first + 2..30).step_by(2) {
        term = term.mul(r).mul(r).over(-f64::from(k * (k - 1)));
        sum = sum.add(term);
    }
    sum
}

/// sin(x + quadrant·π/2) for finite `x`.
pub(crate) fn shifted_sine(x: f32, quadrant: u32) -> Dd {
    let (r, reduced) = reduce(x);
    let (r, reduced) = if x < 0.0 {
        (r.neg(), 4 - reduced)
    } else {
        (r, reduced)
    };
    let quadrant = quadrant + reduced;
    let value = alternating(r, 1 - quadrant % 2);
    if quadrant & 2 == 0 {
        value
    } else {
        value.neg()
    }
}
