//! Tangent-space coordinates of states: the difference of two states as one vector, with two numbers for each degree of freedom.

use super::joint::JointKind;
use super::rigid_motion::turn_between;
use super::validate::check_finite;
use super::{BodyState, Force, JointState, Model, State, World, WorldError};
use crate::scalar::Scalar;
use crate::spatial::Twist;
use nalgebra::{DVector, Vector3, Vector6};
use std::ops::Range;

/// Number of tangent-space coordinates of a free body.
pub(crate) const STATE_DIM: usize = 12;

/// Part of a state with tangent-space coordinates of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TangentPart {
    /// Index of the body.
    pub body: usize,
    /// Index of the state of the body's joint, or `None` for a free body.
    pub joint: Option<usize>,
    /// Number of coordinates: positions, then as many velocities.
    pub dimension: usize,
}

impl<T: Scalar> Model<T> {
    /// Parts of a state, in the order of their coordinates.
    pub(crate) fn tangent_parts(&self) -> impl Iterator<Item = TangentPart> {
        let bodies = self.bodies.iter().enumerate();
        bodies.filter_map(|(index, body)| {
            let kind = body.joint()?.kind;
            let joint = self.joint_state_index(index);
            (kind == JointKind::Free || joint.is_some()).then_some(TangentPart {
                body: index,
                joint,
                dimension: 2 * kind.width(),
            })
        })
    }
}

impl<F: Force> World<f64, F> {
    /// Number of tangent-space coordinates of a state.
    #[must_use]
    pub fn tangent_dimension(&self) -> usize {
        self.model.tangent_parts().map(|part| part.dimension).sum()
    }

    /// Indices of the tangent-space coordinates of the body with this index, which are the coordinates of its joint. The first half are
    /// positions and the second half are velocities. The range is empty for a body that is welded, mimicking, fixed or kinematic.
    ///
    /// # Errors
    /// If the world has no body with the index.
    pub fn tangent_columns(&self, body: usize) -> Result<Range<usize>, WorldError> {
        let bodies = self.bodies().len();
        if body >= bodies {
            return Err(WorldError::BodyIndex {
                index: body,
                bodies,
            });
        }
        let parts = self.model.tangent_parts();
        let parts: Vec<_> = parts.filter(|part| part.body <= body).collect();
        let own = parts.last().filter(|part| part.body == body);
        let end: usize = parts.iter().map(|part| part.dimension).sum();
        Ok(end - own.map_or(0, |part| part.dimension)..end)
    }

    /// Change from one state to another in tangent-space coordinates. Every dynamic body has a joint to its parent, and the joint of a free
    /// body allows all motions. The coordinates are the changes of the positions and the velocities of these joints, in the order of their
    /// bodies:
    ///
    /// | joint | change of the position | change of the velocity |
    /// |---|---|---|
    /// | none: free body | rotation vector (rad) and translation of the origin (m), as in [`Pose::moved_by`](crate::spatial::Pose::moved_by) | spin (rad/s) and velocity of the center of mass (m/s) |
    /// | revolute, prismatic | 1 number (rad or m) | 1 number (rad/s or m/s) |
    /// | ball | rotation vector (rad), in the axes of the joint frame | angular velocity (rad/s), in the axes of the joint frame |
    /// | fixed, mimicking | none | none |
    ///
    /// The length of a rotation vector is at most half a turn. The change of a revolute joint includes full turns. Poses and twists of
    /// bodies on joints follow from these coordinates and are not compared.
    ///
    /// # Errors
    /// - If a state does not fit the world.
    /// - If the change is not finite.
    pub fn difference(&self, from: &State, to: &State) -> Result<DVector<f64>, WorldError> {
        from.check_fits(self.bodies())?;
        to.check_fits(self.bodies())?;
        let parts = self.model.tangent_parts();
        let numbers = parts.flat_map(|TangentPart { body, joint, .. }| match joint {
            Some(joint) => joint_change(&from.joints[joint], &to.joints[joint]),
            None => body_change(&from.bodies[body], &to.bodies[body]),
        });
        let numbers: Vec<f64> = numbers.collect();
        check_finite("change between two states", &numbers)?;
        Ok(numbers.into())
    }

    /// State after a change in tangent-space coordinates: the inverse of [`Self::difference`]. Bodies on joints follow the joints. The time,
    /// and the states of fixed and kinematic bodies, stay the same.
    ///
    /// # Errors
    /// - If the state before or after the change does not fit the world.
    /// - If the change does not have [`Self::tangent_dimension`] finite numbers.
    pub fn integrate(&self, state: &State, change: &[f64]) -> Result<State, WorldError> {
        state.check_fits(self.bodies())?;
        check_finite("change of a state", change)?;
        let (found, expected) = (change.len(), self.tangent_dimension());
        if found != expected {
            return Err(WorldError::ChangeSize { found, expected });
        }
        let mut moved = state.clone();
        let mut rest = change;
        for part in self.model.tangent_parts() {
            let (position, others) = rest.split_at(part.dimension / 2);
            let (velocity, others) = others.split_at(part.dimension / 2);
            rest = others;
            match part.joint {
                Some(joint) => {
                    let [turn, spin] = [position, velocity].map(vector_of);
                    moved.joints[joint].displace(&turn, &spin);
                }
                None => displace(&mut moved.bodies[part.body], [position, velocity]),
            }
        }
        self.model.place_joints(&mut moved);
        moved.check_fits(self.bodies())?;
        Ok(moved)
    }
}

/// Changes of the pose and the twist of a free body.
fn body_change(from: &BodyState, to: &BodyState) -> Vec<f64> {
    let turn = turn_between(from.pose.rotation(), to.pose.rotation());
    let shift = to.position() - from.position();
    let twist = to.twist.to_vector() - from.twist.to_vector();
    let pose = turn.iter().chain(&shift);
    pose.chain(&twist).copied().collect()
}

/// Changes of the position and the velocity of a joint. The states fit its kind.
fn joint_change(from: &JointState, to: &JointState) -> Vec<f64> {
    use JointState::{Ball, Scalar};
    match (from, to) {
        (
            Scalar { position, velocity },
            Scalar {
                position: new_position,
                velocity: new_velocity,
            },
        ) => vec![new_position - position, new_velocity - velocity],
        (
            Ball {
                rotation,
                angular_velocity,
            },
            Ball {
                rotation: new_rotation,
                angular_velocity: new_velocity,
            },
        ) => {
            let turn = turn_between(rotation, new_rotation);
            let spin = new_velocity - angular_velocity;
            turn.iter().chain(&spin).copied().collect()
        }
        _ => Vec::new(),
    }
}

/// Adds changes of the pose and of the twist, with 6 numbers each, to the state of a free body.
fn displace(state: &mut BodyState, changes: [&[f64]; 2]) {
    let [motion, twist] =
        changes.map(|numbers| Twist::from_vector(&Vector6::from_column_slice(numbers)));
    state.pose = state.pose.moved_by(&motion);
    state.twist.angular += twist.angular;
    state.twist.linear += twist.linear;
}

/// Vector of 3 numbers, or of 1 number and zeros.
fn vector_of(numbers: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| numbers.get(i).copied().unwrap_or_default())
}
