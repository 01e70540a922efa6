//! First approximations by tables of offsets, by polynomials, and digit by digit.
//!
//! A *unit word* says how one is built: bits 0 to 7 its precision `p`, bits 8 to 11 its kind, bits 12 to
//! 15 and 16 to 23 two numbers of that kind. Everything is fixed point, and a function of the unit
//! word and the operand alone, so any engine and any host gives the same bits:
//!
//! * [`OFFSETS`] (Das Sarma and Matula's bipartite tables, de Dinechin and Tisserand's with several
//!   tables of offsets): a correctly rounded value for the middle of a cell, and for each part of the
//!   remaining operand bits a correctly rounded offset along the slope of a coarser cell; their exact sum.
//! * [`POLYNOMIAL`]: in each of 2^k segments the polynomial through the function at the Chebyshev nodes of the
//!   segment, its coefficients rounded to p + 4 fraction bits less k for each degree, powers of the
//!   operand cut at p + 6 fraction bits, the sum rounded once to p + 4.
//! * [`RECURRENCE`]: digit recurrence with a remainder, so the nearest number of p significant bits.
//! * [`CORDIC`] (Volder 1959, Walther 1971): p + 3 rotations in words with p + 8 fraction bits.
//!
//! Where the operand's fraction is 0 tables, polynomials and rotations give the exact value: units test for it.

/// The direct table, which the functions of [`elementary`](super::elementary) read themselves.
pub const TABLE: u32 = 0;
/// Tables of values and of offsets; the first number is how many of the latter.
pub const OFFSETS: u32 = 1;
/// Piecewise polynomials; the numbers are the degree, and the binary logarithm of the segments.
pub const POLYNOMIAL: u32 = 2;
/// Digit recurrence.
pub const RECURRENCE: u32 = 3;
/// Rotations by shifts and additions.
pub const CORDIC: u32 = 4;

/// Fraction bits of an operand.
const OPERAND: u32 = 26;

/// The precision of a unit word.
#[inline(always)]
pub fn precision(unit: u32) -> u32 {
    unit & 0xff
}

/// The kind of a unit word.
#[inline(always)]
pub fn kind(unit: u32) -> u32 {
    unit >> 8 & 15
}

/// A function on the operands 0 ≤ t < 1 that tables of a unit cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// 1/(1 + t)
    Reciprocal,
    /// 1/√(1 + t)
    InverseRoot,
    /// 1/√(2 + 2t)
    InverseRootOfTwice,
    /// 2^t
    Power,
    /// log2(1 + t)
    Logarithm,
    /// sin(t·π/2)
    QuarterSine,
}

impl Curve {
    /// Its value.
    pub fn value(self, t: f64) -> f64 {
        use super::elementary::{cosine, logarithm, power, sine};
        match self {
            Curve::Reciprocal => 1.0 / (1.0 + t),
            Curve::InverseRoot => 1.0 / (1.0 + t).sqrt(),
            Curve::InverseRootOfTwice => 1.0 / (2.0 + 2.0 * t).sqrt(),
            Curve::Power => power(t),
            Curve::Logarithm => logarithm(1.0 + t),
            Curve::QuarterSine if t <= 0.5 => sine(t * std::f64::consts::FRAC_PI_2),
            Curve::QuarterSine => cosine((1.0 - t) * std::f64::consts::FRAC_PI_2),
        }
    }

    /// Its derivative.
    fn slope(self, t: f64) -> f64 {
        let y = self.value(t);
        match self {
            Curve::Reciprocal => -y * y,
            Curve::InverseRoot | Curve::InverseRootOfTwice => -0.5 * y / (1.0 + t),
            Curve::Power => y * std::f64::consts::LN_2,
            Curve::Logarithm => std::f64::consts::LOG2_E / (1.0 + t),
            Curve::QuarterSine => Curve::QuarterSine.value(1.0 - t) * std::f64::consts::FRAC_PI_2,
        }
    }

    /// The largest of its n-th derivative over n!, relative to its value where its precision is relative.
    pub fn taylor(self, n: u32) -> f64 {
        let mut product = 1.0;
        for i in 1..=n {
            let i = f64::from(i);
            product *= match self {
                Curve::Reciprocal => 1.0,
                Curve::InverseRoot | Curve::InverseRootOfTwice => (i - 0.5) / i,
                Curve::Power => std::f64::consts::LN_2 / i,
                Curve::Logarithm => 1.0,
                Curve::QuarterSine => std::f64::consts::FRAC_PI_2 / i,
            };
        }
        match self {
            Curve::Logarithm => product * std::f64::consts::LOG2_E / f64::from(n),
            _ => product,
        }
    }
}

/// 2ⁿ for −1022 ≤ n ≤ 1023.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// The nearest integer to `x`, halves away from zero.
fn nearest(x: f64) -> i64 {
    if x < 0.0 {
        -((0.5 - x) as i64)
    } else {
        (x + 0.5) as i64
    }
}

/// `curve` at `t` as a unit with tables gives it. The exact value where `t` is no fraction: at most 0,
/// or 1 and more.
pub fn tabulated(curve: Curve, t: f64, unit: u32) -> f64 {
    let x = (t * power_of_two(OPERAND as i32)) as i64;
    if x <= 0 {
        return curve.value(0.0);
    } else if x >> OPERAND != 0 {
        return curve.value(1.0);
    }
    let (p, first, second) = (precision(unit), unit >> 12 & 15, unit >> 16 & 255);
    match kind(unit) {
        OFFSETS => offsets(curve, x, p, first),
        _ => segment(curve, x, p, first as usize, second),
    }
}

/// Where tables of offsets for `p` bits divide an operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Division {
    /// Bits that address the table of values.
    pub values: u32,
    /// For each table of offsets the bits of the cell whose slope it goes along, and the operand bits
    /// that it is for: their number, and how many stand before them. Only the first `count` count.
    pub offsets: [(u32, u32, u32); 4],
    /// How many tables of offsets there are.
    pub count: usize,
}

/// Divides an operand among a table of values and `count` tables of offsets. p + 2 operand bits are
/// looked at. The first table has so many of them that all tables are about equally large; the rest is
/// shared out, and the slope for a part is known well enough that it adds no more than 2^−(p+2) to the
/// error, shared by all parts.
pub fn division(p: u32, count: u32) -> Division {
    let operand = p + 2;
    let values = ((p + 1) * (count + 1)).div_ceil(2 * count + 1);
    let share = if count > 2 { 2 } else { count - 1 };
    let mut offsets = [(0, 0, 0); 4];
    let mut before = values;
    for (i, part) in offsets.iter_mut().enumerate().take(count as usize) {
        let bits = (operand - before).div_ceil(count - i as u32);
        let slope = (p + 1 + share).saturating_sub(before).max(1);
        *part = (slope, bits, before);
        before += bits;
    }
    Division {
        values,
        offsets,
        count: count as usize,
    }
}

/// Fraction bits of all entries of tables, and of the result of a polynomial, for `p` bits.
pub fn fraction(p: u32) -> u32 {
    p + 4
}

fn offsets(curve: Curve, x: i64, p: u32, count: u32) -> f64 {
    let unit = power_of_two(fraction(p) as i32);
    let middle = |bits: u32| {
        let cell = (x >> (OPERAND - bits)) as f64;
        (cell + 0.5) * power_of_two(-(bits as i32))
    };
    let division = division(p, count);
    let mut sum = nearest(curve.value(middle(division.values)) * unit);
    for &(slope, bits, before) in &division.offsets[..division.count] {
        if bits == 0 {
            continue;
        }
        let part = x >> (OPERAND - before - bits) & ((1 << bits) - 1);
        let center = (1u32 << bits) - 1;
        let along =
            (part as f64 - 0.5 * f64::from(center)) * power_of_two(-((before + bits) as i32));
        sum += nearest(curve.slope(middle(slope)) * along * unit);
    }
    sum as f64 / unit
}

/// Fraction bits of the coefficient of a power of the operand in its segment, of 2^k.
pub fn coefficient(p: u32, k: u32, power: u32) -> u32 {
    fraction(p).saturating_sub(power * k).max(3)
}

fn segment(curve: Curve, x: i64, p: u32, degree: usize, k: u32) -> f64 {
    let rest = OPERAND - k;
    let left = (x >> rest) as f64 * power_of_two(-(k as i32));
    let local = x & ((1 << rest) - 1);
    let polynomial = interpolation(curve, left, power_of_two(-(k as i32)), degree);
    // Powers of the operand have `cut` fraction bits, and their sum fraction(p) more.
    let cut = fraction(p) + 2;
    let mut power = if cut <= OPERAND {
        local >> (OPERAND - cut)
    } else {
        local << (cut - OPERAND)
    };
    let operand = power;
    let mut sum = nearest(polynomial[0] * power_of_two(fraction(p) as i32)) << cut;
    for (i, &c) in polynomial.iter().enumerate().take(degree + 1).skip(1) {
        // The coefficient is one of the operand within its segment, times 2^(k·i).
        let bits = coefficient(p, k, i as u32);
        let scaled = nearest(c * power_of_two((k * i as u32 + bits) as i32));
        sum += (scaled * power) << (fraction(p) - bits);
        power = ((i128::from(power) * i128::from(operand)) >> cut) as i64;
    }
    let rounded = (sum + (1 << (cut - 1))) >> cut;
    rounded as f64 / power_of_two(fraction(p) as i32)
}

/// The polynomial in s, 0 ≤ s ≤ 1, through a curve at the Chebyshev nodes of [left, left + width] = left +
/// s·width, the constant first.
fn interpolation(curve: Curve, left: f64, width: f64, degree: usize) -> [f64; 4] {
    /// (1 + cos((2j + 1)π/(2n)))/2 for n of 2, 3 and 4.
    const NODES: [[f64; 4]; 3] = [
        [0.146_446_609_406_726_24, 0.853_553_390_593_273_8, 0.0, 0.0],
        [0.066_987_298_107_780_68, 0.5, 0.933_012_701_892_219_3, 0.0],
        [
            0.038_060_233_744_356_63,
            0.308_658_283_817_455_14,
            0.691_341_716_182_544_9,
            0.961_939_766_255_643_4,
        ],
    ];
    let nodes = NODES[degree.clamp(1, 3) - 1];
    let count = degree.clamp(1, 3) + 1;
    let mut differences = [0.0; 4];
    for i in 0..count {
        differences[i] = curve.value(left + width * nodes[i]);
    }
    for order in 1..count {
        for i in (order..count).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (nodes[i] - nodes[i - order]);
        }
    }
    // Newton's form to powers of s.
    let mut result = [0.0; 4];
    for i in (0..count).rev() {
        for j in (1..4).rev() {
            result[j] = result[j - 1] - nodes[i] * result[j];
        }
        result[0] = differences[i] - nodes[i] * result[0];
    }
    result
}

/// `x` > 0, normal, rounded to `p` significant bits, ties to even.
pub fn rounded(x: f64, p: u32) -> f64 {
    let below = 53 - p;
    let bits = x.to_bits();
    let even = bits >> below & 1;
    let bits = (bits + (1 << (below - 1)) - 1 + even) >> below << below;
    f64::from_bits(bits)
}

/// Fraction bits of the words of a CORDIC unit for `p` bits, and the last of its shifts.
fn rotations(p: u32) -> (u32, u32) {
    (p + 8, p + 3)
}

/// A number with 60 fraction bits, rounded to `fraction`.
fn word(constant: i64, fraction: u32) -> i64 {
    (constant + (1 << (59 - fraction))) >> (60 - fraction)
}

/// The angle of rotation `i` by a table that ends where angles are powers of two.
fn angle(table: &[i64], i: u32) -> i64 {
    table.get(i as usize).copied().unwrap_or(1 << (60 - i))
}

/// a/b for 1 ≤ a, b < 2 by rotations in the linear system.
pub fn cordic_quotient(a: f64, b: f64, p: u32) -> f64 {
    if a == b {
        return 1.0;
    }
    let (fraction, last) = rotations(p);
    let unit = power_of_two(fraction as i32);
    let (x, mut y, mut z) = ((b * unit) as i64, (a * unit) as i64, 0i64);
    for i in 0..=last {
        let forward = y >= 0;
        y += if forward { -(x >> i) } else { x >> i };
        z += if forward { 1 } else { -1 } << (fraction - i);
    }
    z as f64 / unit
}

/// sin(t·π/2) for 0 ≤ t ≤ 1 by rotations in the circular system.
pub fn cordic_sine(t: f64, p: u32) -> f64 {
    if t == 0.0 || t == 1.0 {
        return t;
    }
    let (fraction, last) = rotations(p);
    let unit = power_of_two(fraction as i32);
    let (mut x, mut y) = (word(CIRCULAR_GAIN, fraction), 0i64);
    let mut z = nearest(t * std::f64::consts::FRAC_PI_2 * unit);
    for i in 0..=last {
        let (dx, dy, dz) = (y >> i, x >> i, word(angle(&ARC_TANGENT, i), fraction));
        if z >= 0 {
            (x, y, z) = (x - dx, y + dy, z - dz);
        } else {
            (x, y, z) = (x + dx, y - dy, z + dz);
        }
    }
    y as f64 / unit
}

/// The shifts of the hyperbolic system: from 1 on, 4 and 13 twice, without which it does not converge.
fn hyperbolic_shifts(last: u32) -> impl Iterator<Item = u32> {
    (1..=last).flat_map(|i| std::iter::repeat_n(i, if i == 4 || i == 13 { 2 } else { 1 }))
}

/// 2^t for 0 ≤ t < 1 by rotations in the hyperbolic system.
pub fn cordic_power(t: f64, p: u32) -> f64 {
    if t == 0.0 {
        return 1.0;
    }
    let (fraction, last) = rotations(p);
    let unit = power_of_two(fraction as i32);
    let mut x = word(HYPERBOLIC_GAIN, fraction);
    let mut z = nearest(t * std::f64::consts::LN_2 * unit);
    // cosh and sinh begin and remain equal: one register serves for both.
    for i in hyperbolic_shifts(last) {
        let (dx, dz) = (x >> i, word(angle(&HYPERBOLIC_ARC_TANGENT, i), fraction));
        if z >= 0 {
            (x, z) = (x + dx, z - dz);
        } else {
            (x, z) = (x - dx, z + dz);
        }
    }
    x as f64 / unit
}

/// Turns (x, y) until y is 0: what x becomes, and the angle.
fn hyperbolic_vector(mut x: i64, mut y: i64, fraction: u32, last: u32) -> (i64, i64) {
    let mut z = 0;
    for i in hyperbolic_shifts(last) {
        let (dx, dy, dz) = (
            y >> i,
            x >> i,
            word(angle(&HYPERBOLIC_ARC_TANGENT, i), fraction),
        );
        if y >= 0 {
            (x, y, z) = (x - dx, y - dy, z + dz);
        } else {
            (x, y, z) = (x + dx, y + dy, z - dz);
        }
    }
    (x, z)
}

/// log2(1 + t) for 0 ≤ t < 1: 2·artanh(t/(2 + t)), by rotations in the hyperbolic system.
pub fn cordic_logarithm(t: f64, p: u32) -> f64 {
    if t == 0.0 {
        return 0.0;
    }
    let (fraction, last) = rotations(p);
    let unit = power_of_two(fraction as i32);
    let y = (t * unit) as i64;
    let (_, angle) = hyperbolic_vector((2 << fraction) + y, y, fraction, last);
    let twice = 2.0 * angle as f64 / unit * std::f64::consts::LOG2_E;
    nearest(twice * unit) as f64 / unit
}

/// √m for 1 ≤ m < 4: of (m/4 + ¼, m/4 − ¼) the length, by rotations in the hyperbolic system.
pub fn cordic_root(m: f64, p: u32) -> f64 {
    if m == 1.0 {
        return 1.0;
    }
    let (fraction, last) = rotations(p);
    let unit = power_of_two(fraction as i32);
    let quarter = (m * unit) as i64 >> 2;
    let one = 1 << (fraction - 2);
    let (length, _) = hyperbolic_vector(quarter + one, quarter - one, fraction, last);
    // Half of the root, times what rotations shorten it by.
    let product = i128::from(length) * i128::from(word(HYPERBOLIC_GAIN, fraction));
    2.0 * (product >> fraction) as f64 / unit
}

/// The inverse of the factor by which circular rotations lengthen; 60 fraction bits, as in all of these.
const CIRCULAR_GAIN: i64 = 700_114_967_507_363_238;

/// The inverse of the factor by which hyperbolic rotations shorten.
const HYPERBOLIC_GAIN: i64 = 1_392_149_336_173_756_979;

/// arctan 2^−i; beyond the table it is 2^−i to the last bit.
const ARC_TANGENT: [i64; 20] = [
    905502432259640355,
    534549298976576474,
    282441168888798124,
    143371547418228444,
    71963988336308046,
    36017075762092179,
    18012932708689205,
    9007016009513623,
    4503576721087964,
    2251796950380271,
    1125899548928887,
    562949908682076,
    281474971118251,
    140737487656277,
    70368744090283,
    35184372077909,
    17592186043051,
    8796093022037,
    4398046511083,
    2199023255549,
];

/// artanh 2^−i; there is none for 0, and beyond the table it is 2^−i to the last bit.
const HYPERBOLIC_ARC_TANGENT: [i64; 20] = [
    0,
    633306866415404364,
    294470923372008554,
    144872904391515885,
    72151639547927246,
    36040532019738386,
    18015864739771506,
    9007382513390134,
    4503622534072459,
    2251802677003332,
    1125900264756770,
    562949998160561,
    281474982303062,
    140737489054379,
    70368744265045,
    35184372099755,
    17592186045781,
    8796093022379,
    4398046511125,
    2199023255555,
];
