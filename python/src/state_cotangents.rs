//! Cotangents of recorded states: the derivatives of a loss with respect to their poses and twists.

use crate::arrays::{Numbers, numbers, wrong_shape};
use crate::poses::twist_of;
use hydroelastic::dynamics::{BodyState, Plan, StateGradient, Trajectory};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;

/// Number of entries of a pose.
const POSE: usize = 16;
/// Number of components of a twist.
const TWIST: usize = 6;

/// Derivatives of a loss with respect to the poses and twists of the recorded states, for one trajectory or for several.
pub struct StateCotangents {
    poses: Vec<f64>,
    twists: Vec<f64>,
    states: usize,
    bodies: usize,
}

impl StateCotangents {
    /// Reads arrays that have the shapes of the poses and twists of a trajectory. With several trajectories, their number is the first
    /// axis.
    pub fn of(
        by_poses: &Bound<'_, PyAny>,
        by_twists: &Bound<'_, PyAny>,
        (plan, bodies): (&Plan, usize),
        trajectories: Option<usize>,
    ) -> PyResult<Self> {
        let states = 1 + plan.steps().div_ceil(plan.record_every());
        let front: Vec<usize> = trajectories.into_iter().chain([states, bodies]).collect();
        let entries = |argument, name, each: &[usize]| {
            let expected = [&*front, each].concat();
            let Numbers { values, shape } = numbers(argument, name)?;
            if shape == expected {
                return Ok(values);
            }
            let sizes: Vec<String> = expected.iter().map(usize::to_string).collect();
            Err(wrong_shape(
                name,
                &format!("({})", sizes.join(", ")),
                &shape,
            ))
        };
        Ok(Self {
            poses: entries(by_poses, "by_poses", &[4, 4])?,
            twists: entries(by_twists, "by_twists", &[TWIST])?,
            states,
            bodies,
        })
    }

    /// Gradients with respect to the states of the trajectory with an index.
    pub fn covectors(&self, index: usize, trajectory: &Trajectory) -> Vec<Vec<StateGradient>> {
        let states = trajectory.states().iter().enumerate();
        let of_state = |(record, state): (usize, &hydroelastic::dynamics::State)| {
            let bodies = state.bodies.iter().enumerate();
            let first = (index * self.states + record) * self.bodies;
            bodies
                .map(|(body, state)| self.covector(first + body, state))
                .collect()
        };
        states.map(of_state).collect()
    }

    fn covector(&self, index: usize, state: &BodyState) -> StateGradient {
        let pose = &self.poses[POSE * index..POSE * (index + 1)];
        let twist = &self.twists[TWIST * index..TWIST * (index + 1)];
        StateGradient::from_entries(
            state.pose.rotation(),
            &Matrix3::from_fn(|row, column| pose[4 * row + column]),
            Vector3::new(pose[3], pose[7], pose[11]),
            &twist_of(&std::array::from_fn(|number| twist[number])),
        )
    }
}
