//! Recorded states.

use crate::arrays::{Floats, Whole, array, whole};
use crate::errors::value_error;
use crate::state::{State, numbers_of};
use hydroelastic::dynamics;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyIterator, PyList};

/// Recorded states of n bodies in the order of time; the first is the initial one. A sequence of State, and three arrays, which
/// are not writable.
///
/// Parameters
/// ----------
/// states : a list of State, at least one, in the order of time.
#[pyclass(frozen, module = "hydroelastic", sequence)]
pub struct Trajectory {
    pub inner: dynamics::Trajectory,
    arrays: PyOnceLock<[Py<PyArrayDyn<f64>>; 3]>,
}

impl From<dynamics::Trajectory> for Trajectory {
    fn from(inner: dynamics::Trajectory) -> Self {
        let arrays = PyOnceLock::new();
        Self { inner, arrays }
    }
}

impl Trajectory {
    /// Times, poses and twists.
    fn array<'py>(&self, py: Python<'py>, which: usize) -> PyResult<Floats<'py>> {
        let arrays = self.arrays.get_or_try_init(py, || {
            let states = self.inner.states();
            let (count, bodies) = (states.len(), states[0].bodies.len());
            let times = states.iter().map(|state| state.time).collect();
            let [poses, twists] = numbers_of(states);
            let [times, poses, twists] = [
                array(py, times, &[count])?,
                array(py, poses, &[count, bodies, 4, 4])?,
                array(py, twists, &[count, bodies, 6])?,
            ];
            for array in [&times, &poses, &twists] {
                array
                    .try_readwrite()
                    .map_err(value_error)?
                    .make_nonwriteable();
            }
            PyResult::Ok([times, poses, twists].map(Bound::unbind))
        })?;
        Ok(arrays[which].bind(py).clone())
    }
}

#[pymethods]
impl Trajectory {
    #[new]
    fn new(states: Vec<Bound<'_, State>>) -> PyResult<Self> {
        let states = states.iter().map(|state| state.get().0.clone());
        let trajectory = dynamics::Trajectory::new(states.collect());
        trajectory.map(Self::from).map_err(value_error)
    }

    /// (k,) float64: times (s).
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 0)
    }

    /// (k, n, 4, 4) float64: poses of the body frames in the world.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 1)
    }

    /// (k, n, 6) float64: spins (rad/s), and velocities of the centers of mass (m/s), world axes.
    #[getter]
    fn twists<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array(py, 2)
    }

    fn __len__(&self) -> usize {
        self.inner.states().len()
    }

    /// The state of a place, counted from the end if it is negative.
    fn __getitem__(&self, #[pyo3(from_py_with = whole)] place: Whole) -> PyResult<State> {
        let states = self.inner.states();
        let from_start = if place < 0 {
            place + states.len() as Whole
        } else {
            place
        };
        let place_found = usize::try_from(from_start).ok();
        let found = place_found.and_then(|place| states.get(place));
        found.map(|state| State(state.clone())).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "there are {} states, but number {place} was asked for",
                states.len()
            ))
        })
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
