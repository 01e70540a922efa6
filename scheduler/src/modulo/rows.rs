//! Arithmetic on rows of costs, compiled for the vectors of the host where it is called from.
//!
//! Rows are whole vectors. Each function takes them apart into arrays of [`VECTOR`] lanes: the compiler then
//! makes a few instructions of each, where a loop over lanes begins with questions about lengths and overlaps
//! that take longer than the sums of a short row.

/// The price of the impossible: more than any sum of other prices.
pub(super) const NEVER: i16 = 20_000;

/// Lanes of a vector register, at most: rows are multiples of it.
pub(super) const VECTOR: usize = 16;

/// So many costs at a time.
pub(super) type Vector = [i16; VECTOR];

/// Calls one of two functions that do the same: the second is compiled for vectors of 256 bits, for hosts
/// that have them.
macro_rules! wide {
    ($here:expr => $wide:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[expect(unsafe_code, reason = "the host was asked for what the function needs")]
            match std::arch::is_x86_feature_detected!("avx2") {
                true => unsafe { $wide },
                false => $here,
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        $here
    }};
}
pub(super) use wide;

#[inline(always)]
pub(super) fn vectors(row: &[i16]) -> &[Vector] {
    row.as_chunks().0
}

#[inline(always)]
pub(super) fn vectors_mut(row: &mut [i16]) -> &mut [Vector] {
    row.as_chunks_mut().0
}

#[inline(always)]
pub(super) fn sum(a: Vector, b: Vector) -> Vector {
    let mut sum = [0; VECTOR];
    for lane in 0..VECTOR {
        sum[lane] = a[lane].saturating_add(b[lane]);
    }
    sum
}

#[inline(always)]
pub(super) fn smaller(a: Vector, b: Vector) -> Vector {
    let mut least = [0; VECTOR];
    for lane in 0..VECTOR {
        least[lane] = a[lane].min(b[lane]);
    }
    least
}

/// Sets a row to the sums of two.
#[inline(always)]
pub(super) fn set(to: &mut [i16], from: &[i16], price: &[i16]) {
    let rows = vectors(from).iter().zip(vectors(price));
    for (to, (&from, &price)) in vectors_mut(to).iter_mut().zip(rows) {
        *to = sum(from, price);
    }
}

/// Keeps the smaller of two rows.
#[inline(always)]
pub(super) fn least(to: &mut [i16], from: &[i16]) {
    for (to, &from) in vectors_mut(to).iter_mut().zip(vectors(from)) {
        *to = smaller(*to, from);
    }
}

/// Adds two rows and keeps the smaller sums.
#[inline(always)]
pub(super) fn relax(to: &mut [i16], from: &[i16], price: &[i16]) {
    let rows = vectors(from).iter().zip(vectors(price));
    for (to, (&from, &price)) in vectors_mut(to).iter_mut().zip(rows) {
        *to = smaller(*to, sum(from, price));
    }
}

/// The same with two prices.
#[inline(always)]
pub(super) fn relax_by(to: &mut [i16], from: &[i16], price: &[i16], mask: &[i16]) {
    let rows = vectors(from).iter().zip(vectors(price)).zip(vectors(mask));
    for (to, ((&from, &price), &mask)) in vectors_mut(to).iter_mut().zip(rows) {
        *to = smaller(*to, sum(sum(from, price), mask));
    }
}

/// The same with three prices.
#[inline(always)]
pub(super) fn relax_by_all(to: &mut [i16], from: &[i16], (a, b, mask): (&[i16], &[i16], &[i16])) {
    let prices = vectors(a).iter().zip(vectors(b)).zip(vectors(mask));
    let rows = vectors(from).iter().zip(prices);
    for (to, (&from, ((&a, &b), &mask))) in vectors_mut(to).iter_mut().zip(rows) {
        *to = smaller(*to, sum(sum(sum(a, b), mask), from));
    }
}
