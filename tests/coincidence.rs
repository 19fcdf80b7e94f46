//! Linearised contacts of pairs in motion, at special positions above all, against differences.

mod support;

use support::moving::bodies::Bodies;
use support::moving::poses::{Family, scene};
use support::moving::verdict::{Checked, Finding, checked};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Pairs that share a set of shapes.
const BATCH: usize = 512;

const SHORT: usize = 4 * BATCH;

fn tried(batch: usize, numbers: std::ops::Range<usize>) -> Vec<(usize, Vec<Checked>)> {
    let bodies = Bodies::new(batch as u64);
    numbers
        .map(|number| {
            let family = Family::ALL[number % Family::ALL.len()];
            (number, checked(&scene(&bodies, family, number as u64)))
        })
        .collect()
}

#[test]
#[ignore = "exploration"]
fn explore() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<usize>().unwrap());
    let (first, count) = (number("FIRST").unwrap_or(0), number("PAIRS").unwrap_or(SHORT));
    let (end, next) = (first + count, AtomicUsize::new(first / BATCH));
    let work = || {
        let mut all = Vec::new();
        loop {
            let batch = next.fetch_add(1, Ordering::Relaxed);
            let numbers = first.max(batch * BATCH)..end.min((batch + 1) * BATCH);
            if numbers.is_empty() {
                return all;
            }
            all.extend(tried(batch, numbers));
        }
    };
    let all: Vec<_> = thread::scope(|scope| {
        let handles: Vec<_> = (0..2).map(|_| scope.spawn(work)).collect();
        handles.into_iter().flat_map(|handle| handle.join().unwrap()).collect()
    });
    for (f, family) in Family::ALL.iter().enumerate() {
        let of: Vec<_> = all.iter().filter(|(n, _)| n % Family::ALL.len() == f).collect();
        let mut counts = std::collections::BTreeMap::new();
        for (number, found) in &of {
            let mut names: Vec<String> = found.iter().map(|c| match c.finding {
                Finding::Wrong(e) => { println!("{family:?} {number} column {} wrong {e:.1e}", c.column); "Wrong".to_string() }
                other => format!("{other:?}"),
            }).collect();
            names.sort();
            names.dedup();
            for name in names { *counts.entry(name).or_insert(0) += 1; }
        }
        println!("{family:?}: {} {counts:?}", of.len());
    }
}
