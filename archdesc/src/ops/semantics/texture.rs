//! Functions of the texture unit: the texels between which a coordinate lies, and their weighted mean.
//!
//! A descriptor is four words: the address of the texels, width and height in texels, and flags: [`CLAMP`]
//! or 0, and in the five bits from [`LEVELS_SHIFT`] on the number of smaller levels, 16 at most. Sizes are 1 to
//! 65,536; smaller ones count as 1, larger ones as 65,536. Texels are words, red in the low
//! byte, then green, blue and alpha, in tiles of 4×4, row by row: 64 bytes that a bilinear footprint seldom
//! leaves. Tiles follow each other row by row; where width or height is no multiple of 4 the last tile of a
//! row or column is whole nevertheless.
//!
//! Level 0 is the texture itself. Each side of the next level is half as long, rounded down, and 1 at least;
//! its tiles follow the last tile of the level before. The level of detail, binary32 in lane 2 of the
//! coordinates, is rounded to the nearest whole number (ties up): that level is sampled, level 0 for a
//! negative number or NaN, the smallest where there is no such level. With no smaller level lane 2 has no meaning.
//!
//! Everything but the last rounding is exact. Along an axis of `n` texels the coordinate `c` stands
//! at `c·n − ½`, rounded to the nearest multiple of 2^−`bits` (ties up), `bits` being the weight
//! bits of the machine, 0 to 12: the integer part is the first texel, the fraction the weight of
//! the next. With 0 bits this is the nearest texel. Indices outside of the texture wrap round, or
//! stop at its edge with `CLAMP`. So a coordinate of magnitude 2²³ or more, which is an integer, is
//! the same as 0 where it wraps, and infinity too; NaN is the same as 0 everywhere.
//!
//! Red, green and blue are decoded from sRGB by a table of 256 entries of 24 bits before they are
//! filtered; alpha is linear. A texel that stands alone is its table entry, exactly.

use super::lanes::V4;

/// The flag of a descriptor whose coordinates stop at the edges.
pub const CLAMP: u32 = 1;

/// The lowest bit of the number of smaller levels in the flags of a descriptor.
pub const LEVELS_SHIFT: u32 = 8;

/// Most smaller levels: those of a texture with a side of 65,536.
pub const MAX_LEVELS: u32 = 16;

/// The result for a texture of address 0, without touching memory: 1 in all lanes.
pub const NO_TEXTURE: V4 = V4([0x3f80_0000; 4]);

/// Texels that a coordinate lies between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footprint {
    /// Their addresses: this one, the next along `u`, and both of the next along `v`.
    pub addresses: [u32; 4],
    /// The weights of the next along `u` and along `v`, in units of 2^−bits.
    pub weights: [u32; 2],
}

/// The number of smaller levels of the texture of a descriptor.
pub fn levels(descriptor: V4) -> u32 {
    (descriptor.0[3] >> LEVELS_SHIFT & 31).min(MAX_LEVELS)
}

/// The level that a level of detail, binary32, selects in the texture of a descriptor.
pub fn level(descriptor: V4, detail: u32) -> u32 {
    let detail = f32::from_bits(detail);
    if detail > 0.0 {
        // Exact, and rounded towards 0; what is too large is the largest.
        ((f64::from(detail) + 0.5) as u32).min(levels(descriptor))
    } else {
        0
    }
}

/// The descriptor of a level alone, as if it were a texture.
pub fn at_level(descriptor: V4, level: u32) -> V4 {
    let V4([mut texels, width, height, flags]) = descriptor;
    let (mut width, mut height) = (width.clamp(1, 1 << 16), height.clamp(1, 1 << 16));
    for _ in 0..level {
        let tiles = width.div_ceil(4).wrapping_mul(height.div_ceil(4));
        texels = texels.wrapping_add(tiles.wrapping_mul(64));
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    V4([texels, width, height, flags & CLAMP])
}

/// The footprint of a coordinate in the texture of a descriptor: binary32 `u` and `v` in lanes 0 and 1, the
/// level of detail in lane 2.
pub fn footprint(descriptor: V4, uv: V4, bits: u32) -> Footprint {
    let descriptor = at_level(descriptor, level(descriptor, uv.0[2]));
    let V4([_, width, height, flags]) = descriptor;
    let clamp = flags & CLAMP != 0;
    let (x, x_weight) = between(uv.0[0], width, clamp, bits);
    let (y, y_weight) = between(uv.0[1], height, clamp, bits);
    let address = |x: u32, y: u32| texel_address(descriptor, x, y);
    Footprint {
        addresses: [
            address(x[0], y[0]),
            address(x[1], y[0]),
            address(x[0], y[1]),
            address(x[1], y[1]),
        ],
        weights: [x_weight, y_weight],
    }
}

/// The address of the texel in a column and a row of the texture of a descriptor.
pub fn texel_address(descriptor: V4, x: u32, y: u32) -> u32 {
    let V4([texels, width, ..]) = descriptor;
    let tiles = width.clamp(1, 1 << 16).div_ceil(4);
    let tile = (y / 4).wrapping_mul(tiles).wrapping_add(x / 4);
    texels
        .wrapping_add(tile.wrapping_mul(64))
        .wrapping_add(16 * (y % 4) + 4 * (x % 4))
}

/// The two texels of an axis of `size` that a coordinate lies between, and the weight of the second.
fn between(coordinate: u32, size: u32, clamp: bool, bits: u32) -> ([u32; 2], u32) {
    let n = i64::from(size);
    let (exponent, fraction) = (coordinate >> 23 & 255, coordinate & 0x7f_ffff);
    // The magnitude is mantissa · 2^(power − 150).
    let (mantissa, power) = match exponent {
        0 => (fraction, 1),
        255 if fraction != 0 => (0, 1),
        _ => (fraction | 1 << 23, exponent),
    };
    let negative = coordinate >> 31 != 0;
    let mut position = 0;
    if power >= 150 {
        if clamp {
            let edge = if negative { 0 } else { size - 1 };
            return ([edge; 2], 0);
        }
    } else {
        let magnitude = i64::from(mantissa) * n;
        let product = if negative { -magnitude } else { magnitude };
        // Below 2^40 · 2^−62 nothing but the sign is left to round.
        let down = (150 - power as i32 - bits as i32).min(62);
        position = match down {
            ..=0 => product << -down,
            _ if bits == 0 => product >> down,
            _ => (product + (1 << (down - 1))) >> down,
        };
    }
    let unit = 1i64 << bits;
    position -= unit / 2;
    let first = position >> bits;
    let texel = |i: i64| {
        let i = if clamp {
            i.clamp(0, n - 1)
        } else {
            i.rem_euclid(n)
        };
        i as u32
    };
    (
        [texel(first), texel(first + 1)],
        (position & (unit - 1)) as u32,
    )
}

/// The mean of four texels, in the order of [`Footprint::addresses`]: red, green, blue and alpha as
/// binary32, 0 to 1.
pub fn filter(texels: V4, weights: [u32; 2], bits: u32) -> V4 {
    let unit = 1u64 << bits;
    let [x, y] = weights.map(u64::from);
    let weights = [
        (unit - x) * (unit - y),
        x * (unit - y),
        (unit - x) * y,
        x * y,
    ];
    // At most 24 + 2 · 12 bits, which binary64 holds; one rounding, to binary32.
    let one = f64::from(1u32 << 24) * (unit * unit) as f64;
    V4(std::array::from_fn(|channel| {
        let mut sum = 0;
        for (texel, weight) in texels.0.iter().zip(weights) {
            sum += weight * u64::from(decoded(*texel, channel));
        }
        ((sum as f64 / one) as f32).to_bits()
    }))
}

/// A channel of a texel, in units of 2^−24.
pub fn decoded(texel: u32, channel: usize) -> u32 {
    let byte = texel >> (8 * channel) & 255;
    match channel {
        3 => ((byte << 24) + 127) / 255,
        _ => LINEAR[byte as usize],
    }
}

/// sRGB (IEC 61966-2-1) to linear, in units of 2^−24.
const LINEAR: [u32; 256] = [
    0, 5092, 10185, 15277, 20369, 25462, 30554, 35646, 40739, 45831, 50923, 56146, 61682, 67524,
    73676, 80144, 86931, 94043, 101483, 109255, 117364, 125813, 134607, 143749, 153244, 163095,
    173306, 183880, 194821, 206133, 217819, 229883, 242327, 255157, 268373, 281981, 295983, 310382,
    325182, 340386, 355996, 372016, 388449, 405298, 422565, 440255, 458369, 476910, 495881, 515286,
    535127, 555406, 576126, 597291, 618902, 640963, 663476, 686443, 709868, 733752, 758099, 782910,
    808189, 833938, 860159, 886854, 914027, 941680, 969814, 998433, 1027538, 1057133, 1087218,
    1117798, 1148873, 1180447, 1212520, 1245097, 1278179, 1311767, 1345865, 1380475, 1415598,
    1451237, 1487394, 1524071, 1561270, 1598994, 1637244, 1676023, 1715332, 1755173, 1795550,
    1836463, 1877915, 1919907, 1962442, 2005522, 2049149, 2093324, 2138049, 2183328, 2229161,
    2275550, 2322497, 2370005, 2418074, 2466708, 2515908, 2565675, 2616012, 2666920, 2718402,
    2770458, 2823092, 2876304, 2930097, 2984472, 3039432, 3094977, 3151110, 3207832, 3265145,
    3323052, 3381553, 3440650, 3500346, 3560641, 3621538, 3683038, 3745144, 3807855, 3871176,
    3935106, 3999648, 4064803, 4130573, 4196960, 4263965, 4331589, 4399836, 4468706, 4538200,
    4608321, 4679069, 4750448, 4822457, 4895099, 4968376, 5042288, 5116838, 5192027, 5267856,
    5344328, 5421443, 5499204, 5577611, 5656667, 5736372, 5816729, 5897738, 5979402, 6061722,
    6144699, 6228335, 6312631, 6397589, 6483210, 6569496, 6656448, 6744068, 6832357, 6921317,
    7010948, 7101253, 7192233, 7283889, 7376223, 7469237, 7562930, 7657306, 7752366, 7848110,
    7944540, 8041658, 8139465, 8237963, 8337152, 8437035, 8537612, 8638885, 8740855, 8843524,
    8946893, 9050964, 9155737, 9261215, 9367397, 9474287, 9581885, 9690192, 9799210, 9908940,
    10019383, 10130542, 10242416, 10355008, 10468318, 10582349, 10697100, 10812575, 10928773,
    11045697, 11163346, 11281724, 11400831, 11520668, 11641236, 11762538, 11884573, 12007344,
    12130852, 12255098, 12380082, 12505807, 12632274, 12759484, 12887438, 13016137, 13145583,
    13275776, 13406719, 13538412, 13670857, 13804054, 13938006, 14072712, 14208175, 14344396,
    14481375, 14619114, 14757615, 14896878, 15036905, 15177696, 15319253, 15461578, 15604671,
    15748533, 15893166, 16038571, 16184750, 16331702, 16479430, 16627934, 16777216,
];
