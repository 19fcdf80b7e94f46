//! Durations of substeps, chosen from the errors of earlier substeps, within a budget of trials.

use crate::scalar::portable::{ln_1p, power};
use std::f64::consts::LN_2;

/// Safety factor of the next duration.
const SAFETY: f64 = 0.9;

/// Largest growth of the duration after an accepted substep.
const MOST_GROWTH: f64 = 5.0;

/// Smallest and largest factor of the duration after a rejected substep.
const REDUCTIONS: [f64; 2] = [0.02, 0.6];

/// Lowest assumed order of convergence of the errors. The order is lower if contact begins or ends.
const LOWEST_ORDER: f64 = 0.7;

/// Number of possible durations per factor of two.
const PER_OCTAVE: f64 = 8.0;

/// Chooses the duration of the next substep from the error of the last one and from the remaining trials.
pub(super) struct StepSize {
    /// Duration (s).
    allowed: f64,
    /// Power of the duration with which errors decrease.
    order: f64,
    /// Duration (s) and error of the last substep, if it was rejected.
    rejected: Option<(f64, f64)>,
    /// Upper bound (s) of durations that the budget requires. A longer substep was not solved, or bodies might have passed through
    /// each other in it.
    limit: f64,
    /// Shortest duration (s).
    shortest: f64,
    /// Remaining trials of the budget.
    remaining_trials: f64,
}

impl StepSize {
    /// Creates the control for one step. `allowed` (s) is the duration that the last step allowed, `order` the order of the errors,
    /// `shortest` (s) the shortest duration, and `budget` the number of trials.
    pub fn new(allowed: f64, order: f64, shortest: f64, budget: f64) -> Self {
        Self {
            allowed,
            order,
            rejected: None,
            limit: f64::INFINITY,
            shortest,
            remaining_trials: budget,
        }
    }

    /// Duration (s) that errors allow for the next substep.
    pub fn allowed(&self) -> f64 {
        self.allowed
    }

    /// Next duration (s), from the remaining time (s).
    ///
    /// Durations are the shortest one times 2^(k/8) with an integer k, except for the last one or two of a step, which share the
    /// remaining time. Most small changes of the state change no duration, so derivatives hold the durations fixed.
    pub fn next(&self, remaining: f64) -> f64 {
        let least = least_duration(remaining, self.remaining_trials).min(self.limit);
        let wanted = self.allowed.max(least).max(self.shortest);
        if wanted >= remaining {
            return remaining;
        }
        let exponent = ln_1p(wanted / self.shortest - 1.0) / LN_2 * PER_OCTAVE;
        let wanted = self.shortest * power(2.0, exponent.floor() / PER_OCTAVE);
        // Two equal substeps are better than a long one and a short one.
        wanted.min(remaining / 2.0)
    }

    /// Whether a substep cannot be shorter.
    pub fn is_shortest(&self, substep: f64) -> bool {
        substep <= self.shortest * (1.0 + 1e-9)
    }

    /// Whether the budget has no trial left for a shorter substep, so that this one must be accepted.
    pub fn is_last_trial(&self, substep: f64, remaining: f64) -> bool {
        substep <= least_duration(remaining, self.remaining_trials - 1.0)
    }

    /// Sets the next duration after an accepted substep, from its error relative to the tolerance.
    pub fn accept(&mut self, substep: f64, error: f64) {
        let growth = growth(error, self.order);
        // After a rejection the duration does not grow.
        let most = if self.rejected.is_some() {
            1.0
        } else {
            MOST_GROWTH
        };
        let next = substep * growth.min(most);
        // The end of the step shortens substeps, so a short accepted substep does not limit the next duration.
        self.allowed = if growth >= 1.0 && self.allowed.is_finite() {
            self.allowed.max(next).min(most * self.allowed.max(substep))
        } else {
            next
        };
        self.rejected = None;
        self.limit *= most;
        self.remaining_trials -= 1.0;
    }

    /// Reduces the duration after a substep that was rejected for its error, relative to the tolerance. After two rejections in a
    /// row, the order of convergence is estimated from both errors.
    pub fn reject(&mut self, substep: f64, error: f64) {
        let order = self.rejected.map_or(self.order, |(longer, before)| {
            let seen = ln_1p(before / error - 1.0) / ln_1p(longer / substep - 1.0);
            if seen.is_finite() {
                seen.clamp(LOWEST_ORDER, self.order)
            } else {
                self.order
            }
        });
        self.rejected = Some((substep, error));
        let [least, most] = REDUCTIONS;
        self.allowed = substep * growth(error, order).clamp(least, most);
        self.remaining_trials -= 1.0;
    }

    /// Reduces the duration after a trial that failed for a reason other than its error. Such a trial does not count against the
    /// budget.
    pub fn shorten(&mut self, substep: f64, factor: f64) {
        self.rejected = Some((substep, f64::INFINITY));
        self.allowed = substep * factor;
        self.limit = self.allowed;
    }
}

/// First of `substeps` durations (s) that sum to the remaining time (s), if each duration is [`MOST_GROWTH`] times the previous one. It is
/// infinite if `substeps` is zero.
fn least_duration(remaining: f64, substeps: f64) -> f64 {
    remaining * (MOST_GROWTH - 1.0) / (power(MOST_GROWTH, substeps.max(0.0)) - 1.0)
}

/// Factor of the duration at which the error would equal the tolerance, with a safety factor.
fn growth(error: f64, order: f64) -> f64 {
    SAFETY * power(error, -order.recip())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Accepted durations of a step of 1 s and the number of trials, for an error that depends on the duration.
    fn step(budget: f64, allowed: f64, error: impl Fn(f64) -> f64) -> (Vec<f64>, usize) {
        let mut size = StepSize::new(allowed, 3.0, 1e-9, budget);
        let (mut remaining, mut accepted, mut trials) = (1.0, Vec::new(), 0);
        while remaining > 0.0 {
            let substep = size.next(remaining);
            trials += 1;
            let error = error(substep);
            if error <= 1.0 || size.is_last_trial(substep, remaining) {
                size.accept(substep, error);
                accepted.push(substep);
                remaining = if substep >= remaining {
                    0.0
                } else {
                    remaining - substep
                };
            } else {
                size.reject(substep, error);
            }
        }
        (accepted, trials)
    }

    #[test]
    fn a_step_ends_within_its_budget_whatever_the_errors() {
        for budget in [1.0, 2.0, 4.0, 10.0, 100.0] {
            for allowed in [f64::INFINITY, 1e-4] {
                for error in [0.5, 10.0, 1e6] {
                    let (_, trials) = step(budget, allowed, |_| error);
                    assert!(
                        trials as f64 <= budget,
                        "{budget} {allowed} {error}: {trials}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_long_substep_that_the_budget_required_counts_if_its_error_is_small() {
        let mut size = StepSize::new(1e-6, 3.0, 1e-9, 1.0);
        let forced = size.next(1.0);
        size.accept(forced, 1e-3);
        assert!(size.allowed() >= forced, "{}", size.allowed());
    }

    #[test]
    fn a_large_budget_leaves_the_durations_to_the_errors() {
        // The error is of third order and equals the tolerance at 0.01 s.
        let (accepted, _) = step(2500.0, 1.0, |substep| (100.0 * substep).powi(3));
        let sum: f64 = accepted.iter().sum();
        assert!((sum - 1.0).abs() < 1e-12);
        assert!(accepted.iter().all(|&substep| substep <= 0.01));
        assert!(accepted.len() < 150, "{}", accepted.len());
    }

    #[test]
    fn the_budget_keeps_substeps_below_a_duration_that_failed() {
        let mut size = StepSize::new(f64::INFINITY, 3.0, 1e-9, 1.0);
        let first = size.next(1.0);
        size.shorten(first, 0.25);
        let second = size.next(1.0);
        assert!((0.2..=0.25).contains(&second), "{second}");
        // The next substep is not longer either.
        size.accept(second, 1e3);
        let third = size.next(1.0 - second);
        assert!(third <= 0.25, "{third}");
    }
}
