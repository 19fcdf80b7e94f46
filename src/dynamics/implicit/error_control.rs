//! Tolerances of a substep, for each body.

use super::StepContext;
use super::island::Island;
use crate::dynamics::Accuracy;

/// The resting speed of a body is the speed after a fall by this fraction of its smallest extent. See [`StepContext::length`] for a body
/// without a shape.
const RESTING_FALL: f64 = 0.01;

/// Gravity (m/s²) of that fall, also in a world without gravity.
const STANDARD_GRAVITY: f64 = 9.806_65;

/// Longest time (s) for which an error of a velocity counts in a derivative.
const LONGEST_FLIGHT: f64 = 1.0;

/// Tolerances of the bodies of an island in a step.
#[derive(Debug, Clone)]
pub(super) struct ErrorControl {
    pub accuracy: Accuracy,
    gravity: f64,
    /// Resting speed (m/s) of each dynamic body.
    resting: Vec<f64>,
    /// Largest speed (m/s) of each dynamic body in the step so far, relative to the bodies that it touches. It is at least the speed of the
    /// spin of the body.
    pub speeds: Vec<f64>,
}

impl ErrorControl {
    pub fn new(context: &StepContext, island: &Island, accuracy: Accuracy) -> Self {
        let gravity = context.model.gravity.norm();
        let resting = |&body: &usize| {
            let fall = RESTING_FALL * context.length(body);
            let default = (2.0 * STANDARD_GRAVITY * fall).sqrt();
            accuracy.resting_speed_or(default)
        };
        Self {
            accuracy,
            gravity,
            resting: island.dynamic.iter().map(resting).collect(),
            speeds: vec![0.0; island.dynamic.len()],
        }
    }

    /// Tolerance of the velocity (m/s) of a body at a speed (m/s).
    pub fn velocity(&self, index: usize, speed: f64) -> f64 {
        self.allowed(self.accuracy.values(), index, speed)
    }

    /// Tolerance of the derivatives (m/s) of a body along the motion at a speed (m/s).
    pub fn slope(&self, index: usize, speed: f64) -> f64 {
        self.allowed(self.accuracy.slopes(), index, speed)
    }

    /// Time (s) for which an error of a velocity counts in a derivative: the time in which gravity changes the velocity by `speed`.
    pub fn flight(&self, speed: f64) -> f64 {
        LONGEST_FLIGHT.min(speed / self.gravity)
    }

    /// Tolerance at a speed, by the formula of [`Accuracy`].
    fn allowed(&self, tolerance: f64, index: usize, speed: f64) -> f64 {
        let resting = self.resting[index];
        let slow = tolerance * resting * (resting / speed).powi(3);
        tolerance * speed + slow.min(tolerance.sqrt().sqrt() * resting)
    }
}
