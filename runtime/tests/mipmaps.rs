//! Smaller levels of pictures against areas in binary64: each texel is the byte nearest to the mean of what it
//! covers.

mod support;

use srp_runtime::scene::{Level, Texture};
use support::Random;

/// A level in linear light, 0 to 1, row by row.
struct Linear {
    size: [u32; 2],
    texels: Vec<[f64; 4]>,
}

/// IEC 61966-2-1; alpha is linear.
fn linear(byte: u8, channel: usize) -> f64 {
    let c = f64::from(byte) / 255.0;
    match c {
        _ if channel == 3 => c,
        ..=0.04045 => c / 12.92,
        _ => ((c + 0.055) / 1.055).powf(2.4),
    }
}

/// The parts of a texel of an axis of `n` that lie in part `i` of `m` equal ones, as shares of that part.
fn overlaps(i: u32, m: u32, n: u32) -> Vec<(u32, f64)> {
    let [from, to] = [i, i + 1].map(|k| f64::from(k) * f64::from(n) / f64::from(m));
    let inside = |k: u32| (f64::from(k) + 1.0).min(to) - f64::from(k).max(from);
    let texels = (0..n).map(|k| (k, inside(k) / (to - from)));
    texels.filter(|&(_, share)| share > 1e-12).collect()
}

fn halved(level: &Linear) -> Linear {
    let [width, height] = level.size;
    let size = level.size.map(|side| (side / 2).max(1));
    let mut texels = Vec::new();
    for y in 0..size[1] {
        for x in 0..size[0] {
            let mut mean = [0.0; 4];
            for (row, down) in overlaps(y, size[1], height) {
                for (column, across) in overlaps(x, size[0], width) {
                    let texel = level.texels[(row * width + column) as usize];
                    for (mean, channel) in mean.iter_mut().zip(texel) {
                        *mean += down * across * channel;
                    }
                }
            }
            texels.push(mean);
        }
    }
    Linear { size, texels }
}

fn check(texture: &Texture) {
    let size = [texture.width, texture.height];
    let texels = texture.texels.iter().map(|texel| {
        let bytes = texel.to_le_bytes();
        std::array::from_fn(|c| linear(bytes[c], c))
    });
    let mut exact = Linear {
        size,
        texels: texels.collect(),
    };
    let levels: Vec<Level> = texture.smaller().collect();
    assert_eq!(levels.len() as u32, texture.smaller_levels());
    for (number, level) in (1..).zip(&levels) {
        exact = halved(&exact);
        assert_eq!([level.width, level.height], exact.size);
        assert_eq!(level.texels.len(), exact.texels.len());
        for (at, (texel, exact)) in level.texels.iter().zip(&exact.texels).enumerate() {
            for (channel, (&byte, &exact)) in texel.to_le_bytes().iter().zip(exact).enumerate() {
                let off = |byte: u8| (linear(byte, channel) - exact).abs();
                let others = [byte.saturating_sub(1), byte.saturating_add(1)];
                // A few units of 2^-24 for a level's rounding.
                let slack = f64::from(number) * 2.0 / f64::from(1 << 24);
                let nearest = others.iter().all(|&other| off(byte) <= off(other) + slack);
                assert!(
                    nearest,
                    "{size:?} level {number} texel {at} channel {channel}: {byte} for {exact}"
                );
            }
        }
    }
    let last = levels.last().map(|level| (level.width, level.height));
    assert!(last.is_none_or(|size| size == (1, 1)));
}

#[test]
fn each_texel_is_the_mean_of_what_it_covers() {
    let mut random = Random::new(5);
    let mut sizes = vec![
        (1, 1),
        (1, 9),
        (16, 1),
        (2, 3),
        (3, 3),
        (64, 64),
        (5, 64),
        (101, 7),
    ];
    sizes.extend((0..40).map(|_| (1 + random.below(40) as u32, 1 + random.below(40) as u32)));
    for (width, height) in sizes {
        let texels = (0..width * height).map(|_| match random.below(4) {
            0 => 0,
            1 => u32::MAX,
            _ => random.next(),
        });
        check(&Texture {
            name: "noise".to_owned(),
            width,
            height,
            texels: texels.collect(),
            levels: true,
        });
    }
}

/// Half white and half black is the byte of half the light, 188, and not 128.
#[test]
fn light_is_averaged_and_not_bytes() {
    let texels = (0..64u32).map(|i| {
        if (i + i / 8) % 2 == 0 {
            u32::MAX
        } else {
            0xff00_0000
        }
    });
    let board = Texture {
        name: "board".to_owned(),
        width: 8,
        height: 8,
        texels: texels.collect(),
        levels: true,
    };
    let levels: Vec<Level> = board.smaller().collect();
    assert_eq!(
        levels.iter().map(|l| l.width).collect::<Vec<_>>(),
        [4, 2, 1]
    );
    for level in &levels {
        assert!(level.texels.iter().all(|&texel| texel == 0xffbc_bcbc));
    }
    let without = Texture {
        levels: false,
        ..board
    };
    assert_eq!(
        (without.smaller_levels(), without.smaller().count()),
        (0, 0)
    );
    assert_eq!(without.bytes(), 256);
}
