//! Numbered cases in batches, on all threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Works through the numbers from `first` in batches of `size`, and merges what each thread has gathered. `work` takes the
/// number of the batch, and those of its numbers that are asked for.
pub fn in_batches<S: Default + Send>(
    (first, count): (usize, usize),
    size: usize,
    work: impl Fn(&mut S, usize, Range<usize>) + Sync,
    merge: impl Fn(&mut S, S),
) -> S {
    let (end, next) = (first + count, AtomicUsize::new(first / size));
    let gathered = || {
        let mut sum = S::default();
        loop {
            let batch = next.fetch_add(1, Ordering::Relaxed);
            let numbers = first.max(batch * size)..end.min((batch + 1) * size);
            if numbers.is_empty() {
                return sum;
            }
            work(&mut sum, batch, numbers);
        }
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let mut total = S::default();
    thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(gathered)).collect();
        for handle in handles {
            merge(&mut total, handle.join().unwrap());
        }
    });
    total
}

/// The number of the first case and how many: what the environment says in NAME_FIRST and NAME_PAIRS, and else these. A case
/// that failed can be looked at by itself, and a sweep taken up where it was left.
pub fn range_from_environment(name: &str, (first, count): (usize, usize)) -> (usize, usize) {
    let number = |of: &str| {
        let text = std::env::var(format!("{name}_{of}")).ok();
        text.map(|text| text.parse().unwrap())
    };
    (
        number("FIRST").unwrap_or(first),
        number("PAIRS").unwrap_or(count),
    )
}
