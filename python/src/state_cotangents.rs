//! Cotangents of recorded states: the derivatives of a loss with respect to the arrays of the states.

use crate::arrays::numbers_of_shape;
use crate::poses::{ENTRIES, twist_of};
use crate::state_arrays::{ARRAYS, NAMES, shapes_of, sizes_of};
use hydroelastic::dynamics::{
    self, BodyState, BodyStateGradient, JointState, JointStateGradient, Plan, StateGradient,
    Trajectory,
};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;

/// Derivatives of a loss with respect to the recorded states, for one trajectory or for several.
pub struct StateCotangents {
    arrays: [Vec<f64>; ARRAYS],
    /// Numbers of one state in each array.
    sizes: [usize; ARRAYS],
    /// Number of recorded states of a trajectory.
    states: usize,
}

impl StateCotangents {
    /// Reads arrays that have the shapes of the arrays of a trajectory, in the order of `NAMES`. An array that is None is zero. With
    /// several trajectories, their number is the first axis. `like` is a state of a trajectory.
    pub fn of(
        arrays: [Option<&Bound<'_, PyAny>>; ARRAYS],
        plan: &Plan,
        like: &dynamics::State,
        trajectories: Option<usize>,
    ) -> PyResult<Self> {
        let states = 1 + plan.steps().div_ceil(plan.record_every());
        let front: Vec<usize> = trajectories.into_iter().chain([states]).collect();
        let shapes = shapes_of(like);
        let mut all: [Vec<f64>; ARRAYS] = Default::default();
        for (which, argument) in arrays.into_iter().enumerate() {
            let expected = [&*front, &shapes[which]].concat();
            let name = format!("by_{}", NAMES[which]);
            let values = match argument {
                Some(argument) => numbers_of_shape(argument, &name, &expected)?,
                None => vec![0.0; expected.iter().product()],
            };
            all[which] = values;
        }
        Ok(Self {
            arrays: all,
            sizes: sizes_of(like),
            states,
        })
    }

    /// Gradients with respect to the states of the trajectory with an index.
    pub fn covectors(&self, index: usize, trajectory: &Trajectory) -> Vec<StateGradient> {
        let states = trajectory.states().iter().enumerate();
        let of_state = |(record, state): (usize, &dynamics::State)| {
            let state_index = index * self.states + record;
            gradient(
                state,
                std::array::from_fn(|which| {
                    let size = self.sizes[which];
                    &self.arrays[which][state_index * size..(state_index + 1) * size]
                }),
            )
        };
        states.map(of_state).collect()
    }
}

/// Gradient with respect to a state, from the derivatives with respect to its arrays.
fn gradient(state: &dynamics::State, by_arrays: [&[f64]; ARRAYS]) -> StateGradient {
    let [
        poses,
        twists,
        positions,
        velocities,
        rotations,
        angular_velocities,
    ] = by_arrays;
    let by_bodies = poses.chunks(ENTRIES).zip(twists.chunks(6));
    let bodies = state.bodies.iter().zip(by_bodies);
    let mut by_scalars = positions.iter().zip(velocities);
    let mut by_balls = rotations.chunks(9).zip(angular_velocities.chunks(3));
    let joint = |joint: &JointState| {
        if let JointState::Ball { rotation, .. } = joint {
            let (by_rotation, by_velocity) = by_balls.next()?;
            return Some(JointStateGradient::from_entries(
                rotation,
                &Matrix3::from_row_slice(by_rotation),
                Vector3::from_column_slice(by_velocity),
            ));
        }
        let (&by_position, &by_velocity) = by_scalars.next()?;
        Some(JointStateGradient::scalar(by_position, by_velocity))
    };
    StateGradient {
        bodies: bodies
            .map(|(body, (by_pose, by_twist))| body_gradient(body, by_pose, by_twist))
            .collect(),
        joints: state.joints.iter().filter_map(joint).collect(),
    }
}

fn body_gradient(state: &BodyState, by_pose: &[f64], by_twist: &[f64]) -> BodyStateGradient {
    BodyStateGradient::from_entries(
        state.pose.rotation(),
        &Matrix3::from_fn(|row, column| by_pose[4 * row + column]),
        Vector3::new(by_pose[3], by_pose[7], by_pose[11]),
        &twist_of(&std::array::from_fn(|number| by_twist[number])),
    )
}
