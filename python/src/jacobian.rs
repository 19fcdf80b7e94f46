//! Derivatives of recorded states.

use crate::arrays::{Floats, array, check_kept};
use crate::errors::value_error;
use crate::pickle::{Reduced, loaded, reduced};
use crate::state_arrays::{ARRAYS, NAMES, numbers_of, shapes_of, sizes_of, state_of};
use crate::trajectory::Trajectory;
use hydroelastic::dynamics;
use hydroelastic::gradient::{self, Outcome, OutcomeJacobian};
use hydroelastic::scalar::{Scalar, lift};
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Outcome with the time and the arrays of each recorded state.
pub struct AllStates;

impl Outcome for AllStates {
    fn of<T: Scalar>(&self, trajectory: &dynamics::Trajectory<T>) -> Vec<T> {
        let mut numbers = Vec::new();
        for state in trajectory.states() {
            numbers.push(lift(state.time));
            numbers.extend(numbers_of([state]).concat());
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

/// Derivatives of the k recorded states of n bodies, m revolute and prismatic joints and b ball joints with respect to p parameter
/// components.
///
/// Each array has the shape of the same array of the trajectory, with p as an additional last axis.
///
/// Parameters
/// ----------
/// poses : (k, n, 4, 4, p) ndarray of float64
///     Derivatives of the poses.
/// twists : (k, n, 6, p) ndarray of float64
///     Derivatives of the twists.
/// joint_positions, joint_velocities : (k, m, p) ndarray of float64
///     Derivatives of the positions and velocities of the revolute and prismatic joints.
/// ball_joint_rotations : (k, b, 3, 3, p) ndarray of float64
///     Derivatives of the rotations of the ball joints.
/// ball_joint_velocities : (k, b, 3, p) ndarray of float64
///     Derivatives of the angular velocities of the ball joints.
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
    /// Derivatives of the positions of the revolute and prismatic joints, (k, m, p) float64.
    joint_positions: Py<PyArrayDyn<f64>>,
    /// Derivatives of the velocities of the revolute and prismatic joints, (k, m, p) float64.
    joint_velocities: Py<PyArrayDyn<f64>>,
    /// Derivatives of the rotations of the ball joints, (k, b, 3, 3, p) float64.
    ball_joint_rotations: Py<PyArrayDyn<f64>>,
    /// Derivatives of the angular velocities of the ball joints, (k, b, 3, p) float64.
    ball_joint_velocities: Py<PyArrayDyn<f64>>,
}

/// Axes of the derivatives, in the order of `NAMES`.
const AXES: [&[&str]; ARRAYS] = [
    &["k", "n", "4", "4", "p"],
    &["k", "n", "6", "p"],
    &["k", "m", "p"],
    &["k", "m", "p"],
    &["k", "b", "3", "3", "p"],
    &["k", "b", "3", "p"],
];

impl TrajectoryJacobian {
    fn of(arrays: [Py<PyArrayDyn<f64>>; ARRAYS]) -> Self {
        let [
            poses,
            twists,
            joint_positions,
            joint_velocities,
            ball_joint_rotations,
            ball_joint_velocities,
        ] = arrays;
        Self {
            poses,
            twists,
            joint_positions,
            joint_velocities,
            ball_joint_rotations,
            ball_joint_velocities,
        }
    }

    fn arrays(&self) -> [&Py<PyArrayDyn<f64>>; ARRAYS] {
        [
            &self.poses,
            &self.twists,
            &self.joint_positions,
            &self.joint_velocities,
            &self.ball_joint_rotations,
            &self.ball_joint_velocities,
        ]
    }
}

#[pymethods]
impl TrajectoryJacobian {
    #[new]
    fn new(
        py: Python<'_>,
        poses: Py<PyArrayDyn<f64>>,
        twists: Py<PyArrayDyn<f64>>,
        joint_positions: Py<PyArrayDyn<f64>>,
        joint_velocities: Py<PyArrayDyn<f64>>,
        ball_joint_rotations: Py<PyArrayDyn<f64>>,
        ball_joint_velocities: Py<PyArrayDyn<f64>>,
    ) -> PyResult<Self> {
        let jacobian = Self {
            poses,
            twists,
            joint_positions,
            joint_velocities,
            ball_joint_rotations,
            ball_joint_velocities,
        };
        let named = jacobian.arrays().into_iter().zip(NAMES).zip(AXES);
        let kept: Vec<_> = named
            .map(|((array, name), axes)| (array, name, axes))
            .collect();
        check_kept(py, &kept)?;
        Ok(jacobian)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let mut shown = Vec::new();
        for (array, name) in self.arrays().into_iter().zip(NAMES) {
            let array = array.bind(py);
            // Axis 1 counts bodies or joints.
            if name == "poses" || name == "twists" || array.shape()[1] > 0 {
                shown.push(format!("{name} {}", array.getattr("shape")?.repr()?));
            }
        }
        Ok(format!("TrajectoryJacobian({})", shown.join(", ")))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.arrays())
    }
}

/// Converts the Jacobian of [`AllStates`] to a trajectory and its derivatives. `like` is a state of the same world.
pub fn both(
    py: Python<'_>,
    outcome: &OutcomeJacobian,
    like: &dynamics::State,
) -> PyResult<(Trajectory, TrajectoryJacobian)> {
    let (shapes, sizes) = (shapes_of(like), sizes_of(like));
    let each = 1 + sizes.iter().sum::<usize>();
    let firsts: [usize; ARRAYS] =
        std::array::from_fn(|which| 1 + sizes[..which].iter().sum::<usize>());
    let states = outcome.value.as_slice().chunks(each).map(|numbers| {
        let part = |which: usize| &numbers[firsts[which]..firsts[which] + sizes[which]];
        state_of(numbers[0], std::array::from_fn(part), like)
    });
    let states = states.collect::<PyResult<Vec<_>>>()?;
    let (count, columns) = (states.len(), outcome.jacobian.ncols());
    let derivatives = |which: usize| {
        let rows = (0..count).flat_map(|state| {
            let first = state * each + firsts[which];
            first..first + sizes[which]
        });
        let row = |row| (0..columns).map(move |column| outcome.jacobian[(row, column)]);
        let shape = [&[count], &*shapes[which], &[columns]].concat();
        array(py, rows.flat_map(row).collect(), &shape).map(Bound::unbind)
    };
    let jacobian = TrajectoryJacobian::of([
        derivatives(0)?,
        derivatives(1)?,
        derivatives(2)?,
        derivatives(3)?,
        derivatives(4)?,
        derivatives(5)?,
    ]);
    let trajectory = dynamics::Trajectory::new(states).map_err(value_error)?;
    Ok((trajectory.into(), jacobian))
}

/// Comparison of the derivatives of recorded states with central differences at seven step sizes.
///
/// The errors of a correct derivative have a plateau of small values between step sizes that are too long and too short.
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
        self.array_of(py, |derivative| derivative.error)
    }

    /// Change of each parameter component over which the slope was taken, (p,) float64, in the unit of the component. For a right
    /// derivative it is the largest tested change whose effect the derivative predicts.
    #[getter]
    fn widths<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.array_of(py, |derivative| derivative.width)
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

impl DerivativeCheck {
    /// Returns an array with one number per derivative.
    fn array_of<'py>(
        &self,
        py: Python<'py>,
        number: impl Fn(&gradient::CheckedDerivative) -> f64,
    ) -> PyResult<Floats<'py>> {
        let numbers: Vec<f64> = self.0.derivatives.iter().map(number).collect();
        let count = numbers.len();
        array(py, numbers, &[count])
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
