//! Operands: the values where something special happens, and random ones.

use srp_archdesc::Opcode;
use srp_archdesc::arch::Precision;
use srp_archdesc::ops::{V4, Value, eval};

/// Floats at which some operation changes its behaviour.
pub(crate) const FLOATS: &[u32] = &[
    0x0000_0000, // 0
    0x0000_0001, // least denormal
    0x0000_0002,
    0x0040_0000,
    0x007f_ffff, // largest denormal
    0x0080_0000, // least normal
    0x0080_0001,
    0x00ff_ffff,
    0x2b8c_bccc,
    0x3300_0000, // 2^-25
    0x3380_0000, // 2^-24
    0x3f00_0000, // 1/2
    0x3f00_0001,
    0x3f49_0fda, // about pi/4
    0x3f49_0fdb,
    0x3f7f_ffff,
    0x3f80_0000, // 1
    0x3f80_0001,
    0x3fb5_04f3, // about sqrt 2
    0x3fb5_04f4,
    0x3fc9_0fdb, // about pi/2
    0x4000_0000, // 2
    0x4040_0000, // 3
    0x4049_0fdb, // about pi
    0x42fe_ffff,
    0x42ff_ffff,
    0x4300_0000, // 128
    0x4316_0000, // 150
    0x4315_ffff,
    0x4b00_0000, // 2^23
    0x4b00_0001,
    0x4afe_ffff,
    0x4aff_ffff, // 2^23 - 1/2
    0x4eff_ffff,
    0x4f00_0000, // 2^31
    0x4f00_0001,
    0x4f7f_ffff,
    0x4f80_0000, // 2^32
    0x6f79_be45, // close to a multiple of pi/2
    0x7e7f_ffff,
    0x7f7f_ffff, // largest
    0x7f80_0000, // infinity
    0x7f80_0001, // signalling NaN
    0x7fc0_0000, // NaN
    0x7fff_ffff,
];

/// [`FLOATS`] with both signs.
pub(crate) fn floats() -> Vec<u32> {
    FLOATS.iter().flat_map(|&x| [x, x | 1 << 31]).collect()
}

/// Integers at which some operation changes its behaviour.
pub(crate) const INTEGERS: &[u32] = &[
    0,
    1,
    2,
    3,
    7,
    31,
    32,
    33,
    0x7f,
    0x80,
    0xffff,
    0x1_0000,
    0x00ff_ffff,
    0x0100_0001,
    0x7fff_ffbf,
    0x7fff_ffc0,
    0x7fff_fffe,
    0x7fff_ffff,
    0x8000_0000,
    0x8000_0001,
    0xffff_ff7f,
    0xffff_ff80,
    0xffff_fffe,
    0xffff_ffff,
];

/// Random words (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// All 32 bits random.
    pub(crate) fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 32) as u32
    }

    /// A float with an exponent within `spread` of 1's.
    pub(crate) fn near_one(&mut self, spread: u32) -> u32 {
        let exponent = 127 - spread + self.word() % (2 * spread + 1);
        (self.word() & 0x807f_ffff) | exponent << 23
    }
}

/// How many random vectors each operation is tried on: this many, or as many as `SRP_VECTORS` says.
pub(crate) fn rounds(usual: u32) -> u32 {
    let asked = std::env::var("SRP_VECTORS").ok();
    asked.map_or(usual, |n| n.parse().expect("SRP_VECTORS is a number"))
}

/// Returns the result of `op` for words and predicates (as 0 or 1), exact special functions.
pub(crate) fn result(op: Opcode, args: &[u32]) -> u32 {
    let args: Vec<Value> = args.iter().map(|&a| V4::word(a)).collect();
    eval(op, &args, 0, &Precision::EXACT)
        .expect("no division by zero")
        .expect("it computes")
        .as_word()
}
