//! Numbered cases in batches, on all threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Processes the numbers from `first` in batches of `size`, and merges the results of each thread. `work` gets the number of the batch, and
/// the requested numbers of the batch.
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

/// Returns the number of the first case and the number of cases: the environment variables NAME_FIRST and NAME_PAIRS, or these defaults.
/// With these variables, a single failing case can be examined and an interrupted sweep resumed.
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
