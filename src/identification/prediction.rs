use super::error::check_positive;
use super::trial::Trial;
use super::{Identification, IdentificationError, Measurement};
use crate::dynamics::{BodyState, State, Trajectory, turn_between};
use crate::gradient::GradientError;
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

/// Simulated motion of a measurement, and its errors.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Prediction {
    /// Simulated states at the measured times.
    pub trajectory: Trajectory,
    /// `position_errors[i][k]` is the distance (m) of the simulated from the measured position in state i, for observed body k. The
    /// bodies have the order of [`Identification::with_observed_bodies`], or of the world.
    pub position_errors: Vec<Vec<f64>>,
    /// `rotation_errors[i][k]` is the angle (rad) of the rotation from the measured to the simulated orientation.
    pub rotation_errors: Vec<Vec<f64>>,
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
        let experiment = trial.at([&DVector::zeros(0), &nuisances])?;
        let simulated = experiment.trajectory().map_err(GradientError::from)?;
        let recorded = trial.steps().map(|step| simulated.states()[step].clone());
        let trajectory = Trajectory::new(recorded.collect())?;
        let pairs = || {
            trajectory
                .states()
                .iter()
                .zip(measurement.trajectory().states())
        };
        let position_errors = pairs()
            .map(|pair| self.errors(pair, position_error))
            .collect();
        let rotation_errors = pairs()
            .map(|pair| self.errors(pair, rotation_error))
            .collect();
        Ok(Prediction {
            trajectory,
            position_errors,
            rotation_errors,
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
}

fn position_error(simulated: &BodyState, measured: &BodyState) -> f64 {
    (simulated.position() - measured.position()).norm()
}

fn rotation_error(simulated: &BodyState, measured: &BodyState) -> f64 {
    let [from, to] = [measured, simulated].map(|state| state.pose.rotation());
    turn_between(from, to).norm()
}
