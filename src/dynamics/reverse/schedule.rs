//! Positions of checkpoints if not all steps fit into memory. Binomial coefficients minimize the number of repeated steps.
//!
//! Griewank and Walther, "Algorithm 799: revolve", ACM Transactions on Mathematical Software 26 (2000), section 2.

use std::cmp;

/// Offset of the next checkpoint in a segment of `length` steps whose first step is stored, with `slots` free slots besides the first and
/// the last step. The offset is at most `length`.
pub(super) fn next_checkpoint(length: usize, slots: usize) -> usize {
    let Some(slots_after) = slots.checked_sub(1) else {
        return length;
    };
    // Smallest number of repetitions per step with which these slots suffice for the segment.
    let mut repetitions = 0;
    while longest_segment(slots, repetitions) < length {
        repetitions += 1;
    }
    let Some(fewer_repetitions) = repetitions.checked_sub(1) else {
        return 1;
    };
    cmp::min(
        longest_segment(slots, fewer_repetitions),
        length - longest_segment(slots_after, fewer_repetitions),
    )
}

/// Length of the longest segment that can be reversed with `slots` checkpoints besides the first and the last step. No step is repeated
/// more than `repetitions` times. The length is the binomial coefficient of slots + repetitions + 2 over repetitions + 1.
fn longest_segment(slots: usize, repetitions: usize) -> usize {
    let mut coefficient: u128 = 1;
    for k in 1..=repetitions as u128 + 1 {
        // Each intermediate value is a binomial coefficient, so the division is exact.
        let next = coefficient.saturating_mul(slots as u128 + 1 + k) / k;
        if next > usize::MAX as u128 {
            return usize::MAX;
        }
        coefficient = next;
    }
    coefficient as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of repetitions of each step of a segment whose first step is stored.
    fn repetitions(length: usize, slots: usize) -> Vec<usize> {
        let mut checkpoints = vec![0];
        let mut counts = vec![0; length];
        let pass = |checkpoints: &mut Vec<usize>, end: usize| {
            let first = checkpoints[checkpoints.len() - 1];
            let mut step_index = first;
            while step_index < end - 1 {
                let slots = slots + 1 - checkpoints.len();
                step_index = (step_index + next_checkpoint(end - step_index, slots)).min(end - 1);
                checkpoints.push(step_index);
            }
            first..end
        };
        pass(&mut checkpoints, length);
        for step_index in (0..length).rev() {
            checkpoints.retain(|&checkpoint| checkpoint <= step_index);
            assert!(checkpoints.len() <= slots + 2);
            if checkpoints[checkpoints.len() - 1] != step_index {
                for step in pass(&mut checkpoints, step_index + 1) {
                    counts[step] += 1;
                }
            }
        }
        counts
    }

    #[test]
    fn coefficients_are_those_of_pascals_triangle() {
        for slots in 1..20 {
            for repetitions in 1..20 {
                let sum = longest_segment(slots - 1, repetitions)
                    + longest_segment(slots, repetitions - 1);
                assert_eq!(longest_segment(slots, repetitions), sum);
            }
            assert_eq!(longest_segment(slots, 0), slots + 2);
            assert_eq!(longest_segment(0, slots), slots + 2);
        }
        assert_eq!(longest_segment(usize::MAX, usize::MAX), usize::MAX);
    }

    #[test]
    fn no_step_is_taken_again_more_often_than_it_must_be() {
        for slots in 0..12 {
            for length in 1..300 {
                let most = repetitions(length, slots).into_iter().max();
                let bound =
                    (0..length).find(|&repetitions| longest_segment(slots, repetitions) >= length);
                assert_eq!(most, bound, "{length} steps, {slots} checkpoints");
            }
        }
    }

    /// A million steps need about √(2·10⁶) checkpoints for one repetition.
    #[test]
    fn a_million_steps_are_taken_again_once() {
        let counts = repetitions(1_000_000, 1_415);
        assert_eq!(counts.into_iter().max(), Some(1));
    }

    /// Compares the number of repeated steps with the minimum over all divisions of short segments.
    #[test]
    fn hardly_more_steps_are_taken_again_than_the_fewest() {
        const MOST_SLOTS: usize = 9;
        let mut fewest = vec![vec![0]; MOST_SLOTS];
        for length in 1..200 {
            for slots in 0..MOST_SLOTS {
                // The next checkpoint is after `next` steps. To reverse these steps, they are repeated.
                let divided = |next: usize| {
                    let after = fewest[slots - 1][length - next];
                    after
                        + if next > 1 {
                            next + fewest[slots][next]
                        } else {
                            0
                        }
                };
                let undivided = (2..length).sum::<usize>();
                let divisions = (1..length).filter(|_| slots > 0).map(divided);
                let least = divisions.chain([undivided]).min().unwrap();
                fewest[slots].push(least);
                let total = repetitions(length, slots).into_iter().sum::<usize>();
                assert!(least <= total && 25 * total <= 26 * least);
            }
        }
    }
}
