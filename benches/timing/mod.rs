//! Median times and their formatting.

#![allow(dead_code, reason = "each bench uses a part")]

use cpu_time::ProcessTime;
use std::fmt::Display;
use std::time::{Duration, Instant};

/// Shortest duration (s) of a sample, so that the resolution of the clock has no effect.
const SHORTEST_SAMPLE: f64 = 1e-4;

const FEWEST_SAMPLES: usize = 3;

/// Restricts rayon to one thread, because the benches measure work, which threads would hide.
pub fn use_one_thread() {
    #[cfg(feature = "parallel")]
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()
        .unwrap();
}

/// Returns the median time (s) of the work over as many samples as the budget allows, and over at least three. A first run, which fills
/// caches and buffers, does not count.
pub fn median_seconds(budget: Duration, mut work: impl FnMut()) -> f64 {
    median_of_samples(budget, |runs| {
        let start = Instant::now();
        (0..runs).for_each(|_| work());
        start.elapsed().as_secs_f64() / runs as f64
    })
}

/// Returns the median processor time (s), which other programs on the same cores lengthen less than the wall time.
pub fn median_processor_seconds(budget: Duration, mut work: impl FnMut()) -> f64 {
    median_of_samples(budget, |runs| {
        processor_seconds(|| (0..runs).for_each(|_| work())) / runs as f64
    })
}

/// Returns the processor time (s) of the work over all threads.
pub fn processor_seconds(work: impl FnOnce()) -> f64 {
    let start = ProcessTime::now();
    work();
    start.elapsed().as_secs_f64()
}

/// Returns the median over the rounds of the ratio of the processor times of `work` and `reference_work`, which run one after the other in
/// each round.
pub fn median_ratio(
    rounds: usize,
    mut work: impl FnMut(),
    mut reference_work: impl FnMut(),
) -> f64 {
    let ratio = |_| {
        let reference = processor_seconds(&mut reference_work);
        processor_seconds(&mut work) / reference
    };
    median((0..rounds).map(ratio).collect())
}

fn median_of_samples(budget: Duration, mut seconds_for: impl FnMut(usize) -> f64) -> f64 {
    let mut runs = 1;
    while seconds_for(runs) * (runs as f64) < SHORTEST_SAMPLE {
        runs *= 2;
    }
    let (start, mut samples) = (Instant::now(), Vec::new());
    while samples.len() < FEWEST_SAMPLES || start.elapsed() < budget {
        samples.push(seconds_for(runs));
    }
    median(samples)
}

/// Returns the median; of two middle samples, the upper one.
pub fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

/// Formats a time (s) with three digits and its unit.
pub fn time(seconds: f64) -> String {
    let (number, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    let digits = match number {
        n if n < 10.0 => 2,
        n if n < 100.0 => 1,
        _ => 0,
    };
    format!("{number:.digits$} {unit}")
}

/// Formats a whole number with commas between thousands.
pub fn count(number: impl Display) -> String {
    let digits = format!("{number:.0}");
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}
