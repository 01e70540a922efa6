//! Arithmetic on rows of costs, compiled for the vectors of the host where it is called from.

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
    for (to, &from) in to.iter_mut().zip(from) {
        *to = (*to).min(from);
    }
}

/// Adds two rows and keeps the smaller sums.
#[inline(always)]
pub(super) fn relax(to: &mut [i16], from: &[i16], price: &[i16]) {
    for ((to, &from), &price) in to.iter_mut().zip(from).zip(price) {
        *to = (*to).min(from.saturating_add(price));
    }
}

/// The same with two prices.
#[inline(always)]
pub(super) fn relax_by(to: &mut [i16], from: &[i16], price: &[i16], mask: &[i16]) {
    for (((to, &from), &price), &mask) in to.iter_mut().zip(from).zip(price).zip(mask) {
        *to = (*to).min(from.saturating_add(price).saturating_add(mask));
    }
}

/// The same with three prices.
#[inline(always)]
pub(super) fn relax_by_all(to: &mut [i16], from: &[i16], (a, b, mask): (&[i16], &[i16], &[i16])) {
    let prices = a.iter().zip(b).zip(mask);
    for ((to, &from), ((&a, &b), &mask)) in to.iter_mut().zip(from).zip(prices) {
        let price = a.saturating_add(b).saturating_add(mask);
        *to = (*to).min(from.saturating_add(price));
    }
}
