//! Arithmetic on rows of costs, compiled for the vectors of the host where it is called from.
//!
//! On arrays of up to [`VECTOR`] units most rows are a single vector. Each function treats such a row by itself,
//! without a loop: the compiler then makes a few instructions of it, where a loop of unknown length begins with
//! questions about lengths and overlaps that take longer than the sums.

use crate::modulo::negotiate::lanes::VECTOR;

type Vector = [i16; VECTOR];

/// The row, if it is a single vector.
#[inline(always)]
fn single(row: &mut [i16]) -> Option<&mut Vector> {
    row.try_into().ok()
}

#[inline(always)]
fn sum(a: Vector, b: &[i16]) -> Vector {
    let mut sum = [0; VECTOR];
    for lane in 0..VECTOR {
        sum[lane] = a[lane].saturating_add(b[lane]);
    }
    sum
}

#[inline(always)]
fn smaller(a: Vector, b: Vector) -> Vector {
    let mut least = [0; VECTOR];
    for lane in 0..VECTOR {
        least[lane] = a[lane].min(b[lane]);
    }
    least
}

/// Sets a row to the sums of two.
#[inline(always)]
pub(super) fn set(to: &mut [i16], from: &[i16], price: &[i16]) {
    for ((to, &from), &price) in to.iter_mut().zip(from).zip(price) {
        *to = from.saturating_add(price);
    }
}

/// Keeps the smaller of two rows.
#[inline(always)]
pub(super) fn least(to: &mut [i16], from: &[i16]) {
    if let (Some(to), Some(from)) = (single(to), from.first_chunk()) {
        *to = smaller(*to, *from);
        return;
    }
    for (to, &from) in to.iter_mut().zip(from) {
        *to = (*to).min(from);
    }
}

/// Adds two rows and keeps the smaller sums.
#[inline(always)]
pub(super) fn relax(to: &mut [i16], from: &[i16], price: &[i16]) {
    if let (Some(to), Some(from), Some(price)) = (
        single(to),
        from.first_chunk(),
        price.first_chunk::<VECTOR>(),
    ) {
        *to = smaller(*to, sum(*from, price));
        return;
    }
    for ((to, &from), &price) in to.iter_mut().zip(from).zip(price) {
        *to = (*to).min(from.saturating_add(price));
    }
}

/// The same with two prices.
#[inline(always)]
pub(super) fn relax_by(to: &mut [i16], from: &[i16], price: &[i16], mask: &[i16]) {
    if let (Some(to), Some(from), Some(price), Some(mask)) = (
        single(to),
        from.first_chunk(),
        price.first_chunk::<VECTOR>(),
        mask.first_chunk::<VECTOR>(),
    ) {
        *to = smaller(*to, sum(sum(*from, price), mask));
        return;
    }
    for (((to, &from), &price), &mask) in to.iter_mut().zip(from).zip(price).zip(mask) {
        *to = (*to).min(from.saturating_add(price).saturating_add(mask));
    }
}

/// The same with three prices.
#[inline(always)]
pub(super) fn relax_by_all(to: &mut [i16], from: &[i16], (a, b, mask): (&[i16], &[i16], &[i16])) {
    if let (Some(to), Some(from), Some(a), Some(b), Some(mask)) = (
        single(to),
        from.first_chunk::<VECTOR>(),
        a.first_chunk(),
        b.first_chunk::<VECTOR>(),
        mask.first_chunk::<VECTOR>(),
    ) {
        let price = sum(sum(*a, b), mask);
        *to = smaller(*to, sum(price, from));
        return;
    }
    let prices = a.iter().zip(b).zip(mask);
    for ((to, &from), ((&a, &b), &mask)) in to.iter_mut().zip(from).zip(prices) {
        let price = a.saturating_add(b).saturating_add(mask);
        *to = (*to).min(from.saturating_add(price));
    }
}
