//! Which steps to keep on the way, if not all can be: by binomial coefficients, so that the fewest are taken again.
//!
//! Griewank and Walther, "Algorithm 799: revolve", ACM Transactions on Mathematical Software 26 (2000), section 2.

use std::cmp;

/// Of a stretch of `length` steps whose first is kept: how many steps later the next one is to be kept, if beside the first and
/// the last there is room for so many `others`. At most `length`.
pub(super) fn next_kept(length: usize, others: usize) -> usize {
    let Some(others_behind) = others.checked_sub(1) else {
        return length;
    };
    // How often a step is taken again at most, the least that this room allows.
    let mut again = 0;
    while longest(others, again) < length {
        again += 1;
    }
    let Some(fewer) = again.checked_sub(1) else {
        return 1;
    };
    cmp::min(
        longest(others, fewer),
        length - longest(others_behind, fewer),
    )
}

/// The length of the longest stretch that can be gone back over while, beside the first step and the last, so many `others` are
/// kept, and none is taken more than `again` times again: the binomial coefficient of others + again + 2 over again + 1.
fn longest(others: usize, again: usize) -> usize {
    let mut coefficient: u128 = 1;
    for k in 1..=again as u128 + 1 {
        // Each of these is a binomial coefficient.
        let next = coefficient.saturating_mul(others as u128 + 1 + k) / k;
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
    fn again(length: usize, others: usize) -> Vec<usize> {
        let mut kept = vec![0];
        let mut taken = vec![0; length];
        let pass = |kept: &mut Vec<usize>, end: usize| {
            let first = kept[kept.len() - 1];
            let mut place = first;
            while place < end - 1 {
                let others = others + 1 - kept.len();
                place = (place + next_kept(end - place, others)).min(end - 1);
                kept.push(place);
            }
            first..end
        };
        pass(&mut kept, length);
        for place in (0..length).rev() {
            kept.retain(|&other| other <= place);
            assert!(kept.len() <= others + 2);
            if kept[kept.len() - 1] != place {
                for step in pass(&mut kept, place + 1) {
                    taken[step] += 1;
                }
            }
        }
        taken
    }

    #[test]
    fn coefficients_are_those_of_pascals_triangle() {
        for others in 1..20 {
            for again in 1..20 {
                let sum = longest(others - 1, again) + longest(others, again - 1);
                assert_eq!(longest(others, again), sum);
            }
            assert_eq!(longest(others, 0), others + 2);
            assert_eq!(longest(0, others), others + 2);
        }
        assert_eq!(longest(usize::MAX, usize::MAX), usize::MAX);
    }

    #[test]
    fn no_step_is_taken_again_more_often_than_it_must_be() {
        for others in 0..12 {
            for length in 1..300 {
                let most = again(length, others).into_iter().max();
                let bound = (0..length).find(|&again| longest(others, again) >= length);
                assert_eq!(most, bound, "{length} steps, {others} kept");
            }
        }
    }

    /// √(2l) kept steps of l allow it.
    #[test]
    fn a_million_steps_are_taken_again_once() {
        let taken = again(1_000_000, 1_415);
        assert_eq!(taken.into_iter().max(), Some(1));
    }

    /// All divisions of short stretches are compared.
    #[test]
    fn hardly_more_steps_are_taken_again_than_the_fewest() {
        const OTHERS: usize = 9;
        let mut fewest = vec![vec![0]; OTHERS];
        for length in 1..200 {
            for others in 0..OTHERS {
                // The next one is kept after `next` steps; to go back over these, they are taken again.
                let divided = |next: usize| {
                    let behind = fewest[others - 1][length - next];
                    behind
                        + if next > 1 {
                            next + fewest[others][next]
                        } else {
                            0
                        }
                };
                let undivided = (2..length).sum::<usize>();
                let divisions = (1..length).filter(|_| others > 0).map(divided);
                let least = divisions.chain([undivided]).min().unwrap();
                fewest[others].push(least);
                let found = again(length, others).into_iter().sum::<usize>();
                assert!(least <= found && 25 * found <= 26 * least);
            }
        }
    }
}
