//! The smaller levels of a picture: each texel is the mean, in linear light, of the part of the level before
//! that it covers.
//!
//! An axis of `n` texels has `⌊n/2⌋` in the next level, and 1 at least. Where `n` is odd, a texel covers three
//! of them, those at the ends in part (N. Guenther, *Non-Power-of-Two Mipmap Creation*, NVIDIA 2005), so the mean
//! of a level is that of the picture. Sums are of whole numbers, and a level is made from the one before as it
//! was before its texels became bytes: the same on every host, with half a byte's error at every level.

use srp_archdesc::ops::semantics::texture::decoded;

/// A smaller level of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Texels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The texels, as those of the picture.
    pub texels: Vec<u32>,
}

/// A level in linear light, in units of 2^−24.
struct Linear {
    width: u32,
    height: u32,
    texels: Vec<[u32; 4]>,
}

/// The smaller levels of a picture of this size without end: from a single texel on all are that texel. At most two of
/// them are held at a time.
pub(super) fn smaller<'a>(
    width: u32,
    height: u32,
    texel: impl Fn(u32, u32) -> u32 + 'a,
) -> impl Iterator<Item = Level> + 'a {
    let mut last: Option<Linear> = None;
    std::iter::from_fn(move || {
        let next = match &last {
            None => halved((width, height), |x, y| {
                let texel = texel(x, y);
                std::array::from_fn(|channel| decoded(texel, channel))
            }),
            Some(level) => halved((level.width, level.height), |x, y| {
                level.texels[y as usize * level.width as usize + x as usize]
            }),
        };
        let texels = next.texels.iter().map(|&texel| encoded(texel)).collect();
        let (width, height) = (next.width, next.height);
        last = Some(next);
        Some(Level {
            width,
            height,
            texels,
        })
    })
}

/// The level that follows one of this size.
fn halved((width, height): (u32, u32), texel: impl Fn(u32, u32) -> [u32; 4]) -> Linear {
    let (across, down) = ((width / 2).max(1), (height / 2).max(1));
    let columns: Vec<Part> = (0..across).map(|x| Part::of(x, width)).collect();
    let mut texels = Vec::with_capacity(across as usize * down as usize);
    for row in (0..down).map(|y| Part::of(y, height)) {
        for column in &columns {
            let mut sum = [0; 4];
            for (y, by_row) in row.texels() {
                for (x, by_column) in column.texels() {
                    let weight = by_row * by_column;
                    for (sum, channel) in sum.iter_mut().zip(texel(x, y)) {
                        *sum += weight * u64::from(channel);
                    }
                }
            }
            let whole = row.whole * column.whole;
            texels.push(sum.map(|sum| ((sum + whole / 2) / whole) as u32));
        }
    }
    Linear {
        width: across,
        height: down,
        texels,
    }
}

/// The part of an axis that a texel of the next level covers.
struct Part {
    first: u32,
    /// The weights of the texels from the first on.
    weights: [u64; 3],
    /// Their sum.
    whole: u64,
}

impl Part {
    /// The part that texel `i` covers of an axis of `n`.
    fn of(i: u32, n: u32) -> Part {
        let half = u64::from(n / 2);
        let weights = match n {
            1 => [1, 0, 0],
            _ if n.is_multiple_of(2) => [1, 1, 0],
            _ => [half - u64::from(i), half, u64::from(i) + 1],
        };
        Part {
            first: 2 * i,
            weights,
            whole: weights.iter().sum(),
        }
    }

    /// The texels, each with its weight.
    fn texels(&self) -> impl Iterator<Item = (u32, u64)> {
        let weighted = (self.first..).zip(self.weights);
        weighted.filter(|&(_, weight)| weight > 0)
    }
}

/// The texel whose channels are nearest to these.
fn encoded(texel: [u32; 4]) -> u32 {
    let byte = |channel: usize| {
        let value = texel[channel];
        let table = |byte: u32| decoded(byte << (8 * channel), channel);
        // The least byte that is not below the value, or the one before it if that is nearer.
        let (mut low, mut high) = (0, 255);
        while low < high {
            let middle = (low + high) / 2;
            match table(middle) < value {
                true => low = middle + 1,
                false => high = middle,
            }
        }
        match low > 0 && value - table(low - 1) < table(low) - value {
            true => low - 1,
            false => low,
        }
    };
    (0..4).map(|channel| byte(channel) << (8 * channel)).sum()
}
