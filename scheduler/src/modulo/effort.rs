//! Efforts: how many steps a search has, by the size of the loop and by what there is to save.

/// Steps for each operation that an attempt at the first II that works has at least: with fewer, IIs are missed
/// at which a schedule is soon found.
const FIRST: u64 = 8_000;
/// Operations of a loop that gets the effort once, and of one that gets the most.
const FEW: u64 = 32;
pub(super) const MANY: usize = 128;
/// The effort goes once to a loop that could save one cycle in so many, and so many times at most to one that
/// could save more.
const WORTHWHILE: u32 = 8;
const MOST_WORTH: u64 = 6;

/// Steps of an attempt at the first II that works.
pub(super) fn of_first(effort: u64, operations: usize) -> u64 {
    effort.max(FIRST * FEW.max(operations as u64))
}

/// Steps of the search for smaller IIs.
pub(super) fn of_improvement(effort: u64, operations: usize) -> u64 {
    effort.saturating_mul(operations.min(MANY) as u64) / FEW
}

/// Steps after which the placing of so many operations one by one is given up. What succeeds takes some thousand for each
/// operation, of small loops up to some ten thousand; what fails would go on for thousands of times as many where
/// routes are long.
pub(super) fn of_placing(operations: usize) -> u64 {
    FIRST * operations.max(MANY) as u64
}

/// The part of an effort, or the multiple, that a better II is worth: it grows with the square of the part of the cycles that the
/// bound would save, since a search for more of them takes longer and brings more.
pub(super) fn worth(effort: u64, ii: u32, bound: u32) -> u64 {
    let saved = u128::from(WORTHWHILE * (ii - bound));
    let whole = u128::from(ii);
    let worth = u128::from(effort) * saved * saved / (whole * whole);
    u64::try_from(worth).map_or(u64::MAX, |worth| {
        worth.min(effort.saturating_mul(MOST_WORTH))
    })
}
