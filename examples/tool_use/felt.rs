//! Force and work of the hand.

use super::hand::{DOWN, Hand};
use super::scene::{RATE, TOOL};
use super::show::{Curve, Panel};
use hydroelastic::dynamics::{State, Trajectory};
use hydroelastic::gradient::Outcome;
use hydroelastic::scalar::{Scalar, lift};
use nalgebra::Vector3;

/// Downward force (N) of the hand at the end of its downward motion, and total work (J) of the hand.
pub struct Felt(pub Hand);

impl Outcome for Felt {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let states = trajectory.states();
        let pressed = -self.force_in(&states[step_at(DOWN[1])]).z;
        let powers = states
            .iter()
            .map(|state| self.force_in(state).dot(state.bodies[TOOL].velocity()));
        let work = powers.sum::<T>() * lift::<T>(1.0 / RATE);
        vec![pressed, work]
    }
}

impl Felt {
    fn force_in<T: Scalar>(&self, state: &State<T>) -> Vector3<T> {
        self.0.force_on(&state.bodies[TOOL], state.time)
    }

    /// Plots the hand's force along x and downward.
    pub fn over_time(&self, trajectory: &Trajectory) -> Panel {
        let states = trajectory.states().iter();
        let forces: Vec<_> = states.map(|s| (s.time, self.force_in(s))).collect();
        let curve = |name, part: fn(&Vector3<f64>) -> f64| {
            Curve::new(
                name,
                forces.iter().map(|(time, force)| (*time, part(force))),
            )
        };
        Panel {
            x_label: "time (s)",
            y_label: "force of the hand (N)",
            is_log: false,
            curves: vec![curve("downwards", |f| -f.z), curve("along x", |f| f.x)],
        }
    }
}

/// Returns the step that ends at a time (s).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "times are a few tenths of a second"
)]
pub fn step_at(time: f64) -> usize {
    (time * RATE).round() as usize
}
