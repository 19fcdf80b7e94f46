//! Joints of a world, and states with other joint positions and velocities.

use crate::arrays::{finite_row, named_real};
use crate::errors::value_error;
use crate::joint::Joint;
use crate::poses::rotation;
use crate::state::State;
use crate::world::World;
use hydroelastic::dynamics::{self, JointKind, JointState};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// Joint of a body that is not free.
pub fn connecting_joint(body: &dynamics::Body) -> Option<&dynamics::Joint> {
    body.joint()
        .filter(|joint| *joint.kind() != JointKind::Free)
}

impl World {
    /// Joints that have a state: all but fixed joints and joints that mimic.
    fn joints_with_state(&self) -> impl Iterator<Item = &dynamics::Joint> {
        let joints = self.inner.bodies().iter().filter_map(connecting_joint);
        joints.filter(|joint| joint.initial_state().is_some())
    }

    /// Names of the ball joints, or of the joints with one degree of freedom.
    fn joint_names_of(&self, are_balls: bool) -> Vec<&str> {
        let joints = self.joints_with_state();
        joints
            .filter(|joint| (*joint.kind() == JointKind::Ball) == are_balls)
            .map(dynamics::Joint::name)
            .collect()
    }

    /// State of the named joint in a state.
    fn joint_state_mut<'s>(
        &self,
        name: &str,
        state: &'s mut dynamics::State,
    ) -> PyResult<&'s mut JointState> {
        let names: Vec<&str> = self
            .joints_with_state()
            .map(dynamics::Joint::name)
            .collect();
        let index = names.iter().position(|known| *known == name);
        let found = index.and_then(|index| state.joints.get_mut(index));
        found.ok_or_else(|| unknown_joint(name, &names))
    }
}

fn unknown_joint(name: &str, known: &[&str]) -> PyErr {
    value_error(format!(
        "no joint with a position is named {name:?}: the names are {known:?}"
    ))
}

#[pymethods]
impl World {
    /// Joints of the bodies, in the order of the bodies. Free bodies have no joint.
    #[getter]
    fn joints(&self) -> Vec<Joint> {
        let joints = self.inner.bodies().iter().filter_map(connecting_joint);
        joints.cloned().map(Joint).collect()
    }

    /// Names of the revolute and prismatic joints, in the order of State.joint_positions. Joints that mimic are not among them.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.joint_names_of(false)
    }

    /// Names of the ball joints, in the order of State.ball_joint_rotations.
    #[getter]
    fn ball_joint_names(&self) -> Vec<&str> {
        self.joint_names_of(true)
    }

    /// Returns the index of a joint in joint_names, or in ball_joint_names for a ball joint.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of a joint that is not fixed.
    ///
    /// Returns
    /// -------
    /// int
    ///     Index, from 0.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such joint.
    fn joint_index(&self, name: &str) -> PyResult<usize> {
        let names = [false, true].map(|are_balls| self.joint_names_of(are_balls));
        let index = |names: &Vec<&str>| names.iter().position(|known| *known == name);
        let found = names.iter().find_map(index);
        found.ok_or_else(|| unknown_joint(name, &names.concat()))
    }

    /// Returns a state with other positions and velocities of joints. Bodies on joints follow.
    ///
    /// Parameters
    /// ----------
    /// positions : dict of str to float or (3, 3) array_like, optional
    ///     Position (rad or m) by the name of the joint, or rotation of a ball joint from the body frame to the joint frame. Other joints
    ///     keep their positions.
    /// velocities : dict of str to float or (3,) array_like, optional
    ///     Velocity (rad/s or m/s) by the name of the joint, or angular velocity (rad/s) of a ball joint in the axes of the joint frame.
    ///     Other joints keep their velocities.
    /// state : State, optional
    ///     State to change. Default: the initial state of the world.
    ///
    /// Returns
    /// -------
    /// State
    ///     Changed state.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world, the world has no such joint, or a number is not finite.
    #[pyo3(signature = (positions=None, velocities=None, *, state=None))]
    fn state_with_joints(
        &self,
        positions: Option<BTreeMap<String, Bound<'_, PyAny>>>,
        velocities: Option<BTreeMap<String, Bound<'_, PyAny>>>,
        state: Option<&State>,
    ) -> PyResult<State> {
        let mut changed = match state {
            Some(state) => state.0.clone(),
            None => self.inner.initial_state(),
        };
        for (name, value) in positions.into_iter().flatten() {
            let label = format!("the position of joint {name:?}");
            match self.joint_state_mut(&name, &mut changed)? {
                JointState::Scalar { position, .. } => *position = named_real(&value, &label)?,
                JointState::Ball { rotation, .. } => *rotation = self::rotation(&value, &label)?,
                _ => {}
            }
        }
        for (name, value) in velocities.into_iter().flatten() {
            let label = format!("the velocity of joint {name:?}");
            match self.joint_state_mut(&name, &mut changed)? {
                JointState::Scalar { velocity, .. } => *velocity = named_real(&value, &label)?,
                JointState::Ball {
                    angular_velocity, ..
                } => *angular_velocity = finite_row(&value, &label)?.into(),
                _ => {}
            }
        }
        let placed = self.inner.placed(&changed);
        placed.map(State).map_err(value_error)
    }
}
