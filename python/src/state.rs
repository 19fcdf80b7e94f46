//! States of a world.

use crate::arrays::{Floats, Many, array, real, wrong_shape};
use crate::errors::value_error;
use crate::path::many_twists;
use crate::poses::{entries, poses};
use hydroelastic::dynamics::{self, BodyState};
use pyo3::prelude::*;

/// State of the n bodies of a world at one time. The bodies have the order of World.names.
///
/// Parameters
/// ----------
/// time : float
///     Time (s).
/// poses : (n, 4, 4) array_like
///     Poses of the body frames in the world.
/// twists : (n, 6) array_like
///     Angular velocity (rad/s), then velocity of the center of mass (m/s), in world axes.
///
/// Raises
/// ------
/// HydroelasticError
///     If a pose is not rigid, a number is not finite, or an array has an unexpected shape.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct State(pub dynamics::State);

/// Entries of all poses and components of all twists of states.
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
        Ok(Self(dynamics::State {
            time,
            bodies,
            joints: Vec::new(),
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
        let [poses, _] = numbers_of([&self.0]);
        array(py, poses, &[self.0.bodies.len(), 4, 4])
    }

    /// Angular velocities (rad/s), then velocities of the centers of mass (m/s), in world axes, (n, 6) float64.
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
