//! The texture unit against its definition in exact arithmetic, on textures stored texel by texel.

use crate::values::{Random, floats};
use srp_archdesc::ops::V4;
use srp_archdesc::ops::semantics::texture::{self, CLAMP, LEVELS_SHIFT};
use std::collections::BTreeMap;

/// A texture, level by level.
struct Texture {
    clamp: bool,
    levels: Vec<Level>,
}

/// A level: its texels row by row.
struct Level {
    width: u32,
    height: u32,
    texels: Vec<u32>,
}

const ADDRESS: u32 = 0x8000_0400;

impl Texture {
    /// One with so many smaller levels, which need not be smaller copies here.
    fn random(random: &mut Random, size: [u32; 2], clamp: bool, smaller: u32) -> Texture {
        let levels = (0..=smaller).map(|level| {
            let [width, height] = size.map(|side| (side >> level).max(1));
            let texels = (0..width * height).map(|_| random.word()).collect();
            Level {
                width,
                height,
                texels,
            }
        });
        Texture {
            clamp,
            levels: levels.collect(),
        }
    }

    fn descriptor(&self) -> V4 {
        let clamp = if self.clamp { CLAMP } else { 0 };
        let smaller = self.levels.len() as u32 - 1;
        let Level { width, height, .. } = self.levels[0];
        V4([ADDRESS, width, height, clamp | smaller << LEVELS_SHIFT])
    }

    /// Memory as the layout has it: level, column and row of each texel. What is no texel is not there.
    fn memory(&self) -> BTreeMap<u32, (usize, u32, u32)> {
        let mut memory = BTreeMap::new();
        let mut tile_start = ADDRESS;
        for (number, level) in self.levels.iter().enumerate() {
            for tile_y in (0..level.height).step_by(4) {
                for tile_x in (0..level.width).step_by(4) {
                    let mut address = tile_start;
                    for y in tile_y..tile_y + 4 {
                        for x in tile_x..tile_x + 4 {
                            if x < level.width && y < level.height {
                                memory.insert(address, (number, x, y));
                            }
                            address += 4;
                        }
                    }
                    tile_start = address;
                }
            }
        }
        memory
    }

    /// The level that is meant: the next one from a half on.
    fn meant(&self, detail: f32) -> usize {
        let next = |level: &usize| f64::from(detail) >= *level as f64 + 0.5;
        (0..self.levels.len() - 1).take_while(next).count()
    }
}

/// `⌊c·size·2^bits − 2^bits/2 + 1/2⌋` for a coordinate of magnitude below 2²³.
fn position(c: f32, size: u32, bits: u32) -> i128 {
    let (mantissa, exponent) = parts(c);
    let scaled = (mantissa * i128::from(size)) << (bits + 1);
    let half = (1i128 << bits) - 1;
    match exponent {
        0.. => (scaled - half).div_euclid(2),
        // So near to 0 that only the sign counts.
        ..-70 => match (bits, mantissa < 0) {
            (0, true) => -1,
            _ => -(half / 2 + half % 2),
        },
        _ => {
            let unit = 1i128 << -exponent;
            (scaled - half * unit).div_euclid(2 * unit)
        }
    }
}

/// A finite float as mantissa · 2^exponent.
fn parts(c: f32) -> (i128, i32) {
    if c == 0.0 {
        return (0, -100);
    }
    let (mut mantissa, mut exponent) = (f64::from(c), 0);
    while mantissa.fract() != 0.0 {
        mantissa *= 2.0;
        exponent -= 1;
    }
    (mantissa as i128, exponent)
}

/// The two texels of an axis, and the weight of the second in 2^−bits.
fn axis(c: f32, size: u32, clamp: bool, bits: u32) -> ([u32; 2], i128) {
    let n = i128::from(size);
    let c = match c {
        _ if c.is_nan() => 0.0,
        _ if clamp => c.clamp(-8.0e6, 8.0e6),
        _ if c.abs() >= 8_388_608.0 => 0.0,
        _ => c,
    };
    let position = position(c, size, bits);
    let unit = 1i128 << bits;
    let first = position.div_euclid(unit);
    let index = |i: i128| match clamp {
        true => i.max(0).min(n - 1) as u32,
        false => ((i % n + n) % n) as u32,
    };
    ([index(first), index(first + 1)], position.rem_euclid(unit))
}

/// A channel of a texel in 2^−24, as the unit gives it alone.
fn alone(texel: u32, channel: usize) -> i128 {
    let V4(lanes) = texture::filter(V4([texel, !texel, !texel, !texel]), [0, 0], 8);
    let value = f64::from(f32::from_bits(lanes[channel])) * 16_777_216.0;
    assert_eq!(value.fract(), 0.0);
    value as i128
}

fn check(t: &Texture, [u, v, detail]: [f32; 3], bits: u32) {
    let memory = t.memory();
    let uv = V4([u.to_bits(), v.to_bits(), detail.to_bits(), 7]);
    let footprint = texture::footprint(t.descriptor(), uv, bits);
    let clamp = t.clamp;
    let number = t.meant(detail);
    let t = &t.levels[number];
    let texels = footprint.addresses.map(|a| {
        let (level, x, y) = *memory
            .get(&a)
            .unwrap_or_else(|| panic!("{a:#x} is no texel"));
        assert_eq!(level, number, "at {detail:e}");
        t.texels[(y * t.width + x) as usize]
    });
    let V4(lanes) = texture::filter(V4(texels), footprint.weights, bits);
    let (x, wx) = axis(u, t.width, clamp, bits);
    let (y, wy) = axis(v, t.height, clamp, bits);
    let unit = 1i128 << bits;
    let corners = [
        (x[0], y[0], (unit - wx) * (unit - wy)),
        (x[1], y[0], wx * (unit - wy)),
        (x[0], y[1], (unit - wx) * wy),
        (x[1], y[1], wx * wy),
    ];
    for (channel, &lane) in lanes.iter().enumerate() {
        let texel = |x: u32, y: u32| t.texels[(y * t.width + x) as usize];
        let sum: i128 = corners
            .iter()
            .map(|&(x, y, weight)| weight * alone(texel(x, y), channel))
            .sum();
        // Below 2^49: the division is by a power of two, so binary64 has it exactly.
        let exact = sum as f64 / ((unit * unit) as f64 * 16_777_216.0);
        assert_eq!(
            lane,
            (exact as f32).to_bits(),
            "{}x{} clamp {clamp} at {u:e} {v:e}, {bits} bits, channel {channel}",
            t.width,
            t.height
        );
    }
}

#[test]
fn samples_are_those_of_the_definition() {
    let mut random = Random(3);
    let coordinates = floats();
    for (width, height, smaller) in [
        (1, 1, 0),
        (1, 7, 2),
        (4, 4, 0),
        (5, 3, 2),
        (256, 2, 8),
        (6, 1000, 9),
        // Levels beyond the last by halving are 1 x 1 too.
        (1, 1, 3),
    ] {
        for clamp in [false, true] {
            let t = Texture::random(&mut random, [width, height], clamp, smaller);
            for bits in [0, 1, 4, 8, 12] {
                let mut pick = || match random.word() % 4 {
                    0 => f32::from_bits(coordinates[random.word() as usize % coordinates.len()]),
                    // On and beside the middles and edges of texels.
                    1 => (random.word() % 4096) as f32 / (2 * width) as f32 - 3.0,
                    2 => f32::from_bits(((random.word() % 64) as f32 / width as f32).to_bits() ^ 1),
                    _ => (random.word() >> 8) as f32 / (1 << 22) as f32 - 2.0,
                };
                for i in 0..40 {
                    let detail = match i % 4 {
                        0 => f32::from_bits(coordinates[i * 7 % coordinates.len()]),
                        // On, above and below what divides two levels.
                        1 => ((i / 4) as f32 + 0.5).next_down(),
                        2 => (i / 4) as f32 + 0.5,
                        _ => i as f32 / 3.0 - 1.0,
                    };
                    check(&t, [pick(), pick(), detail], bits);
                }
            }
        }
    }
}

/// IEC 61966-2-1 to a unit of the last of 24 places, alpha linear, both ends exact.
#[test]
fn colours_are_decoded_from_srgb() {
    for byte in 0..=255u32 {
        let s = f64::from(byte) / 255.0;
        let linear = match s {
            ..=0.04045 => s / 12.92,
            _ => ((s + 0.055) / 1.055).powf(2.4),
        };
        for channel in 0..4 {
            let expected = if channel == 3 { s } else { linear };
            let error = alone(byte << (8 * channel), channel) as f64 - expected * 16_777_216.0;
            assert!(error.abs() < 0.501, "{byte} in channel {channel}: {error}");
        }
    }
}

/// The cases that are wrong most often.
#[test]
fn edges_wrap_or_stop() {
    let t = |clamp| Texture {
        clamp,
        levels: vec![Level {
            width: 256,
            height: 1,
            texels: (0..256).collect(),
        }],
    };
    let x = |t: &Texture, u: f32| {
        let descriptor = t.descriptor();
        let f = texture::footprint(descriptor, V4([u.to_bits(), 0, 0, 0]), 8);
        let column = |a: u32| (a - ADDRESS) / 64 * 4 + (a - ADDRESS) % 64 / 4;
        (column(f.addresses[0]), column(f.addresses[1]), f.weights[0])
    };
    let (wrap, clamp) = (t(false), t(true));
    // 1 − 1e−8 is no binary32; taken as a fraction it would be texel 256.
    assert_eq!(x(&wrap, -1e-8), (255, 0, 128));
    assert_eq!(x(&clamp, -1e-8), (0, 0, 128));
    assert_eq!(x(&wrap, 1.0), (255, 0, 128));
    assert_eq!(x(&clamp, 1.0), (255, 255, 128));
    assert_eq!(x(&wrap, 0.5 / 256.0), (0, 1, 0));
    assert_eq!(x(&wrap, 3e38), x(&wrap, 0.0));
    assert_eq!(x(&wrap, f32::INFINITY), x(&wrap, 0.0));
    assert_eq!(x(&wrap, f32::NAN), x(&wrap, 0.0));
    assert_eq!(x(&clamp, f32::INFINITY), (255, 255, 0));
    assert_eq!(x(&clamp, f32::NEG_INFINITY), (0, 0, 0));
    // Sizes outside of 1 to 65,536 count as the nearest.
    let none = texture::footprint(V4([64, 0, 0, 0]), V4::default(), 8);
    assert_eq!(none.addresses, [64; 4]);
    let huge = texture::footprint(V4([64, u32::MAX, 1, CLAMP]), V4([0x3f80_0000; 4]), 8);
    assert_eq!(huge.addresses[0], 64 + 65_535 / 4 * 64 + 3 * 4);
}

/// No number, no level of that number, and more levels than there can be.
#[test]
fn levels_that_are_not_there_are_the_nearest() {
    let t = |levels: u32| V4([64, 65_536, 1, levels << LEVELS_SHIFT]);
    let level = |levels, detail: f32| texture::level(t(levels), detail.to_bits());
    assert_eq!([f32::NAN, -f32::NAN].map(|d| level(9, d)), [0, 0]);
    assert_eq!([f32::INFINITY, 1e30, 9.5].map(|d| level(9, d)), [9, 9, 9]);
    let low = [
        f32::NEG_INFINITY,
        -1e30,
        -0.5,
        -0.0,
        1e-45,
        0.5f32.next_down(),
    ];
    assert_eq!(low.map(|d| level(9, d)), [0; 6]);
    assert_eq!((level(9, 0.5), level(9, 8.5f32.next_down())), (1, 8));
    assert_eq!((level(31, 99.0), level(0, 99.0)), (16, 0));
    // Sides of 1 stay 1, and the texels of each level follow those of the one before.
    let V4(last) = texture::at_level(t(16), 16);
    assert_eq!(last, [64 + 64 * 32_768, 1, 1, 0]);
}
