//! Numbered cases in batches, on all threads.

use std::collections::BTreeMap;
use std::fmt::Debug;
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

/// Number of failures of a family that the report lists individually.
const NAMED: usize = 200;

/// Results of the cases of a family.
#[derive(Debug, Default, Clone)]
pub struct Tally {
    cases: usize,
    failing: usize,
    /// Numbers of cases with a property, by its name.
    counts: BTreeMap<String, usize>,
    /// Largest noted error, divided by its tolerance.
    worst: f64,
    /// Number of the case, description, and error divided by its tolerance.
    failures: Vec<(usize, String, f64)>,
}

impl Tally {
    /// Adds a case with its failures.
    pub fn add(&mut self, number: usize, failures: impl IntoIterator<Item = (String, f64)>) {
        let before = self.failures.len();
        let failures = failures.into_iter();
        self.failures
            .extend(failures.map(|(what, error)| (number, what, error)));
        self.cases += 1;
        self.failing += usize::from(self.failures.len() > before);
    }

    pub fn count(&mut self, name: impl Into<String>, count: usize) {
        *self.counts.entry(name.into()).or_default() += count;
    }

    pub fn note(&mut self, ratio: f64) {
        self.worst = self.worst.max(ratio);
    }

    /// Asserts that at least one of `one_of` cases has a property.
    pub fn assert_often(&self, name: &str, one_of: usize) {
        let count = self.counts.get(name).copied().unwrap_or(0);
        assert!(count * one_of >= self.cases, "{name}: too few, {self:?}");
    }
}

/// Adds the results of other cases, family by family.
pub fn merge<const N: usize>(total: &mut [Tally; N], tallies: [Tally; N]) {
    for (tally, other) in total.iter_mut().zip(tallies) {
        tally.cases += other.cases;
        tally.failing += other.failing;
        tally.worst = tally.worst.max(other.worst);
        for (name, count) in other.counts {
            tally.count(name, count);
        }
        tally.failures.extend(other.failures);
        tally.failures.truncate(NAMED);
    }
}

/// Prints the results, and fails if any case failed.
pub fn report<F: Debug, const N: usize>(families: &[F; N], tallies: &[Tally; N]) {
    for (family, tally) in families.iter().zip(tallies) {
        for (number, what, error) in &tally.failures {
            println!("{family:?}, pair {number}: {what}, {error:.1e}");
        }
    }
    for (family, tally) in families.iter().zip(tallies) {
        let Tally {
            cases,
            failing,
            worst,
            counts,
            ..
        } = tally;
        println!("{family:?}: {cases} pairs, {failing} failing, worst {worst:.1e}, {counts:?}");
    }
    let failing: usize = tallies.iter().map(|tally| tally.failing).sum();
    assert_eq!(failing, 0, "failing pairs");
}
