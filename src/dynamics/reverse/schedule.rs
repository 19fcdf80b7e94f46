//! Which steps to keep on the way, if not all can be: by binomial coefficients, so that the fewest are taken again.
//!
//! Griewank and Walther, "Algorithm 799: revolve", ACM Transactions on Mathematical Software 26 (2000), section 2.

use std::cmp;

/// Of a stretch of `length` steps whose first is kept: how many steps later the next one is to be kept, if beside the first and
/// the last there is room for so many `others`. At most `length`.
pub(super) fn next_checkpoint(length: usize, slots: usize) -> usize {
    let Some(slots_after) = slots.checked_sub(1) else {
        return length;
    };
    // How often a step is taken again at most, the least that this room allows.
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

/// The length of the longest stretch that can be gone back over while, beside the first step and the last, so many `others` are
/// kept, and none is taken more than `again` times again: the binomial coefficient of others + again + 2 over again + 1.
fn longest_segment(slots: usize, repetitions: usize) -> usize {
    let mut coefficient: u128 = 1;
    for k in 1..=repetitions as u128 + 1 {
        // Each of these is a binomial coefficient.
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

    /// How often each step of a stretch, the first kept, is taken again.
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
            checkpoints.retain(|&other| other <= step_index);
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

    /// √(2l) kept steps of l allow it.
    #[test]
    fn a_million_steps_are_taken_again_once() {
        let counts = repetitions(1_000_000, 1_415);
        assert_eq!(counts.into_iter().max(), Some(1));
    }

    /// All divisions of short stretches are compared.
    #[test]
    fn hardly_more_steps_are_taken_again_than_the_fewest() {
        const MOST_SLOTS: usize = 9;
        let mut fewest = vec![vec![0]; MOST_SLOTS];
        for length in 1..200 {
            for slots in 0..MOST_SLOTS {
                // The next one is kept after `next` steps; to go back over these, they are taken again.
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
