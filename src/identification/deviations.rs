use super::Noise;
use crate::dynamics::{State, Trajectory};
use crate::gradient::Outcome;
use crate::scalar::Scalar;
use std::f64::consts::SQRT_2;

/// Number of deviations of a body in one state.
pub(super) const PER_POSE: usize = 12;

/// Outcome with the deviations of simulated from measured poses, in units of the noise: 12 numbers for each state and body.
///
/// The first three are the deviation of the position. The others are the deviation of the rotation matrix, divided by √2. Before
/// division by the noise, the norm of these nine numbers is 2 sin(θ/2) for a rotation by θ. It is near θ for small angles.
pub(super) struct Deviations<'m> {
    /// Measured states, with the index of the recorded state of the rollout.
    pub states: Vec<(usize, &'m State)>,
    /// Observed bodies.
    pub bodies: &'m [usize],
    pub noise: Noise,
}

impl Outcome for Deviations<'_> {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let mut deviations = Vec::with_capacity(PER_POSE * self.states.len() * self.bodies.len());
        let per_position = 1.0 / self.noise.position;
        let per_rotation = 1.0 / (SQRT_2 * self.noise.rotation);
        for &(record, measured) in &self.states {
            for &body in self.bodies {
                let simulated = &trajectory.states()[record].bodies[body].pose;
                let measured = &measured.bodies[body].pose;
                let positions = simulated.translation().iter().zip(measured.translation());
                let rotations = simulated.rotation().iter().zip(measured.rotation());
                deviations.extend(positions.map(|(&s, &m)| -> T { (s - m) * per_position }));
                deviations.extend(rotations.map(|(&s, &m)| -> T { (s - m) * per_rotation }));
            }
        }
        deviations
    }
}
