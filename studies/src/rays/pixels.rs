//! Pixels of a picture by their number in an order, and sets of them that are looked up by rank: a picture of any size
//! is gone through without a list of its pixels.

/// Words of a [`Pixels`] between two sums.
const STRIDE: usize = 8;

/// The pixel with this number on a Z-curve through a picture, column and row: the curve through a square with a power
/// of two a side, without what is outside of the picture.
pub(super) fn on_curve(number: u64, width: u32, height: u32) -> (u32, u32) {
    let inside = |size: u32, from: u32, side: u32| u64::from(size.saturating_sub(from).min(side));
    let (mut x, mut y, mut left) = (0, 0, number);
    let mut side = width.max(height).next_power_of_two();
    while side > 1 {
        side /= 2;
        for quarter in 0..4 {
            let (from_x, from_y) = (x + (quarter & 1) * side, y + (quarter >> 1) * side);
            let pixels = inside(width, from_x, side) * inside(height, from_y, side);
            if left < pixels {
                (x, y) = (from_x, from_y);
                break;
            }
            left -= pixels;
        }
    }
    (x, y)
}

/// A set of numbers from 0.
#[derive(Default)]
pub(super) struct Pixels {
    words: Vec<u64>,
    /// Members before every [`STRIDE`] words.
    before: Vec<u64>,
    members: u64,
}

impl Pixels {
    /// The numbers below `end` for which `is_member` holds.
    pub(super) fn of(end: u64, mut is_member: impl FnMut(u64) -> bool) -> Pixels {
        let mut set = Pixels::default();
        for first in (0..end).step_by(64) {
            if set.words.len().is_multiple_of(STRIDE) {
                set.before.push(set.members);
            }
            let numbers = first..end.min(first + 64);
            let word = numbers.fold(0, |word, n| word | u64::from(is_member(n)) << (n - first));
            set.members += u64::from(word.count_ones());
            set.words.push(word);
        }
        set
    }

    /// How many members there are.
    pub(super) fn len(&self) -> u64 {
        self.members
    }

    /// The members from the one of this rank on, which is below [`len`](Self::len).
    pub(super) fn from(&self, rank: u64) -> impl Iterator<Item = u64> + '_ {
        let stride = self.before.partition_point(|&before| before <= rank) - 1;
        let skipped = rank - self.before[stride];
        let words = (0u64..).zip(&self.words).skip(stride * STRIDE);
        let members = words.flat_map(|(number, &word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                let bit = (rest != 0).then(|| rest.trailing_zeros())?;
                rest &= rest - 1;
                Some(number * 64 + u64::from(bit))
            })
        });
        members.skip(skipped as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_meets_every_pixel_once_and_in_the_order_of_its_key() {
        for (width, height) in [(1, 1), (5, 3), (8, 8), (1, 9), (16, 2), (33, 20)] {
            let all: Vec<(u32, u32)> = (0..u64::from(width * height))
                .map(|n| on_curve(n, width, height))
                .collect();
            let key = |(x, y): (u32, u32)| {
                (0..8).fold(0, |key, i| {
                    key | (x >> i & 1) << (2 * i) | (y >> i & 1) << (2 * i + 1)
                })
            };
            assert!(all.is_sorted_by_key(|&p| key(p)), "{width}x{height}");
            assert!(all.windows(2).all(|p| p[0] != p[1]), "{width}x{height}");
            assert!(all.iter().all(|&(x, y)| x < width && y < height));
        }
    }

    #[test]
    fn members_are_found_by_rank() {
        for (end, every) in [(0, 1), (63, 1), (5000, 1), (5000, 7), (5000, 640), (65, 64)] {
            let is_member = |n: u64| (n * n + 1).is_multiple_of(every) || n.is_multiple_of(every);
            let set = Pixels::of(end, is_member);
            let all: Vec<u64> = (0..end).filter(|&n| is_member(n)).collect();
            assert_eq!(set.len(), all.len() as u64);
            for rank in (0..all.len()).step_by(13) {
                let found: Vec<u64> = set.from(rank as u64).take(100).collect();
                assert_eq!(
                    found,
                    all[rank..all.len().min(rank + 100)],
                    "{end} {every} {rank}"
                );
            }
        }
    }
}
