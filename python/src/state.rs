//! States of a world.

use crate::arrays::{
    Floats, Many, Whole, array, finite, finite_row, named_real, parts, real, wrong_shape,
};
use crate::errors::value_error;
use crate::path::many_twists;
use crate::poses::{poses, rotation};
use crate::state_arrays::{numbers_of, shapes_of};
use hydroelastic::dynamics::{self, BodyState, JointState};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

/// State of the n bodies and the joints of a world at one time.
///
/// The bodies have the order of World.names. The states of the joints have the order of World.joints, without fixed joints and joints
/// that mimic. Bodies on joints follow their joints if a rollout starts from a state.
///
/// Parameters
/// ----------
/// time : float
///     Time (s).
/// poses : (n, 4, 4) array_like
///     Poses of the body frames in the world.
/// twists : (n, 6) array_like
///     Angular velocity (rad/s), then velocity of the center of mass (m/s), in world axes.
/// joints : sequence of (float or (3, 3) array_like, float or (3,) array_like), optional
///     State of each joint. A revolute or prismatic joint has a position (rad or m) and a velocity (rad/s or m/s). A ball joint has the
///     rotation from the body frame to the joint frame, and an angular velocity (rad/s) in the axes of the joint frame. Default: no
///     joints.
///
/// Raises
/// ------
/// HydroelasticError
///     If a pose is not rigid, a rotation is not orthonormal, a number is not finite, or an array has an unexpected shape.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct State(pub dynamics::State);

/// Position or velocity of a joint: a number, or an array for a ball joint.
#[derive(IntoPyObject)]
pub enum JointNumber {
    Scalar(f64),
    Ball(Py<PyArrayDyn<f64>>),
}

/// Reads the state of a joint from a position and a velocity. The position of a ball joint is a rotation matrix.
fn joint_of(item: &Bound<'_, PyAny>) -> PyResult<JointState> {
    let [position, velocity] = parts(item, "the state of a joint", "a position and a velocity")?;
    if position.len().is_ok() {
        return Ok(JointState::Ball {
            rotation: rotation(&position, "the rotation of a ball joint")?,
            angular_velocity: finite_row(&velocity, "the angular velocity of a ball joint")?.into(),
        });
    }
    let number = |value, name| finite(named_real(value, name)?, name);
    Ok(JointState::Scalar {
        position: number(&position, "the position of a joint")?,
        velocity: number(&velocity, "the velocity of a joint")?,
    })
}

/// Returns the state with an index. A negative index counts from the end.
pub fn state_at(states: &[dynamics::State], index: Whole) -> PyResult<State> {
    let from_start = if index < 0 {
        index + states.len() as Whole
    } else {
        index
    };
    let state = usize::try_from(from_start).ok();
    let state = state.and_then(|from_start| states.get(from_start));
    state.map(|state| State(state.clone())).ok_or_else(|| {
        PyIndexError::new_err(format!(
            "there are {} states, but number {index} was asked for",
            states.len()
        ))
    })
}

impl State {
    /// Array with an index in `NAMES`.
    fn array<'py>(&self, py: Python<'py>, which: usize) -> PyResult<Floats<'py>> {
        let mut numbers = numbers_of([&self.0]);
        let values = std::mem::take(&mut numbers[which]);
        array(py, values, &shapes_of(&self.0)[which])
    }
}

#[pymethods]
impl State {
    #[new]
    #[pyo3(signature = (time, poses, twists, joints=vec![]))]
    fn new(
        #[pyo3(from_py_with = real)] time: f64,
        poses: &Bound<'_, PyAny>,
        twists: &Bound<'_, PyAny>,
        joints: Vec<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        if !time.is_finite() {
            return Err(value_error(format!(
                "the time of a state must be finite, but is {time}"
            )));
        }
        let poses = match self::poses(poses, "poses")? {
            Many::Each(poses) => poses,
            Many::One(_) => return Err(wrong_shape("poses", "(n, 4, 4)", &[4, 4])),
        };
        let twists = many_twists(twists, poses.len())?;
        let bodies = poses.into_iter().zip(twists);
        let bodies = bodies
            .map(|(pose, twist)| BodyState { pose, twist })
            .collect();
        let joints = joints.iter().map(joint_of).collect::<PyResult<_>>()?;
        Ok(Self(dynamics::State {
            time,
            bodies,
            joints,
        }))
    }

    /// Time (s).
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    /// Poses of the body frames in the world, (n, 4, 4) float64.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 0)
    }

    /// Angular velocities (rad/s), then velocities of the centers of mass (m/s), in world axes, (n, 6) float64.
    #[getter]
    fn twists<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 1)
    }

    /// Position and velocity of each joint, in the order of World.joints, without fixed joints and joints that mimic. A revolute or
    /// prismatic joint has two numbers. A ball joint has a rotation, (3, 3) float64, and an angular velocity, (3,) float64.
    #[getter]
    fn joints(&self, py: Python<'_>) -> PyResult<Vec<(JointNumber, JointNumber)>> {
        let ball = |values: &[f64], shape: &[usize]| {
            let array = array(py, values.to_vec(), shape)?;
            PyResult::Ok(JointNumber::Ball(array.unbind()))
        };
        let joint = |joint: &JointState| match joint {
            JointState::Scalar { position, velocity } => Ok(Some((
                JointNumber::Scalar(*position),
                JointNumber::Scalar(*velocity),
            ))),
            JointState::Ball {
                rotation,
                angular_velocity,
            } => Ok(Some((
                ball(rotation.transpose().as_slice(), &[3, 3])?,
                ball(angular_velocity.as_slice(), &[3])?,
            ))),
            _ => Ok(None),
        };
        let joints = self.0.joints.iter().map(joint);
        joints.filter_map(Result::transpose).collect()
    }

    /// Positions (rad or m) of the revolute and prismatic joints, in the order of World.joint_names, (m,) float64.
    #[getter]
    fn joint_positions<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 2)
    }

    /// Velocities (rad/s or m/s) of the revolute and prismatic joints, in the order of World.joint_names, (m,) float64.
    #[getter]
    fn joint_velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 3)
    }

    /// Rotations of the ball joints from the body frame to the joint frame, in the order of World.ball_joint_names, (b, 3, 3) float64.
    #[getter]
    fn ball_joint_rotations<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 4)
    }

    /// Angular velocities (rad/s) of the ball joints in the axes of the joint frames, in the order of World.ball_joint_names, (b, 3)
    /// float64.
    #[getter]
    fn ball_joint_velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 5)
    }

    fn __len__(&self) -> usize {
        self.0.bodies.len()
    }

    fn __repr__(&self) -> String {
        let joints = match self.0.joints.len() {
            0 => String::new(),
            count => format!(", {count} joints"),
        };
        let (time, bodies) = (self.0.time, self.0.bodies.len());
        format!("State(time={time:?} s, {bodies} bodies{joints})")
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(
        f64,
        Floats<'py>,
        Floats<'py>,
        Vec<(JointNumber, JointNumber)>,
    )> {
        let [poses, twists] = [self.poses(py)?, self.twists(py)?];
        Ok((self.0.time, poses, twists, self.joints(py)?))
    }
}
