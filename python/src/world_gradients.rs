//! Derivatives of rollouts.

use crate::arrays::{Floats, Whole, array, count, real, whole};
use crate::errors::gradient_error;
use crate::interrupt::{Progress, Shared, run};
use crate::jacobian::{
    AllStates, DerivativeCheck, DifferenceCheck, RecordedPositions, TrajectoryJacobian, both,
};
use crate::kink::Kink;
use crate::parameter::{Parameter, inner};
use crate::plan::Plan;
use crate::state_cotangents::StateCotangents;
use crate::trajectory::Trajectory;
use crate::world::World;
use hydroelastic::gradient::{self, Experiment, GradientError, Mode};
use hydroelastic::nalgebra::DMatrix;
use pyo3::prelude::*;
use std::sync::Arc;

/// Number of reverse sweeps that take about as long as one rollout with forward derivatives.
const SWEEPS: usize = 2;

impl World {
    /// What is read from an experiment, which Ctrl-C stops; with progress over the steps of derivatives by so many numbers.
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
        let progress = Progress::of(py, progress, experiment.step_count_for(numbers))?;
        let found = run(py, &shared, progress.as_ref(), || read(&experiment))?;
        found.map_err(|why| gradient_error(&why))
    }
}

/// How many numbers there are in parameters.
fn width(parameters: &[gradient::Parameter]) -> usize {
    parameters.iter().map(gradient::Parameter::dimension).sum()
}

/// A matrix as an array.
fn by_rows<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Floats<'py>> {
    let values = matrix.transpose().as_slice().to_vec();
    array(py, values, &[matrix.nrows(), matrix.ncols()])
}

#[pymethods]
impl World {
    /// The recorded states of a rollout and their derivatives by p numbers of parameters: in forward mode, in one rollout for up
    /// to 96 numbers. With jacobian.poses[-1, i, :3, 3] the last position of body i is differentiated, by each number.
    ///
    /// Derivatives are constants to whoever takes them: there are no second ones.
    ///
    /// progress : True for a progress bar of tqdm, if that is installed; or a function of (done, total) steps. Ctrl-C ends the
    ///     rollout before its next step, or during an implicit step.
    ///
    /// Raises
    /// ------
    /// HydroelasticError if a parameter is not one of the world's, or a derivative is not finite; RolloutError, without a
    /// trajectory, if the rollout ends early.
    #[pyo3(signature = (plan, parameters, *, progress=None))]
    fn jacobian(
        &self,
        py: Python<'_>,
        plan: &Plan,
        parameters: Vec<Bound<'_, Parameter>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Trajectory, TrajectoryJacobian)> {
        let by = inner(&parameters);
        let watched = (width(&by), progress);
        let found = self.experiment(py, plan, watched, |it| it.jacobian(&by, &AllStates))?;
        both(py, &found, self.inner.bodies().len())
    }

    /// (p,) float64: the derivatives of a number by p numbers of parameters, from those by the recorded states, which have the
    /// shapes of the trajectory's arrays: by_poses (k, n, 4, 4), by_twists (k, n, 6). The same as the product with the Jacobian,
    /// np.tensordot(by_poses, jacobian.poses, 4) + np.tensordot(by_twists, jacobian.twists, 3), but by a sweep back from the
    /// last state, in a time that does not depend on p. The rollout is done again for it.
    ///
    /// Of the derivatives by the entries of a rotation the part counts that turns it, and of prescribed bodies none.
    ///
    /// memory : for the steps that the sweep goes over (bytes; 256 MiB if None): steps that do not go into it are computed again.
    ///
    /// Raises
    /// ------
    /// HydroelasticError if a parameter is not one of the world's, an array has another shape, or a derivative is not finite;
    /// RolloutError, without a trajectory, if the rollout ends early.
    #[pyo3(signature = (plan, parameters, by_poses, by_twists, *, memory=None))]
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        plan: &Plan,
        parameters: Vec<Bound<'py, Parameter>>,
        by_poses: &Bound<'py, PyAny>,
        by_twists: &Bound<'py, PyAny>,
        memory: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Floats<'py>> {
        let memory = memory.map(|it| count(whole(it)?, "memory")).transpose()?;
        let by = inner(&parameters);
        let recorded = (&plan.0, self.inner.bodies().len());
        let cotangents = StateCotangents::of(by_poses, by_twists, recorded, None)?;
        let found = self.experiment(py, plan, (0, None), |it| {
            let own = memory.map(|memory| it.clone().with_memory(memory));
            let it = own.as_ref().unwrap_or(it);
            it.vjp(&by, |trajectory| cotangents.covectors(0, trajectory))
        })?;
        array(py, found.as_slice().to_vec(), &[found.len()])
    }

    /// Where a rollout has no derivative, or one of several is taken, in gradients and Jacobians alike: tuples of what it is, the
    /// names of the bodies, the number of steps, and the first and the last of them, counted from 1.
    ///
    /// "flush faces": faces of two bodies coincide. "clamped pressure": they part so fast that it is 0 somewhere. "equal fields":
    /// both pressures are equal over a volume. "unresolved step": the errors of an implicit step exceed the tolerances of the plan.
    ///
    /// Raises
    /// ------
    /// RolloutError, without a trajectory, if the rollout ends early.
    fn kinks(&self, py: Python<'_>, plan: &Plan) -> PyResult<Vec<Kink>> {
        let found = self.experiment(py, plan, (0, None), Experiment::kinks)?;
        let names = self.names_of();
        Ok(found
            .iter()
            .map(|summary| Kink::of(summary, &names))
            .collect())
    }

    /// Whether vjp computes the gradients of this many losses with respect to these parameters faster than jacobian.
    ///
    /// For one gradient, vjp is faster if the parameters have more than 12 numbers, or more than 96 if steps are implicit. Two
    /// calls of vjp take about as long as the rollout of jacobian for every 96 numbers. jacobian gives the Jacobian of all recorded
    /// states, from which the gradients then have to be computed.
    #[pyo3(name = "_sweeps_back", signature = (plan, parameters, losses=1))]
    fn sweeps_back(
        &self,
        plan: &Plan,
        parameters: Vec<Bound<'_, Parameter>>,
        #[pyo3(from_py_with = whole)] losses: Whole,
    ) -> PyResult<bool> {
        let (by, losses) = (inner(&parameters), count(losses, "losses")?);
        let experiment = Experiment::new(&self.inner, &plan.0);
        let steps = experiment.step_count_for(width(&by));
        let is_cheaper = losses.saturating_mul(experiment.step_count_for(0)) <= SWEEPS * steps;
        Ok(experiment.mode_for(&by) == Mode::Reverse && is_cheaper)
    }

    /// The end of a rollout to first order in local coordinates, 12 numbers for each of d dynamic bodies as of displacement: A
    /// (12 d, 12 d), by the start, and B (12 d, p), by the parameters. A plan of one step gives that of the step.
    ///
    /// progress : as of jacobian.
    #[pyo3(signature = (plan, parameters=vec![], *, progress=None))]
    fn linearize<'py>(
        &self,
        py: Python<'py>,
        plan: &Plan,
        parameters: Vec<Bound<'py, Parameter>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let by = inner(&parameters);
        let dynamic = self
            .inner
            .bodies()
            .iter()
            .filter(|it| it.inertia().is_some());
        let watched = (12 * dynamic.count() + width(&by), progress);
        let found = self.experiment(py, plan, watched, |it| it.linearize(&by))?;
        Ok((
            by_rows(py, &found.by_state)?,
            by_rows(py, &found.by_parameters)?,
        ))
    }

    /// Compares the derivatives of the recorded positions with the slopes of the motion over a width on either side. Takes 4 + 4 p
    /// rollouts at tight tolerances, and a Jacobian there if a derivative is not right.
    ///
    /// width : in typical changes of each number, its value for materials and masses, else 1 SI unit: the tolerance to which the
    /// number matters.
    ///
    /// The verdict on a derivative is "right"; "kink" if it is the slope on one side only; "unresolved" if
    /// it is right at tight tolerances, but not at those of the plan; "chaotic" if it is not the slope at any tolerance; and "noisy" if
    /// it agrees only because the noise of the rollouts exceeds 3 % of the slope: take a larger width.
    #[pyo3(signature = (plan, parameters, *, width=1e-3))]
    fn derivative_check(
        &self,
        py: Python<'_>,
        plan: &Plan,
        parameters: Vec<Bound<'_, Parameter>>,
        #[pyo3(from_py_with = real)] width: f64,
    ) -> PyResult<DerivativeCheck> {
        let by = inner(&parameters);
        let found = self.experiment(py, plan, (0, None), |it| {
            it.derivative_check(&by, &RecordedPositions, width)
        })?;
        Ok(DerivativeCheck(found))
    }

    /// Compares the derivatives of the recorded states with central differences of the same steps, at seven steps. Takes 1 + 14 p
    /// rollouts.
    fn difference_check(
        &self,
        py: Python<'_>,
        plan: &Plan,
        parameters: Vec<Bound<'_, Parameter>>,
    ) -> PyResult<DifferenceCheck> {
        let by = inner(&parameters);
        let found = self.experiment(py, plan, (0, None), |it| {
            it.difference_check(&by, &AllStates)
        })?;
        Ok(DifferenceCheck(found))
    }
}
