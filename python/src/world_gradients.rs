//! Derivatives of rollouts.

use crate::arrays::{Floats, Whole, array, count, whole};
use crate::errors::gradient_error;
use crate::interrupt::{Progress, Shared, run};
use crate::jacobian::{
    AllStates, DerivativeCheck, DifferenceCheck, RecordedPositions, TrajectoryJacobian, both,
};
use crate::kink::Kink;
use crate::lists::list_of;
use crate::parameter::{Parameter, inner};
use crate::plan::Plan;
use crate::state::State;
use crate::trajectory::Trajectory;
use crate::vjp::VectorJacobianProduct;
use crate::world::World;
use hydroelastic::gradient::{
    self, Experiment, FirstContact, GradientError, Mode, RolloutClearance,
};
use hydroelastic::nalgebra::{DMatrix, DVector};
use pyo3::prelude::*;
use std::sync::Arc;

/// Number of reverse sweeps that take about as long as one rollout with forward derivatives.
const SWEEPS: usize = 2;

impl World {
    /// Runs a function of an experiment, which Ctrl-C stops. Progress counts the steps of derivatives with respect to `numbers` numbers.
    fn experiment<O: Send>(
        &self,
        py: Python<'_>,
        plan: &Plan,
        (numbers, progress): (usize, Option<&Bound<'_, PyAny>>),
        read: impl FnOnce(&Experiment) -> Result<O, GradientError> + Send,
    ) -> PyResult<O> {
        let shared = Shared::default();
        let experiment = Experiment::new(&self.inner, &plan.0)
            .with_cancel_flag(Arc::clone(&shared.stop))
            .with_step_counter(Arc::clone(&shared.done));
        let step_count = experiment.step_count_for(numbers);
        let step_count = step_count.map_err(|why| gradient_error(&why))?;
        let progress = Progress::of(py, progress, step_count)?;
        let result = run(py, &shared, progress.as_ref(), || read(&experiment))?;
        result.map_err(|why| gradient_error(&why))
    }
}

/// Number of components of parameters.
fn width(parameters: &[gradient::Parameter]) -> usize {
    parameters.iter().map(gradient::Parameter::dimension).sum()
}

/// Converts a matrix to an array.
pub fn by_rows<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Floats<'py>> {
    let values = matrix.transpose().as_slice().to_vec();
    array(py, values, &[matrix.nrows(), matrix.ncols()])
}

/// Converts a vector to an array.
fn column<'py>(py: Python<'py>, vector: &DVector<f64>) -> PyResult<Floats<'py>> {
    array(py, vector.as_slice().to_vec(), &[vector.len()])
}

#[pymethods]
impl World {
    /// Runs a rollout and differentiates the recorded states with respect to parameters, in forward mode.
    ///
    /// One rollout computes the derivatives with respect to up to 96 numbers. For example, jacobian.poses[-1, i, :3, 3] has the
    /// derivatives of the last position of body i with respect to each number. Second derivatives are not available. Ctrl-C ends the
    /// rollout before its next step, or during an implicit step.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter
    ///     Parameters to differentiate with respect to, with p components in total.
    /// progress : bool or callable, optional
    ///     True for a progress bar of tqdm if tqdm is installed, or a function of (done, total) steps.
    ///
    /// Returns
    /// -------
    /// trajectory : Trajectory
    ///     Recorded states.
    /// jacobian : TrajectoryJacobian
    ///     Derivatives of the recorded states.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world, or a derivative is not finite.
    /// RolloutError
    ///     If the rollout ends early. The error has no trajectory.
    #[pyo3(signature = (plan, parameters, *, progress=None))]
    fn jacobian(
        &self,
        py: Python<'_>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Trajectory, TrajectoryJacobian)> {
        let by = inner(&parameters);
        let watched = (width(&by), progress);
        let outcome = self.experiment(py, plan, watched, |experiment| {
            experiment.jacobian(&by, &AllStates)
        })?;
        both(py, &outcome, &self.inner.initial_state())
    }

    /// Runs a rollout, and returns its trajectory and its vector–Jacobian product with respect to parameters.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter
    ///     Parameters to differentiate with respect to, with p components in total.
    /// memory : int, optional
    ///     Memory (bytes) for stored steps. Steps that do not fit are computed again. Default: 256 MiB.
    ///
    /// Returns
    /// -------
    /// trajectory : Trajectory
    ///     k recorded states of n bodies.
    /// vjp : VectorJacobianProduct
    ///     Function of (by_poses, by_twists), and of derivatives with respect to joints, that returns the gradient of a loss with respect
    ///     to the parameters.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world.
    /// RolloutError
    ///     If the rollout ends early. The error has no trajectory.
    #[pyo3(signature = (plan, parameters, *, memory=None))]
    fn vjp(
        &self,
        py: Python<'_>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
        memory: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Trajectory, VectorJacobianProduct)> {
        let memory = memory
            .map(|value| count(whole(value)?, "memory"))
            .transpose()?;
        let by = inner(&parameters);
        let shared = Shared::default();
        let experiment = Experiment::new(&self.inner, &plan.0);
        let experiment = experiment.with_cancel_flag(Arc::clone(&shared.stop));
        let experiment = match memory {
            Some(memory) => experiment.with_memory(memory),
            None => experiment,
        };
        let vjp = run(py, &shared, None, || experiment.vjp(&by))?;
        let vjp = vjp.map_err(|why| gradient_error(&why))?;
        let trajectory = vjp.trajectory().clone().into();
        Ok((trajectory, VectorJacobianProduct::new(vjp, plan.0)))
    }

    /// Computes the clearance of two bodies in a rollout, and its gradient, also if the bodies never touch.
    ///
    /// The clearance is the signed distance of Pair.clearance. Its derivatives treat shapes and moduli as constants, except for their
    /// effect on the motion.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter
    ///     Parameters to differentiate with respect to, with p components in total.
    /// first, second : str
    ///     Names of the bodies. At least one of them must be compliant and have a mesh.
    /// least : bool, optional
    ///     If True, returns the least clearance at the recorded states. Default: the clearance at the last state.
    ///
    /// Returns
    /// -------
    /// clearance : float
    ///     Clearance (m).
    /// gradient : (p,) ndarray of float64
    ///     Derivatives of the clearance.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the bodies have no clearance, or a parameter does not belong to the world.
    /// RolloutError
    ///     If the rollout ends early. The error has no trajectory.
    #[pyo3(signature = (plan, parameters, first, second, *, least=false))]
    fn clearance<'py>(
        &self,
        py: Python<'py>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
        first: &str,
        second: &str,
        least: bool,
    ) -> PyResult<(f64, Floats<'py>)> {
        let by = inner(&parameters);
        let (clearance, gradient) = self.experiment(py, plan, (0, None), |experiment| {
            let loss = RolloutClearance::between(&self.inner, first, second)?;
            let loss = if least { loss.least() } else { loss };
            experiment.gradient(&by, &loss)
        })?;
        Ok((clearance, column(py, &gradient)?))
    }

    /// Computes the time of the first contact of two bodies in a rollout, or their least clearance if they stay apart, and its gradient.
    ///
    /// Poses between two recorded states are cubic polynomials of time. Contacts that begin and end between two recorded states are not
    /// found. The time has a kink if the features that touch first change, and jumps if a contact is grazing.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter
    ///     Parameters to differentiate with respect to, with p components in total.
    /// first, second : str
    ///     Names of the bodies. At least one of them must be compliant and have a mesh.
    ///
    /// Returns
    /// -------
    /// time : float
    ///     Time (s) of the first contact, or of the least clearance if the bodies stay apart.
    /// clearance : float
    ///     0 if the bodies touch, and the least clearance (m) at the recorded states if they stay apart.
    /// gradient : (p,) ndarray of float64
    ///     Derivatives of the time if the bodies touch, and of the clearance if they stay apart.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the bodies have no clearance, or a parameter does not belong to the world.
    /// RolloutError
    ///     If the rollout ends early. The error has no trajectory.
    fn first_contact<'py>(
        &self,
        py: Python<'py>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
        first: &str,
        second: &str,
    ) -> PyResult<(f64, f64, Floats<'py>)> {
        let by = inner(&parameters);
        let contact = self.experiment(py, plan, (0, None), |experiment| {
            experiment.first_contact(&by, [first, second])
        })?;
        let (time, clearance, gradient) = match contact {
            FirstContact::Apart {
                least_clearance,
                time,
                gradient,
            } => (time, least_clearance, gradient),
            FirstContact::Touching { time, gradient } => (time, 0.0, gradient),
        };
        Ok((time, clearance, column(py, &gradient)?))
    }

    /// Finds the nonsmooth points of a rollout. There, gradients and Jacobians do not exist, or are one of several one-sided derivatives.
    ///
    /// The kinds are:
    ///
    /// - "flush faces": faces of two bodies coincide.
    /// - "clamped pressure": surfaces separate so fast that the pressure is 0 at some points.
    /// - "equal fields": the pressures of both bodies are equal in a volume.
    /// - "unresolved step": the errors of an implicit step exceed the tolerances of the plan.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    ///
    /// Returns
    /// -------
    /// list of Kink
    ///     Nonsmooth points, summarized by kind and bodies.
    ///
    /// Raises
    /// ------
    /// RolloutError
    ///     If the rollout ends early. The error has no trajectory.
    fn kinks(&self, py: Python<'_>, plan: &Plan) -> PyResult<Vec<Kink>> {
        let kinks = self.experiment(py, plan, (0, None), Experiment::kinks)?;
        let names = self.names_of();
        Ok(kinks
            .iter()
            .map(|summary| Kink::of(summary, &names))
            .collect())
    }

    /// Returns whether vjp computes the gradients of several losses with respect to parameters faster than jacobian.
    ///
    /// For one gradient, vjp is faster if the parameters have more than 12 numbers, or more than 96 numbers if steps are implicit. Two
    /// calls of vjp take about as long as one rollout of jacobian, which covers up to 96 numbers. jacobian returns the Jacobian of all
    /// recorded states, from which the caller computes the gradients.
    #[pyo3(signature = (plan, parameters, losses=1))]
    fn _sweeps_back(
        &self,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
        #[pyo3(from_py_with = whole)] losses: Whole,
    ) -> PyResult<bool> {
        let (by, losses) = (inner(&parameters), count(losses, "losses")?);
        let experiment = Experiment::new(&self.inner, &plan.0);
        let steps = experiment.step_count_for(width(&by));
        let steps = steps.map_err(|why| gradient_error(&why))?;
        let is_cheaper = losses.saturating_mul(plan.0.steps()) <= SWEEPS.saturating_mul(steps);
        Ok(experiment.mode_for(&by) == Mode::Reverse && is_cheaper)
    }

    /// Linearizes the last state of a rollout in the n tangent-space coordinates of difference.
    ///
    /// A plan with one step gives the linearization of the step. Inputs of a robot are parameters such as
    /// ``Parameter.joint("elbow", "torque")``.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter, optional
    ///     Parameters to differentiate with respect to, with p components in total. Default: none.
    /// progress : bool or callable, optional
    ///     True for a progress bar of tqdm if tqdm is installed, or a function of (done, total) steps.
    ///
    /// Returns
    /// -------
    /// end : State
    ///     Last state.
    /// a : (n, n) ndarray of float64
    ///     Derivatives with respect to the initial state.
    /// b : (n, p) ndarray of float64
    ///     Derivatives with respect to the parameters.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world, or a derivative is not finite.
    /// RolloutError
    ///     If the rollout ends early. The error has no trajectory.
    #[pyo3(signature = (plan, parameters=vec![], *, progress=None))]
    fn linearize<'py>(
        &self,
        py: Python<'py>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(State, Floats<'py>, Floats<'py>)> {
        let by = inner(&parameters);
        let watched = (self.inner.tangent_dimension() + width(&by), progress);
        let linearization =
            self.experiment(py, plan, watched, |experiment| experiment.linearize(&by))?;
        Ok((
            State(linearization.end),
            by_rows(py, &linearization.by_state)?,
            by_rows(py, &linearization.by_parameters)?,
        ))
    }

    /// Compares the derivatives of the recorded positions with the slopes of the motion.
    ///
    /// The first state is omitted. Slopes are differences of rollouts at tight tolerances over decreasing changes of a number, from 1e-2 to
    /// 8e-5 typical changes. A typical change is the value of a material number, a mass or a force parameter that is not zero, and 1 SI
    /// unit otherwise. A derivative agrees with a slope if they differ by at most 3 % plus the noise of the rollouts. The verdicts on a
    /// derivative are:
    ///
    /// - "right": the derivative agrees with the slopes over two successive changes.
    /// - "kink": the derivative of the plan or at tight tolerances agrees with the slope on one side only.
    /// - "unresolved": the derivative agrees with the slope at tight tolerances, but not at the tolerances of the plan.
    /// - "chaotic": the derivative agrees with no slope, not even at tight tolerances.
    /// - "noisy": the derivative agrees with the slope, but the noise of the rollouts exceeds 3 % of the slope.
    ///
    /// The check takes a Jacobian of the plan, and at least 6 rollouts at tight tolerances for each component. If a derivative does not
    /// agree with the slopes, the check takes up to 16 rollouts for its component, and one Jacobian at tight tolerances.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter
    ///     Parameters to check, with p components in total.
    ///
    /// Returns
    /// -------
    /// DerivativeCheck
    ///     Verdict and error of each derivative.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world, or a derivative is not finite.
    /// RolloutError
    ///     If a rollout ends early. The error has no trajectory.
    fn derivative_check(
        &self,
        py: Python<'_>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
    ) -> PyResult<DerivativeCheck> {
        let by = inner(&parameters);
        let check = self.experiment(py, plan, (0, None), |experiment| {
            experiment.derivative_check(&by, &RecordedPositions)
        })?;
        Ok(DerivativeCheck(check))
    }

    /// Compares the derivatives of the recorded states with central differences of the same time steps, at seven step sizes.
    ///
    /// The check takes a Jacobian and 14 p rollouts. If a derivative is not finite, its errors are infinite.
    ///
    /// Parameters
    /// ----------
    /// plan : Plan
    ///     Plan of the rollout.
    /// parameters : list of Parameter
    ///     Parameters to check, with p components in total.
    ///
    /// Returns
    /// -------
    /// DifferenceCheck
    ///     Errors at each step size.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world.
    /// RolloutError
    ///     If a rollout ends early. The error has no trajectory.
    fn difference_check(
        &self,
        py: Python<'_>,
        plan: &Plan,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
    ) -> PyResult<DifferenceCheck> {
        let by = inner(&parameters);
        let check = self.experiment(py, plan, (0, None), |experiment| {
            experiment.difference_check(&by, &AllStates)
        })?;
        Ok(DifferenceCheck(check))
    }
}
