//! States of many worlds with the same bodies and joints, as arrays.

use crate::arrays::{Floats, Whole, array, check_finite, numbers_of_shape, whole};
use crate::errors::value_error;
use crate::lists::list_of;
use crate::poses::check_rotation;
use crate::state::{State, state_at};
use crate::state_arrays::{ARRAYS, NAMES, numbers_of, shapes_of, state_of};
use hydroelastic::dynamics;
use pyo3::prelude::*;

/// States of k worlds with the same bodies and joints, as arrays with k rows. Batch.advance simulates them together.
///
/// For example, States(\[world.initial_state\] * 1000) are the states of 1,000 copies of a world.
///
/// Parameters
/// ----------
/// states : list of State
///     States of the worlds. There must be at least one.
///
/// Raises
/// ------
/// HydroelasticError
///     If the list is empty, or the states have different numbers of bodies or joints.
#[pyclass(frozen, module = "hydroelastic", sequence)]
pub struct States(pub Vec<dynamics::State>);

impl States {
    /// Creates states that must have the same numbers of bodies and joints.
    fn of(states: Vec<dynamics::State>) -> PyResult<Self> {
        let Some(first) = states.first() else {
            return Err(value_error("there must be at least one state"));
        };
        let expected = shapes_of(first);
        match states.iter().position(|state| shapes_of(state) != expected) {
            None => Ok(Self(states)),
            Some(index) => Err(value_error(format!(
                "state {index}, counted from 0, has other numbers of bodies or joints than state 0"
            ))),
        }
    }

    /// Returns the shape of the array with this index in `NAMES`.
    fn shape(&self, which: usize) -> Vec<usize> {
        [&[self.0.len()], &*shapes_of(&self.0[0])[which]].concat()
    }

    /// Returns the array with this index in `NAMES`.
    fn array<'py>(&self, py: Python<'py>, which: usize) -> PyResult<Floats<'py>> {
        let values = std::mem::take(&mut numbers_of(&self.0)[which]);
        array(py, values, &self.shape(which))
    }

    /// Returns the times (s).
    fn all_times(&self) -> Vec<f64> {
        self.0.iter().map(|state| state.time).collect()
    }
}

/// Reads the finite numbers of an argument that must have the expected shape.
fn finite_numbers(
    argument: &Bound<'_, PyAny>,
    name: &str,
    expected: &[usize],
) -> PyResult<Vec<f64>> {
    let values = numbers_of_shape(argument, name, expected)?;
    check_finite(&values, name)?;
    Ok(values)
}

#[pymethods]
impl States {
    #[new]
    fn new(#[pyo3(from_py_with = list_of)] states: Vec<Bound<'_, State>>) -> PyResult<Self> {
        Self::of(states.iter().map(|state| state.get().0.clone()).collect())
    }

    /// Times (s), (k,) float64.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.all_times(), &[self.0.len()])
    }

    /// Poses of the n body frames in the world, (k, n, 4, 4) float64.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 0)
    }

    /// Angular velocities (rad/s), then velocities of the centers of mass (m/s), in world axes, (k, n, 6) float64.
    #[getter]
    fn twists<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 1)
    }

    /// Positions (rad or m) of the j revolute and prismatic joints, (k, j) float64.
    #[getter]
    fn joint_positions<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 2)
    }

    /// Velocities (rad/s or m/s) of the j revolute and prismatic joints, (k, j) float64.
    #[getter]
    fn joint_velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 3)
    }

    /// Rotations of the b ball joints from the body frame to the joint frame, (k, b, 3, 3) float64.
    #[getter]
    fn ball_joint_rotations<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 4)
    }

    /// Angular velocities (rad/s) of the b ball joints in the axes of the joint frames, (k, b, 3) float64.
    #[getter]
    fn ball_joint_velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 5)
    }

    /// Returns states with other arrays. Arrays that are not given stay the same.
    ///
    /// If a rollout starts from a state, the joints determine the poses and twists of bodies on joints. The rollout ignores the poses and
    /// twists of these bodies in the state.
    ///
    /// Parameters
    /// ----------
    /// times : (k,) array_like, optional
    ///     Times (s).
    /// poses : (k, n, 4, 4) array_like, optional
    ///     Poses of the body frames in the world.
    /// twists : (k, n, 6) array_like, optional
    ///     Angular velocities (rad/s), then velocities of the centers of mass (m/s), in world axes.
    /// joint_positions, joint_velocities : (k, j) array_like, optional
    ///     Positions (rad or m) and velocities (rad/s or m/s) of the revolute and prismatic joints.
    /// ball_joint_rotations : (k, b, 3, 3) array_like, optional
    ///     Rotations of the ball joints from the body frame to the joint frame.
    /// ball_joint_velocities : (k, b, 3) array_like, optional
    ///     Angular velocities (rad/s) of the ball joints in the axes of the joint frames.
    ///
    /// Returns
    /// -------
    /// States
    ///     States with these arrays.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an array has an unexpected shape, a number is not finite, a pose is not rigid, or a rotation is not orthonormal.
    #[pyo3(signature = (*, times=None, poses=None, twists=None, joint_positions=None, joint_velocities=None, ball_joint_rotations=None,
                        ball_joint_velocities=None))]
    fn replace(
        &self,
        times: Option<&Bound<'_, PyAny>>,
        poses: Option<&Bound<'_, PyAny>>,
        twists: Option<&Bound<'_, PyAny>>,
        joint_positions: Option<&Bound<'_, PyAny>>,
        joint_velocities: Option<&Bound<'_, PyAny>>,
        ball_joint_rotations: Option<&Bound<'_, PyAny>>,
        ball_joint_velocities: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let arguments = [
            poses,
            twists,
            joint_positions,
            joint_velocities,
            ball_joint_rotations,
            ball_joint_velocities,
        ];
        let count = self.0.len();
        let times = times.map_or(Ok(self.all_times()), |times| {
            finite_numbers(times, "times", &[count])
        })?;
        let mut arrays: [Vec<f64>; ARRAYS] = numbers_of(&self.0);
        for (which, argument) in arguments.into_iter().enumerate() {
            if let Some(argument) = argument {
                arrays[which] = finite_numbers(argument, NAMES[which], &self.shape(which))?;
            }
        }
        for rotation in arrays[4].chunks(9) {
            check_rotation(rotation, NAMES[4])?;
        }
        let rows = times.into_iter().zip(&self.0).enumerate();
        let state = |(row, (time, like)): (usize, (f64, &dynamics::State))| {
            let numbers = std::array::from_fn(|which| {
                let size = arrays[which].len() / count;
                &arrays[which][row * size..(row + 1) * size]
            });
            state_of(time, numbers, like)
        };
        Ok(Self(rows.map(state).collect::<PyResult<_>>()?))
    }

    /// Returns these states, with the states of `other` in the rows where the mask is True.
    ///
    /// Parameters
    /// ----------
    /// mask : sequence of bool
    ///     True for the rows that come from `other`, (k,).
    /// other : States
    ///     States of k worlds with the same numbers of bodies and joints.
    ///
    /// Returns
    /// -------
    /// States
    ///     States after the replacement.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the numbers of rows differ, or the states have different numbers of bodies or joints.
    fn replace_where(&self, mask: Vec<bool>, other: &Self) -> PyResult<Self> {
        let counts = [mask.len(), other.0.len()];
        if counts != [self.0.len(); 2] {
            return Err(value_error(format!(
                "the mask has {} rows and the other states have {}, but both must have {}",
                counts[0],
                counts[1],
                self.0.len()
            )));
        }
        let pairs = self.0.iter().zip(&other.0).zip(mask);
        let rows = pairs.map(|((own, other), is_other)| if is_other { other } else { own });
        Self::of(rows.cloned().collect())
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __getitem__(&self, #[pyo3(from_py_with = whole)] index: Whole) -> PyResult<State> {
        state_at(&self.0, index)
    }

    fn __repr__(&self) -> String {
        format!(
            "States({} of {} bodies)",
            self.0.len(),
            self.0[0].bodies.len()
        )
    }

    fn __getnewargs__(&self) -> (Vec<State>,) {
        (self.0.iter().cloned().map(State).collect(),)
    }
}
