//! Rows of costs by unit.

use crate::modulo::negotiate::{LATE, MOST_LATE};
use crate::modulo::rows::VECTOR;

/// Lowers a row of costs to those of operations in a slot.
#[inline(always)]
pub(super) fn operation_row(totals: &mut [i32], issue: &[i16], hold: Option<&[i16]>, mask: &[i32]) {
    match hold {
        Some(hold) => {
            let prices = issue.iter().zip(hold).zip(mask);
            for (total, ((&issue, &hold), &mask)) in totals.iter_mut().zip(prices) {
                *total = (*total).min(i32::from(issue) + i32::from(hold) + mask);
            }
        }
        None => {
            for (total, (&issue, &mask)) in totals.iter_mut().zip(issue.iter().zip(mask)) {
                *total = (*total).min(i32::from(issue) + mask);
            }
        }
    }
}

/// Adds a row of costs, none more than the edge costs without a route.
#[inline(always)]
pub(super) fn add(totals: &mut [i32], row: Option<&[i16]>, open: i32, late: i32, reach: &[i16]) {
    let late = late.clamp(-2 * MOST_LATE, MOST_LATE) as i16;
    let (open, most) = (open as i16, MOST_LATE as i16);
    let price = |reach: i16| open + LATE as i16 * (late + reach).clamp(0, most);
    // As in the rows of deliveries, a single vector goes without a loop.
    if let (Ok(totals), Some(row), Some(reach)) = (
        <&mut [i32; VECTOR]>::try_from(&mut *totals),
        row.and_then(|row| row.first_chunk::<VECTOR>()),
        reach.first_chunk::<VECTOR>(),
    ) {
        for lane in 0..VECTOR {
            totals[lane] += i32::from(row[lane].min(price(reach[lane])));
        }
        return;
    }
    match row {
        Some(row) => {
            for ((total, &cost), &reach) in totals.iter_mut().zip(row).zip(reach) {
                *total += i32::from(cost.min(price(reach)));
            }
        }
        None => {
            for (total, &reach) in totals.iter_mut().zip(reach) {
                *total += i32::from(price(reach));
            }
        }
    }
}

/// The least of a row of costs, and of `most`.
#[inline(always)]
pub(super) fn least_of(row: &[i32], most: i32) -> i32 {
    match row.first_chunk::<VECTOR>() {
        Some(only) if row.len() == VECTOR => only.iter().fold(most, |least, &cost| least.min(cost)),
        _ => row.iter().fold(most, |least, &cost| least.min(cost)),
    }
}
