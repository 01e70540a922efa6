//! Independent pieces of work on several threads, with results in their order.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The results of `work` for 0 up to `count`, on so many threads at most.
pub(crate) fn map<R: Send>(
    count: usize,
    threads: usize,
    work: impl Fn(usize) -> R + Sync,
) -> Vec<R> {
    let results: Vec<Mutex<Option<R>>> = (0..count).map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    let run = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(slot) = results.get(index) else {
                return;
            };
            let result = work(index);
            *slot.lock().expect("no thread panics with the lock held") = Some(result);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.clamp(1, count.max(1)) {
            scope.spawn(run);
        }
        run();
    });
    let taken = |slot: Mutex<Option<R>>| {
        let result = slot
            .into_inner()
            .expect("no thread panics with the lock held");
        result.expect("every piece is taken by a thread")
    };
    results.into_iter().map(taken).collect()
}
