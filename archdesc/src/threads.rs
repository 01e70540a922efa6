//! Work in parts, on several threads of the host. Their number changes no result.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Runs `work` on the parts 0, 1, 2 … and returns its results in that order. Each thread has a state of its
/// own to work with, and takes the next part when it has done one. After a part without a result, no other begins.
pub fn some<S, T: Send>(
    threads: usize,
    parts: usize,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize) -> Option<T> + Sync,
) -> Vec<Option<T>> {
    let next = AtomicUsize::new(0);
    let made: Mutex<Vec<Option<T>>> = Mutex::new((0..parts).map(|_| None).collect());
    let take_parts = || {
        let mut state = state();
        loop {
            let part = next.fetch_add(1, Ordering::Relaxed);
            if part >= parts {
                return;
            }
            let Some(of_part) = work(&mut state, part) else {
                next.store(parts, Ordering::Relaxed);
                return;
            };
            made.lock().expect("no thread panics with it")[part] = Some(of_part);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.clamp(1, parts.max(1)) {
            scope.spawn(take_parts);
        }
        take_parts();
    });
    made.into_inner().expect("no thread panics with it")
}

/// Runs `work` on all parts and returns its results in their order.
pub fn each<S, T: Send>(
    threads: usize,
    parts: usize,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let made = some(threads, parts, state, |state, part| Some(work(state, part)));
    made.into_iter().flatten().collect()
}

/// Runs `work` on all parts and returns its results in their order, or `None` if a part has none.
pub fn all<S, T: Send>(
    threads: usize,
    parts: usize,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    some(threads, parts, state, work).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::{all, some};

    #[test]
    fn parts_come_in_their_order_or_not_at_all() {
        for threads in [1, 2, 7] {
            let squares = all(threads, 100, || 0, |_, i| Some(i * i));
            assert!(squares.is_some_and(|all| all.into_iter().eq((0..100).map(|i| i * i))));
            let until = |(): &mut (), i| (i != 40).then_some(i);
            assert_eq!(all(threads, 100, || (), until), None);
            let made = some(threads, 100, || (), until);
            assert!(made[..40].iter().copied().eq((0..40).map(Some)) && made[40].is_none());
        }
        assert_eq!(all(3, 0, || (), |(), i| Some(i)), Some(Vec::new()));
    }
}
