use crate::tosses::{TRUTH, clean, noise, noisy, nuisances, plan, unknowns, world};
use hydroelastic::identification::{Identification, Termination};
use hydroelastic::parallel;
use std::ops::RangeInclusive;

/// Counts the intervals that contain the true value, for each unknown.
fn covered(tosses: u64, repetitions: u64) -> [usize; 3] {
    let clean = clean(tosses);
    let guess = TRUTH.map(|value| 1.3 * value);
    let identification = Identification::new(&world(guess), &plan(), &unknowns()).unwrap();
    let identification = identification.with_noise(noise());
    let identification = identification.with_nuisances(&nuisances()).unwrap();
    let seeds: Vec<u64> = (0..repetitions).collect();
    let fits = parallel::map(&seeds, |&seed| {
        identification.fit(&noisy(&clean, seed)).unwrap()
    });
    let mut counts = [0; 3];
    for fit in fits {
        assert_eq!(fit.termination, Termination::Converged);
        for ((estimate, truth), count) in fit.estimates.iter().zip(TRUTH).zip(&mut counts) {
            let [lower, upper] = estimate.interval;
            *count += usize::from((lower..=upper).contains(&truth));
        }
    }
    counts
}

fn assert_covered(counts: [usize; 3], expected: RangeInclusive<usize>) {
    println!("intervals with the true value: {counts:?}");
    assert!(
        counts.iter().all(|count| expected.contains(count)),
        "{counts:?}"
    );
}

/// For right 95 % intervals, fewer than 6 of 8 contain the true value with a probability of 0.6 %.
#[test]
fn intervals_contain_the_true_values() {
    assert_covered(covered(2, 8), 6..=8);
}

#[test]
#[ignore = "takes minutes"]
fn intervals_of_200_repetitions_contain_the_true_values() {
    assert_covered(covered(3, 200), 180..=198);
}
