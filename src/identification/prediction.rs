use super::deviations::Deviations;
use super::error::check_positive;
use super::trial::{Point, Trial};
use super::{Checkpoint, Evaluated, Identification, IdentificationError, Measurement, RobustLoss};
use crate::dynamics::{BodyState, State, Trajectory, turn_between};
use crate::gradient::{GradientError, Outcome};
use nalgebra::DVector;

/// Initial state of a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum StartingState {
    /// The first measured state.
    Measured,
    /// The first measured state with the nuisances that fit the states of this duration (s) best.
    Fitted(f64),
}

/// Simulated motion of a measurement, and its errors. The observed bodies have the order of
/// [`Identification::with_observed_bodies`], or of the world.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Prediction {
    /// Simulated states at the measured times.
    pub trajectory: Trajectory,
    /// `position_errors[i][k]` is the distance (m) of the simulated from the measured position in state i, for observed body k.
    pub position_errors: Vec<Vec<f64>>,
    /// `rotation_errors[i][k]` is the angle (rad) of the rotation from the measured to the simulated orientation.
    pub rotation_errors: Vec<Vec<f64>>,
    /// `normalized_errors[i][k]` is √s, with the squared deviation s of the pose in units of the [`Noise`](super::Noise): see
    /// [`RobustLoss`].
    pub normalized_errors: Vec<Vec<f64>>,
}

impl Prediction {
    /// Mean squared normalized error of each observed body in the states after the first, which are the states that a fit compares. For a
    /// correct model it is near 6, or less if few states determine the nuisances.
    #[must_use]
    pub fn mean_squares(&self) -> Vec<f64> {
        let count = self.normalized_errors.first().map_or(0, Vec::len);
        let mut means = vec![0.0; count];
        let states = self.normalized_errors.iter().skip(1);
        let weight = 1.0 / states.len() as f64;
        for errors in states {
            for (mean, error) in means.iter_mut().zip(errors) {
                *mean += weight * error * error;
            }
        }
        means
    }
}

impl Identification {
    /// Simulates a measurement with values of the unknowns, and compares all of its states. Use this method for measurements that were
    /// not fitted.
    ///
    /// # Errors
    /// - If the measurement does not fit the world or the time steps of the plan.
    /// - If the number of values is wrong, a value is out of range, or the duration of the start is not positive and finite.
    /// - If the rollout ends early, or the cancel flag is set.
    pub fn predict(
        &self,
        values: &[f64],
        measurement: &Measurement,
        start: StartingState,
    ) -> Result<Prediction, IdentificationError> {
        let known = self.with_known_unknowns(values)?;
        let nuisances = match start {
            StartingState::Measured => DVector::zeros(self.nuisances.len()),
            StartingState::Fitted(duration) => {
                check_positive("the duration to which the start is fitted (s)", duration)?;
                let fit = known.fit(&[measurement.beginning(duration)])?;
                fit.checkpoint.nuisances[0].clone()
            }
        };
        let trial = Trial::new(&known, measurement, f64::INFINITY)?;
        Ok(known.compared(&trial, [&DVector::zeros(0), &nuisances])?)
    }

    /// Simulates each measurement of a fit with the unknowns and nuisances of a checkpoint, usually [`Fit::checkpoint`](super::Fit), and
    /// compares all of its states. The simulations run on all threads.
    ///
    /// The result of a measurement is an error if its rollout ends early.
    ///
    /// # Errors
    /// - If a measurement does not fit the world or the time steps of the plan.
    /// - If the checkpoint has another number of unknowns, nuisances or measurements, or its horizon index is too large.
    /// - If the cancel flag is set.
    pub fn residuals(
        &self,
        measurements: &[Measurement],
        checkpoint: &Checkpoint,
    ) -> Evaluated<Prediction> {
        let (threads, all) = self.threads(measurements, checkpoint)?;
        threads.map(checkpoint, &all, f64::INFINITY, |trial, point| {
            self.compared(trial, point)
        })
    }

    /// Simulated motion at a point, compared with all states of the measurement of a trial.
    fn compared(&self, trial: &Trial, point: Point) -> Result<Prediction, GradientError> {
        let simulated = trial.at(point)?.trajectory()?;
        let recorded = trial.steps().map(|step| simulated.states()[step].clone());
        let trajectory = Trajectory::new(recorded.collect())?;
        let measured = trial.measurement().trajectory().states();
        let errors = |error: fn(&BodyState, &BodyState) -> f64| {
            let pairs = trajectory.states().iter().zip(measured);
            pairs.map(|pair| self.errors(pair, error)).collect()
        };
        Ok(Prediction {
            position_errors: errors(position_error),
            rotation_errors: errors(rotation_error),
            normalized_errors: self.normalized_errors(&trajectory, measured),
            trajectory,
        })
    }

    /// Errors of the observed bodies in a simulated and a measured state.
    fn errors(
        &self,
        (simulated, measured): (&State, &State),
        error: impl Fn(&BodyState, &BodyState) -> f64,
    ) -> Vec<f64> {
        let bodies = self.observed.iter();
        bodies
            .map(|&body| error(&simulated.bodies[body], &measured.bodies[body]))
            .collect()
    }

    /// Roots of the squared deviations of the observed bodies in all states, in units of the noise.
    fn normalized_errors(&self, simulated: &Trajectory, measured: &[State]) -> Vec<Vec<f64>> {
        let deviations = Deviations {
            states: measured.iter().enumerate().collect(),
            bodies: &self.observed,
            noise: self.noise,
        };
        let deviations = deviations.of(simulated);
        let squared = RobustLoss::Squared.of_poses(&deviations);
        let errors: Vec<f64> = squared.map(|[squared, _]| squared.sqrt()).collect();
        let per_state = self.observed.len();
        (0..measured.len())
            .map(|state| errors[state * per_state..(state + 1) * per_state].to_vec())
            .collect()
    }
}

fn position_error(simulated: &BodyState, measured: &BodyState) -> f64 {
    (simulated.position() - measured.position()).norm()
}

fn rotation_error(simulated: &BodyState, measured: &BodyState) -> f64 {
    let [from, to] = [measured, simulated].map(|state| state.pose.rotation());
    turn_between(from, to).norm()
}
