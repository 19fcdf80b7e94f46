//! States of a world.

use crate::arrays::{Floats, Many, array, real, wrong_shape};
use crate::errors::value_error;
use crate::path::many_twists;
use crate::poses::{entries, poses};
use hydroelastic::dynamics::{self, BodyState};
use pyo3::prelude::*;

/// All bodies of a world at one time, in the order of the world's.
///
/// Parameters
/// ----------
/// time : (s).
/// poses : (n, 4, 4) float64, poses of the body frames in the world.
/// twists : (n, 6) float64: spin (rad/s), and velocity of the center of mass (m/s), world axes.
///
/// Raises
/// ------
/// HydroelasticError if a pose is not rigid, or a number is not finite.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct State(pub dynamics::State);

/// The entries of all poses of states, and the numbers of all twists.
pub fn numbers_of<'s>(states: impl IntoIterator<Item = &'s dynamics::State>) -> [Vec<f64>; 2] {
    let (mut poses, mut twists) = (Vec::new(), Vec::new());
    for body in states.into_iter().flat_map(|state| &state.bodies) {
        poses.extend(entries(&body.pose));
        twists.extend(body.twist.to_vector().iter());
    }
    [poses, twists]
}

#[pymethods]
impl State {
    #[new]
    fn new(
        #[pyo3(from_py_with = real)] time: f64,
        poses: &Bound<'_, PyAny>,
        twists: &Bound<'_, PyAny>,
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
        Ok(Self(dynamics::State { time, bodies }))
    }

    /// Time (s).
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    /// (n, 4, 4) float64: poses of the body frames in the world.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let [poses, _] = numbers_of([&self.0]);
        array(py, poses, &[self.0.bodies.len(), 4, 4])
    }

    /// (n, 6) float64: spin (rad/s), and velocity of the center of mass (m/s), world axes.
    #[getter]
    fn twists<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let [_, twists] = numbers_of([&self.0]);
        array(py, twists, &[self.0.bodies.len(), 6])
    }

    fn __len__(&self) -> usize {
        self.0.bodies.len()
    }

    fn __repr__(&self) -> String {
        format!(
            "State(time={:?} s, {} bodies)",
            self.0.time,
            self.0.bodies.len()
        )
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(f64, Floats<'py>, Floats<'py>)> {
        Ok((self.0.time, self.poses(py)?, self.twists(py)?))
    }
}
