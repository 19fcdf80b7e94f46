//! Trajectories: sequences of recorded states.

use crate::arrays::{Floats, Whole, array, whole};
use crate::errors::value_error;
use crate::lists::list_of;
use crate::state::{State, state_at};
use crate::state_arrays::{ARRAYS, numbers_of, shapes_of};
use hydroelastic::dynamics;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyIterator, PyList};

/// Sequence of k recorded states of n bodies, ordered by time. The first state is the initial state.
///
/// The trajectory is a sequence of State and also has arrays, which are read-only. For example,
/// trajectory.joint_positions[:, world.joint_index("elbow")] has the angles of a joint.
///
/// Parameters
/// ----------
/// states : list of State
///     States, ordered by time. There must be at least one.
///
/// Raises
/// ------
/// HydroelasticError
///     If the list is empty, or the states do not fit each other.
#[pyclass(frozen, module = "hydroelastic", sequence)]
pub struct Trajectory {
    pub inner: dynamics::Trajectory,
    /// Times, then the arrays of states.
    arrays: PyOnceLock<Vec<Py<PyArrayDyn<f64>>>>,
}

impl From<dynamics::Trajectory> for Trajectory {
    fn from(inner: dynamics::Trajectory) -> Self {
        let arrays = PyOnceLock::new();
        Self { inner, arrays }
    }
}

impl Trajectory {
    /// Array with an index: 0 for the times, then the arrays of states.
    fn array<'py>(&self, py: Python<'py>, which: usize) -> PyResult<Floats<'py>> {
        let arrays = self.arrays.get_or_try_init(py, || {
            let states = self.inner.states();
            let count = states.len();
            let times = states.iter().map(|state| state.time).collect();
            let mut arrays = vec![array(py, times, &[count])?];
            let shapes: [_; ARRAYS] = shapes_of(&states[0]);
            for (numbers, shape) in numbers_of(states).into_iter().zip(shapes) {
                arrays.push(array(py, numbers, &[&[count], &*shape].concat())?);
            }
            for array in &arrays {
                array
                    .try_readwrite()
                    .map_err(value_error)?
                    .make_nonwriteable();
            }
            PyResult::Ok(arrays.into_iter().map(Bound::unbind).collect())
        })?;
        Ok(arrays[which].bind(py).clone())
    }
}

#[pymethods]
impl Trajectory {
    #[new]
    fn new(#[pyo3(from_py_with = list_of)] states: Vec<Bound<'_, State>>) -> PyResult<Self> {
        let states = states.iter().map(|state| state.get().0.clone());
        let trajectory = dynamics::Trajectory::new(states.collect());
        trajectory.map(Self::from).map_err(value_error)
    }

    /// Times (s), (k,) float64.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 0)
    }

    /// Poses of the body frames in the world, (k, n, 4, 4) float64.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 1)
    }

    /// Angular velocities (rad/s), then velocities of the centers of mass (m/s), in world axes, (k, n, 6) float64.
    #[getter]
    fn twists<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 2)
    }

    /// Positions (rad or m) of the revolute and prismatic joints, in the order of World.joint_names, (k, m) float64.
    #[getter]
    fn joint_positions<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 3)
    }

    /// Velocities (rad/s or m/s) of the revolute and prismatic joints, in the order of World.joint_names, (k, m) float64.
    #[getter]
    fn joint_velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 4)
    }

    /// Rotations of the ball joints from the body frame to the joint frame, in the order of World.ball_joint_names, (k, b, 3, 3) float64.
    #[getter]
    fn ball_joint_rotations<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 5)
    }

    /// Angular velocities (rad/s) of the ball joints in the axes of the joint frames, in the order of World.ball_joint_names, (k, b, 3)
    /// float64.
    #[getter]
    fn ball_joint_velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 6)
    }

    fn __len__(&self) -> usize {
        self.inner.states().len()
    }

    /// Returns the state with an index. A negative index counts from the end.
    fn __getitem__(&self, #[pyo3(from_py_with = whole)] index: Whole) -> PyResult<State> {
        state_at(self.inner.states(), index)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let states = self.inner.states().iter().cloned().map(State);
        PyList::new(py, states.collect::<Vec<_>>())?.try_iter()
    }

    fn __repr__(&self) -> String {
        let states = self.inner.states();
        let [first, last] = [&states[0], self.inner.last()].map(|state| state.time);
        format!(
            "Trajectory({} states of {} bodies, {first:?} s to {last:?} s)",
            states.len(),
            states[0].bodies.len()
        )
    }

    fn __getnewargs__(&self) -> (Vec<State>,) {
        (self.inner.states().iter().cloned().map(State).collect(),)
    }
}
