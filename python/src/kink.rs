//! Nonsmooth points of a rollout.

use crate::arrays::{Whole, count, whole};
use hydroelastic::dynamics;
use pyo3::prelude::*;

/// Nonsmooth points of one kind in a rollout, for one pair of bodies or for one body. See World.kinks.
///
/// Parameters
/// ----------
/// kind : str
///     "flush faces", "clamped pressure", "equal fields" or "unresolved step".
/// bodies : list of str
///     Names of the bodies.
/// steps : int
///     Number of steps with such a point.
/// first_step, last_step : int
///     First and last of these steps. The first step of a rollout has the number 1.
#[pyclass(frozen, eq, get_all, module = "hydroelastic")]
#[derive(PartialEq)]
pub struct Kink {
    /// Kind of nonsmooth point: "flush faces", "clamped pressure", "equal fields" or "unresolved step".
    kind: String,
    /// Names of the bodies.
    bodies: Vec<String>,
    /// Number of steps with such a point.
    steps: usize,
    /// First of these steps, counted from 1.
    first_step: usize,
    /// Last of these steps, counted from 1.
    last_step: usize,
}

impl Kink {
    /// Converts a summary of the library. `names` are the names of all bodies of the world.
    pub fn of(summary: &dynamics::KinkSummary, names: &[&str]) -> Self {
        let bodies = summary.bodies.iter();
        let [first_step, last_step] = summary.steps;
        Self {
            kind: summary.kink.to_string(),
            bodies: bodies.map(|&body| names[body].to_owned()).collect(),
            steps: summary.count,
            first_step,
            last_step,
        }
    }
}

#[pymethods]
impl Kink {
    #[new]
    fn new(
        kind: String,
        bodies: Vec<String>,
        #[pyo3(from_py_with = whole)] steps: Whole,
        #[pyo3(from_py_with = whole)] first_step: Whole,
        #[pyo3(from_py_with = whole)] last_step: Whole,
    ) -> PyResult<Self> {
        Ok(Self {
            kind,
            bodies,
            steps: count(steps, "steps")?,
            first_step: count(first_step, "first_step")?,
            last_step: count(last_step, "last_step")?,
        })
    }

    fn __repr__(&self) -> String {
        format!(
            "Kink({:?}, {:?}, steps={}, first_step={}, last_step={})",
            self.kind, self.bodies, self.steps, self.first_step, self.last_step
        )
    }

    fn __getnewargs__(&self) -> (&str, Vec<String>, usize, usize, usize) {
        let bodies = self.bodies.clone();
        (
            &self.kind,
            bodies,
            self.steps,
            self.first_step,
            self.last_step,
        )
    }
}
