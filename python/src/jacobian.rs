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

/// Number of components of a body in an outcome: the rotation by rows, the position and the twist.
const NUMBERS: usize = 18;

/// Outcome with the times and the states of all bodies in the recorded states.
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

/// Outcome with the positions of all bodies in the recorded states, except the first state.
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

/// Derivatives of the k recorded states of n bodies with respect to p parameter components.
///
/// Each array has the shape of the same array of the trajectory, with p as an additional last axis.
///
/// Parameters
/// ----------
/// poses : (k, n, 4, 4, p) ndarray of float64
///     Derivatives of the poses.
/// twists : (k, n, 6, p) ndarray of float64
///     Derivatives of the twists.
///
/// Raises
/// ------
/// HydroelasticError
///     If an array has an unexpected shape, or a number is not finite.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct TrajectoryJacobian {
    /// Derivatives of the poses, (k, n, 4, 4, p) float64.
    poses: Py<PyArrayDyn<f64>>,
    /// Derivatives of the twists, (k, n, 6, p) float64.
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
                .map(|representation| representation.to_string())
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

/// Converts the Jacobian of [`AllStates`] to a trajectory and its derivatives.
pub fn both(
    py: Python<'_>,
    outcome: &OutcomeJacobian,
    bodies: usize,
) -> PyResult<(Trajectory, TrajectoryJacobian)> {
    let numbers = outcome.value.as_slice();
    let each = 1 + NUMBERS * bodies;
    let states = numbers.chunks(each).map(|state| {
        let bodies = state[1..].chunks(NUMBERS).map(body_state);
        Ok(dynamics::State {
            joints: Vec::new(),
            time: state[0],
            bodies: bodies.collect::<PyResult<_>>()?,
        })
    });
    let states = states.collect::<PyResult<Vec<_>>>()?;
    let (count, columns) = (states.len(), outcome.jacobian.ncols());
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
                let value = |column| row.map_or(0.0, |row| outcome.jacobian[(row, column)]);
                poses.extend((0..columns).map(value));
            }
            for row in first + 12..first + NUMBERS {
                twists.extend((0..columns).map(|column| outcome.jacobian[(row, column)]));
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

/// Restores the state of a body from its components, bit for bit.
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

/// Comparison of the derivatives of recorded states with central differences at seven step sizes.
///
/// The errors of a right derivative have a plateau of small values between step sizes that are too long and too short.
#[pyclass(frozen, module = "hydroelastic")]
pub struct DifferenceCheck(pub gradient::DifferenceCheck);

#[pymethods]
impl DifferenceCheck {
    /// Step sizes, (7,) float64, in typical changes of a parameter: the value of a material number, a mass or a force parameter that is
    /// not zero, and 1 SI unit otherwise.
    #[getter]
    fn steps<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.0.steps.clone(), &[self.0.steps.len()])
    }

    /// Name of each of the p parameter components: the parameter, followed by the component.
    #[getter]
    fn numbers(&self) -> Vec<String> {
        self.0.numbers.clone()
    }

    /// Relative error at each step size for each parameter component, (7, p) float64. The reference is the largest entry of the column. It
    /// is at least a millionth of the largest entry of the row, and at least a millionth of the largest outcome component. The error is
    /// infinite if the derivative, the outcome or the difference is not finite.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let errors = &self.0.errors;
        let by_rows = errors.transpose().as_slice().to_vec();
        array(py, by_rows, &[errors.nrows(), errors.ncols()])
    }

    /// Smallest relative error of each parameter component over all step sizes, (p,) float64.
    #[getter]
    fn best_by_parameter<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let best = self.0.best_by_parameter();
        let count = best.len();
        array(py, best, &[count])
    }

    /// Largest entry of best_by_parameter.
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

/// Comparison of the derivatives of recorded positions with the slopes of the motion, for p parameter components.
#[pyclass(frozen, module = "hydroelastic")]
pub struct DerivativeCheck(pub gradient::DerivativeCheck);

#[pymethods]
impl DerivativeCheck {
    /// Name of each of the p parameter components: the parameter, followed by the component.
    #[getter]
    fn numbers(&self) -> Vec<String> {
        let derivatives = self.0.derivatives.iter();
        derivatives
            .map(|derivative| derivative.number.clone())
            .collect()
    }

    /// Verdict on each derivative: "right", "kink", "unresolved", "chaotic" or "noisy". See World.derivative_check.
    #[getter]
    fn verdicts(&self) -> Vec<String> {
        let derivatives = self.0.derivatives.iter();
        derivatives
            .map(|derivative| derivative.verdict.to_string())
            .collect()
    }

    /// Relative error of each derivative, (p,) float64: the largest difference between derivative and slope, over the larger of their
    /// largest entries. It is zero if the difference is below the noise of the rollouts. For a noisy derivative it is the noise over the
    /// same reference.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let errors: Vec<f64> = self
            .0
            .derivatives
            .iter()
            .map(|derivative| derivative.error)
            .collect();
        let count = errors.len();
        array(py, errors, &[count])
    }

    /// First mismatch of each derivative: the time (s) of the first recorded state in which the derivative does not agree with the
    /// slope, and the name of the body. None if all positions agree, or if the derivative is right or noisy.
    #[getter]
    fn first_mismatch(&self) -> Vec<Option<(f64, String)>> {
        let derivatives = self.0.derivatives.iter();
        derivatives
            .map(|derivative| derivative.first_mismatch.clone())
            .collect()
    }

    /// True if all derivatives are right.
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

/// Restores a check from a pickle.
#[pyfunction]
pub fn _load_derivative_check(saved: &[u8]) -> PyResult<DerivativeCheck> {
    loaded(saved).map(DerivativeCheck)
}

/// Restores a check from a pickle.
#[pyfunction]
pub fn _load_difference_check(saved: &[u8]) -> PyResult<DifferenceCheck> {
    loaded(saved).map(DifferenceCheck)
}
