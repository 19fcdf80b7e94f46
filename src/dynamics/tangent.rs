//! Local coordinates of states: the difference of two states as one vector, with as many numbers as there are degrees of freedom.

use super::rigid_motion::turn_between;
use super::validate::check_finite;
use super::{BodyState, Force, State, World, WorldError};
use crate::spatial::{Pose, Twist};
use nalgebra::{DVector, Vector6};

/// Number of local coordinates of each dynamic body.
pub(crate) const STATE_DIM: usize = 12;

impl<F: Force> World<f64, F> {
    /// Change from one state to another: 12 numbers for each dynamic body, in the order of the world. The first six are the motion of the
    /// pose as in [`Pose::moved_by`] (angular in rad, at most half a turn, linear in m). The last six are the change of the twist (spin in
    /// rad/s, velocity of the center of mass in m/s).
    ///
    /// # Errors
    /// - If the world has joints.
    /// - If a state does not fit the world.
    /// - If the change is not finite.
    pub fn difference(&self, from: &State, to: &State) -> Result<DVector<f64>, WorldError> {
        self.model.refuse_joints("the difference of states")?;
        from.check_fits(self.bodies())?;
        to.check_fits(self.bodies())?;
        let numbers = self.model.dynamic_bodies().flat_map(|body| {
            let [from, to] = [from, to].map(|state| &state.bodies[body]);
            let pose = turn_and_shift(&from.pose, &to.pose);
            let twist = to.twist.to_vector() - from.twist.to_vector();
            pose.iter().chain(&twist).copied().collect::<Vec<_>>()
        });
        let numbers: Vec<f64> = numbers.collect();
        check_finite("change between two states", &numbers)?;
        Ok(numbers.into())
    }

    /// State after a change in local coordinates: the inverse of [`Self::difference`]. The time, and the states of fixed and kinematic
    /// bodies, stay the same.
    ///
    /// # Errors
    /// - If the world has joints.
    /// - If the state before or after the change does not fit the world.
    /// - If the change does not have 12 finite numbers for each dynamic body.
    pub fn integrate(&self, state: &State, change: &[f64]) -> Result<State, WorldError> {
        self.model.refuse_joints("the change of a state")?;
        state.check_fits(self.bodies())?;
        check_finite("change of a state", change)?;
        let (found, expected) = (
            change.len(),
            STATE_DIM * self.model.dynamic_bodies().count(),
        );
        if found != expected {
            return Err(WorldError::ChangeSize { found, expected });
        }
        let mut moved = state.clone();
        for (body, numbers) in self.model.dynamic_bodies().zip(change.chunks(STATE_DIM)) {
            let [pose, twist] = [0, 6].map(|first| {
                Twist::from_vector(&Vector6::from_column_slice(&numbers[first..first + 6]))
            });
            let BodyState {
                pose: old_pose,
                twist: old_twist,
            } = state.bodies[body];
            moved.bodies[body] = BodyState {
                pose: old_pose.moved_by(&pose),
                twist: Twist {
                    angular: old_twist.angular + twist.angular,
                    linear: old_twist.linear + twist.linear,
                },
            };
        }
        moved.check_fits(self.bodies())?;
        Ok(moved)
    }
}

/// Motion (angular, linear) from one pose to another.
fn turn_and_shift(from: &Pose, to: &Pose) -> Vector6<f64> {
    let twist = Twist {
        angular: turn_between(from, to),
        linear: to.translation() - from.translation(),
    };
    twist.to_vector()
}
