//! The durations of substeps, chosen from the errors of those before.

use crate::scalar::portable::{ln_1p, power};
use std::f64::consts::LN_2;

/// Safety factor of the next duration.
const SAFETY: f64 = 0.9;

/// Largest growth of the duration after an accepted substep: normally, and directly after a rejection.
const MOST_GROWTH: [f64; 2] = [5.0, 1.0];

/// Smallest and largest factor of the duration after a rejected substep.
const REDUCTIONS: [f64; 2] = [0.02, 0.6];

/// Lowest assumed order of convergence of the errors. Contact that begins or ends lowers it.
const LOWEST_ORDER: f64 = 0.7;

/// Number of durations in a factor of two.
const PER_OCTAVE: f64 = 8.0;

/// The duration that the errors of the last substep allow for the next.
pub(super) struct StepSize {
    /// Duration (s).
    allowed: f64,
    /// Power of the duration with which errors decrease.
    order: f64,
    /// Duration (s) and error of the last substep, if it was rejected.
    rejected: Option<(f64, f64)>,
}

impl StepSize {
    pub fn new(allowed: f64, order: f64) -> Self {
        Self {
            allowed,
            order,
            rejected: None,
        }
    }

    /// Duration (s) that errors allow for the next substep.
    pub fn allowed(&self) -> f64 {
        self.allowed
    }

    /// The next duration (s), from the remaining time and the shortest one.
    ///
    /// Durations are the shortest one times 2^(k/8) with an integer k, except for the last one or two of a step, which share the
    /// remaining time. Most small changes of the state change no duration, so derivatives hold the durations fixed.
    pub fn next(&self, remaining: f64, shortest: f64) -> f64 {
        let wanted = self.allowed.max(shortest).min(2.0 * remaining);
        let exponent = ln_1p(wanted / shortest - 1.0) / LN_2 * PER_OCTAVE;
        let wanted = shortest * power(2.0, exponent.floor() / PER_OCTAVE);
        // Two halves instead of a long substep and a short one.
        if wanted >= remaining {
            remaining
        } else {
            wanted.min(remaining / 2.0)
        }
    }

    /// Sets the next duration after an accepted substep, from its error relative to what is allowed.
    pub fn accept(&mut self, substep: f64, error: f64) {
        let growth = growth(error, self.order);
        let most = MOST_GROWTH[usize::from(self.rejected.is_some())];
        let next = substep * growth.min(most);
        // The end of the step cuts substeps short, which says nothing about the next.
        self.allowed = if growth >= 1.0 && self.allowed.is_finite() {
            self.allowed.max(next).min(most * self.allowed)
        } else {
            next
        };
        self.rejected = None;
    }

    /// Reduces the duration after a substep that was rejected for its error, relative to what is allowed. After two rejections in a
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
    }

    /// Reduces the duration by a factor, for another reason than errors.
    pub fn shorten(&mut self, substep: f64, factor: f64) {
        self.rejected = Some((substep, f64::INFINITY));
        self.allowed = substep * factor;
    }
}

/// The factor of the duration at which an error would be just allowed.
fn growth(error: f64, order: f64) -> f64 {
    SAFETY * power(error, -order.recip())
}
