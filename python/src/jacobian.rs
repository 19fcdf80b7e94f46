//! Derivatives of recorded states.

use crate::arrays::{Floats, array, check_kept};
use crate::errors::value_error;
use crate::pickle::{Reduced, loaded, reduced};
use crate::trajectory::Trajectory;
use hydroelastic::dynamics::{self, BodyState};
use hydroelastic::gradient::{self, Outcome, OutcomeJacobian};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Twist};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// Numbers of a body in an outcome: the rotation by rows and the position, then the twist.
const NUMBERS: usize = 18;

/// The times and all bodies of the recorded states.
pub struct AllStates;

impl Outcome for AllStates {
    fn of<T: Scalar>(&self, trajectory: &dynamics::Trajectory<T>) -> Vec<T> {
        let mut numbers = Vec::new();
        for state in trajectory.states() {
            numbers.push(lift(state.time));
            for body in &state.bodies {
                numbers.extend(body.pose.rotation().transpose().iter().copied());
                numbers.extend(body.pose.translation().iter().copied());
                numbers.extend(body.twist.to_vector().iter().copied());
            }
        }
        numbers
    }
}

/// The positions of all bodies in the recorded states but the first.
pub struct RecordedPositions;

impl Outcome for RecordedPositions {
    fn of<T: Scalar>(&self, trajectory: &dynamics::Trajectory<T>) -> Vec<T> {
        let states = trajectory.states()[1..].iter();
        let bodies = states.flat_map(|state| &state.bodies);
        bodies
            .flat_map(|body| body.position().iter().copied())
            .collect()
    }
}

/// The derivatives of a trajectory by p numbers of parameters: each of its arrays with p at the end, so that derivatives have
/// the indices of what they are of.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct TrajectoryJacobian {
    /// (k, n, 4, 4, p) float64: derivatives of the poses.
    poses: Py<PyArrayDyn<f64>>,
    /// (k, n, 6, p) float64: derivatives of the twists.
    twists: Py<PyArrayDyn<f64>>,
}

#[pymethods]
impl TrajectoryJacobian {
    #[new]
    fn new(
        py: Python<'_>,
        poses: Py<PyArrayDyn<f64>>,
        twists: Py<PyArrayDyn<f64>>,
    ) -> PyResult<Self> {
        check_kept(
            py,
            &[
                (&poses, "poses", &["k", "n", "4", "4", "p"]),
                (&twists, "twists", &["k", "n", "6", "p"]),
            ],
        )?;
        Ok(Self { poses, twists })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = |array: &Py<PyArrayDyn<f64>>| {
            array
                .bind(py)
                .getattr("shape")?
                .repr()
                .map(|it| it.to_string())
        };
        Ok(format!(
            "TrajectoryJacobian(poses {}, twists {})",
            shape(&self.poses)?,
            shape(&self.twists)?
        ))
    }

    fn __getnewargs__(&self, py: Python<'_>) -> (Py<PyArrayDyn<f64>>, Py<PyArrayDyn<f64>>) {
        (self.poses.clone_ref(py), self.twists.clone_ref(py))
    }
}

/// The trajectory and its derivatives from an outcome of [`AllStates`] of so many bodies.
pub fn both(
    py: Python<'_>,
    found: &OutcomeJacobian,
    bodies: usize,
) -> PyResult<(Trajectory, TrajectoryJacobian)> {
    let numbers = found.value.as_slice();
    let each = 1 + NUMBERS * bodies;
    let states = numbers.chunks(each).map(|state| {
        let bodies = state[1..].chunks(NUMBERS).map(body_state);
        Ok(dynamics::State {
            time: state[0],
            bodies: bodies.collect::<PyResult<_>>()?,
        })
    });
    let states = states.collect::<PyResult<Vec<_>>>()?;
    let (count, columns) = (states.len(), found.jacobian.ncols());
    let (mut poses, mut twists) = (Vec::new(), Vec::new());
    for state in 0..count {
        for body in 0..bodies {
            let first = state * each + 1 + body * NUMBERS;
            for entry in 0..16 {
                let row = match (entry / 4, entry % 4) {
                    (3, _) => None,
                    (row, 3) => Some(first + 9 + row),
                    (row, column) => Some(first + 3 * row + column),
                };
                let value = |column| row.map_or(0.0, |row| found.jacobian[(row, column)]);
                poses.extend((0..columns).map(value));
            }
            for row in first + 12..first + NUMBERS {
                twists.extend((0..columns).map(|column| found.jacobian[(row, column)]));
            }
        }
    }
    let jacobian = TrajectoryJacobian {
        poses: array(py, poses, &[count, bodies, 4, 4, columns])?.unbind(),
        twists: array(py, twists, &[count, bodies, 6, columns])?.unbind(),
    };
    let trajectory = dynamics::Trajectory::new(states).map_err(value_error)?;
    Ok((trajectory.into(), jacobian))
}

/// The state of a body from its numbers, bit for bit.
fn body_state(numbers: &[f64]) -> PyResult<BodyState> {
    let rotation = Matrix3::from_row_slice(&numbers[..9]);
    let vector = |first: usize| Vector3::from_column_slice(&numbers[first..first + 3]);
    let pose = Pose::restored(rotation, vector(9)).map_err(value_error)?;
    let (angular, linear) = (vector(12), vector(15));
    Ok(BodyState {
        pose,
        twist: Twist { angular, linear },
    })
}

/// How well the derivatives of recorded states agree with central differences, at seven steps. A right derivative shows as a
/// plateau of small errors between steps that are too long and too short.
#[pyclass(frozen, module = "hydroelastic")]
pub struct DifferenceCheck(pub gradient::DifferenceCheck);

#[pymethods]
impl DifferenceCheck {
    /// (7,) float64: steps, in typical changes of a parameter: its value for materials and masses, else 1 SI unit.
    #[getter]
    fn steps<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.0.steps.clone(), &[self.0.steps.len()])
    }

    /// What each column is by: a parameter, and which of its numbers.
    #[getter]
    fn numbers(&self) -> Vec<String> {
        self.0.numbers.clone()
    }

    /// (7, p) float64: the error at each step and number, relative to the largest entry of the column, or to a millionth of the
    /// largest entry of the row and of the largest number of the outcome if that is larger.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let errors = &self.0.errors;
        let by_rows = errors.transpose().as_slice().to_vec();
        array(py, by_rows, &[errors.nrows(), errors.ncols()])
    }

    /// (p,) float64: for each number the error at the step that agrees best.
    #[getter]
    fn best_by_parameter<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let best = self.0.best_by_parameter();
        let count = best.len();
        array(py, best, &[count])
    }

    /// The largest of these errors.
    #[getter]
    fn best(&self) -> f64 {
        self.0.best()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_difference_check", &self.0)
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!(
            "DifferenceCheck({} numbers, best {:.1e})",
            self.0.numbers.len(),
            self.0.best()
        )
    }
}

/// The derivatives of recorded positions by p numbers of parameters, compared with the slopes of the motion.
#[pyclass(frozen, module = "hydroelastic")]
pub struct DerivativeCheck(pub gradient::DerivativeCheck);

#[pymethods]
impl DerivativeCheck {
    /// What each derivative is by: a parameter, and which of its numbers.
    #[getter]
    fn numbers(&self) -> Vec<String> {
        let derivatives = self.0.derivatives.iter();
        derivatives.map(|found| found.number.clone()).collect()
    }

    /// For each derivative "right", "kink", "unresolved" or "chaotic".
    #[getter]
    fn verdicts(&self) -> Vec<String> {
        let derivatives = self.0.derivatives.iter();
        derivatives.map(|found| found.verdict.to_string()).collect()
    }

    /// (p,) float64: the largest difference between derivative and slope, relative to the larger of their largest entries; of noisy ones
    /// the noise, relative to the same.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let errors: Vec<f64> = self.0.derivatives.iter().map(|found| found.error).collect();
        let count = errors.len();
        array(py, errors, &[count])
    }

    /// For each derivative the time (s) of the first recorded state where it is not the slope, and the name of the body; None if it
    /// is right.
    #[getter]
    fn first_mismatch(&self) -> Vec<Option<(f64, String)>> {
        let derivatives = self.0.derivatives.iter();
        derivatives
            .map(|found| found.first_mismatch.clone())
            .collect()
    }

    /// Whether all derivatives are right.
    #[getter]
    fn is_right(&self) -> bool {
        self.0.is_right()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_derivative_check", &self.0)
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("DerivativeCheck({:?})", self.verdicts())
    }
}

/// A check from what pickle has kept.
#[pyfunction]
pub fn _load_derivative_check(saved: &[u8]) -> PyResult<DerivativeCheck> {
    loaded(saved).map(DerivativeCheck)
}

/// A check from what pickle has kept.
#[pyfunction]
pub fn _load_difference_check(saved: &[u8]) -> PyResult<DifferenceCheck> {
    loaded(saved).map(DifferenceCheck)
}
