//! The random numbers of samples, which are a part of the algorithm: whoever shades with others has
//! another picture.

/// Where random numbers are for.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Of the tile, and in the bits from 20 on the sample of the pixel.
    pub(super) seed: u32,
    /// Of the tile.
    pub(super) pixel: u32,
}

/// 32 bits that look random, another for each x (the hash `lowbias32` of C. Wellons' prospector).
pub(super) fn scrambled(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// The first 24 of 32 bits as a number from 0 to below 1.
pub(super) fn fraction(bits: u32) -> f64 {
    f64::from(bits >> 8) / f64::from(1 << 24)
}
