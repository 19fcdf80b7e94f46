//! Derivatives of a number by recorded states.

use crate::arrays::{Numbers, numbers, wrong_shape};
use crate::poses::twist_of;
use hydroelastic::dynamics::{BodyState, Plan, StateGradient, Trajectory};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;

/// Entries of a pose, and numbers of a twist.
const POSE: usize = 16;
const TWIST: usize = 6;

/// Derivatives by the poses and twists of the states that a plan records: of one trajectory, or of several.
pub struct ByStates {
    poses: Vec<f64>,
    twists: Vec<f64>,
    states: usize,
    bodies: usize,
}

impl ByStates {
    /// From arrays of the shapes of a trajectory's, with the number of trajectories in front if there are several.
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

    /// Those by the states of a trajectory, which is in such a place among several.
    pub fn covectors(&self, place: usize, trajectory: &Trajectory) -> Vec<Vec<StateGradient>> {
        let states = trajectory.states().iter().enumerate();
        let of_state = |(record, state): (usize, &hydroelastic::dynamics::State)| {
            let bodies = state.bodies.iter().enumerate();
            let first = (place * self.states + record) * self.bodies;
            bodies
                .map(|(body, state)| self.covector(first + body, state))
                .collect()
        };
        states.map(of_state).collect()
    }

    fn covector(&self, place: usize, state: &BodyState) -> StateGradient {
        let pose = &self.poses[POSE * place..POSE * (place + 1)];
        let twist = &self.twists[TWIST * place..TWIST * (place + 1)];
        StateGradient::from_entries(
            state.pose.rotation(),
            &Matrix3::from_fn(|row, column| pose[4 * row + column]),
            Vector3::new(pose[3], pose[7], pose[11]),
            &twist_of(&std::array::from_fn(|number| twist[number])),
        )
    }
}
