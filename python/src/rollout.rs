//! Rollouts: the steps of a world, one after another.

use crate::diagnostics::StepReport;
use crate::errors::{rollout_error, rollout_error_without_trajectory, value_error};
use crate::interrupt::{Progress, Shared, run};
use crate::plan::Plan;
use crate::state::State;
use crate::trajectory::Trajectory;
use hydroelastic::dynamics::{self, RolloutError};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

/// Rollout of a world: an iterator that takes the steps of a plan and returns the state after each step. Created by World.rollout.
///
/// A rollout cannot be pickled, because implicit steps keep solver state from earlier steps. Instead, World.rollout can continue with
/// rollout.state as its start. Explicit steps then have the same bits.
///
/// Only one thread at a time can use a rollout. A call from another thread raises HydroelasticError. A step raises RolloutError if its
/// state is not finite, it fails the stability check, or it cannot be solved.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Rollout(Mutex<Steps>);

/// Stepping state of a rollout.
#[allow(
    clippy::struct_field_names,
    reason = "the library's steps are one of the fields"
)]
struct Steps {
    steps: dynamics::Rollout,
    plan: dynamics::Plan,
    step_count: usize,
    total: Option<dynamics::StepReport>,
    /// Stop flag. Steps end when the flag is true.
    stop: Arc<AtomicBool>,
}

impl Rollout {
    pub fn of(steps: dynamics::Rollout, plan: dynamics::Plan) -> Self {
        let (step_count, total, stop) = (0, None, Arc::<AtomicBool>::default());
        Self(Mutex::new(Steps {
            steps: steps.with_cancel_flag(Arc::clone(&stop)),
            plan,
            step_count,
            total,
            stop,
        }))
    }

    /// Locks the steps. Returns an error if another thread is taking steps.
    fn steps(&self) -> PyResult<MutexGuard<'_, Steps>> {
        match self.0.try_lock() {
            Ok(steps) => Ok(steps),
            Err(TryLockError::Poisoned(steps)) => Ok(steps.into_inner()),
            Err(TryLockError::WouldBlock) => Err(value_error(
                "another thread is taking steps of this rollout: use one rollout for each thread",
            )),
        }
    }

    /// Takes a step and returns the state after it.
    pub fn next_step(&self, py: Python<'_>) -> PyResult<State> {
        self.steps()?.next_step(py)
    }
}

impl Steps {
    /// Clears the stop flag, so that a stopped rollout can continue. Returns the data that a job shares with its caller.
    fn begun(&self) -> Shared {
        self.stop.store(false, Ordering::Relaxed);
        Shared {
            stop: Arc::clone(&self.stop),
            ..Shared::default()
        }
    }

    /// Takes a step and returns the state after it. Ctrl-C can end an implicit step; explicit steps are short.
    fn next_step(&mut self, py: Python<'_>) -> PyResult<State> {
        let shared = self.begun();
        let result = if self.plan.integrator().is_implicit() {
            run(py, &shared, None, || self.step())?
        } else {
            py.detach(|| self.step())
        };
        result.map_err(|why| rollout_error_without_trajectory(&why))?;
        Ok(State(self.steps.state().clone()))
    }

    fn step(&mut self) -> Result<(), RolloutError> {
        self.steps.advance()?;
        self.step_count += 1;
        if let Some(report) = self.steps.step_report() {
            *self.total.get_or_insert_default() += report.clone();
        }
        Ok(())
    }

    /// Takes the remaining steps and appends the recorded states to a list.
    fn record(
        &mut self,
        states: &mut Vec<dynamics::State>,
        shared: &Shared,
    ) -> Result<(), RolloutError> {
        while self.step_count < self.plan.steps() {
            self.step()?;
            if self.step_count.is_multiple_of(self.plan.record_every())
                || self.step_count == self.plan.steps()
            {
                states.push(self.steps.state().clone());
            }
            shared.done.store(self.step_count, Ordering::Relaxed);
        }
        Ok(())
    }
}

#[pymethods]
impl Rollout {
    /// Plan of the rollout.
    #[getter]
    fn plan(&self) -> PyResult<Plan> {
        Ok(Plan(self.steps()?.plan))
    }

    /// Current state: the state after the last step, or the initial state.
    #[getter]
    fn state(&self) -> PyResult<State> {
        Ok(State(self.steps()?.steps.state().clone()))
    }

    /// Number of steps taken.
    #[getter]
    fn steps_taken(&self) -> PyResult<usize> {
        Ok(self.steps()?.step_count)
    }

    /// Report of the last step. None before the first step, and for explicit steps.
    #[getter]
    fn step_report(&self) -> PyResult<Option<StepReport>> {
        Ok(self.steps()?.steps.step_report().cloned().map(StepReport))
    }

    /// Sum of the reports of all steps so far. None before the first step, and for explicit steps.
    #[getter]
    fn total_step_report(&self) -> PyResult<Option<StepReport>> {
        Ok(self.steps()?.total.clone().map(StepReport))
    }

    /// Takes all remaining steps.
    ///
    /// Ctrl-C ends the rollout before its next step, or during an implicit step.
    ///
    /// Parameters
    /// ----------
    /// progress : bool or callable, optional
    ///     True for a progress bar of tqdm if tqdm is installed, or a function of (done, total) steps.
    ///
    /// Returns
    /// -------
    /// Trajectory
    ///     Current state, then the states that the plan records.
    ///
    /// Raises
    /// ------
    /// RolloutError
    ///     If a step fails. The attribute trajectory of the error has the states recorded so far.
    /// HydroelasticError
    ///     If another thread uses the rollout.
    #[pyo3(signature = (*, progress=None))]
    fn run(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Trajectory> {
        let mut guard = self.steps()?;
        let steps = &mut *guard;
        let progress = Progress::of(py, progress, steps.plan.steps())?;
        let shared = steps.begun();
        let mut states = vec![steps.steps.state().clone()];
        let result = run(py, &shared, progress.as_ref(), || {
            steps.record(&mut states, &shared)
        })?;
        let trajectory = dynamics::Trajectory::new(states).map_err(value_error)?;
        match result {
            Ok(()) => Ok(trajectory.into()),
            Err(why) => Err(rollout_error(py, &why, trajectory)),
        }
    }

    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<State>> {
        let mut guard = self.steps()?;
        let steps = &mut *guard;
        if steps.step_count >= steps.plan.steps() {
            return Ok(None);
        }
        steps.next_step(py).map(Some)
    }

    #[allow(clippy::unused_self, reason = "a method, to pickle")]
    fn __reduce__(&self) -> PyResult<()> {
        Err(PyTypeError::new_err(
            "a Rollout cannot be pickled or copied: what its implicit steps remember of earlier ones stays in this process. The \
             world, the plan and rollout.state can, and world.rollout(plan, start=state) goes on from there",
        ))
    }

    fn __repr__(&self) -> PyResult<String> {
        let steps = self.steps()?;
        let (step_count, plan) = (steps.step_count, steps.plan);
        let shown = Plan(plan).__repr__();
        Ok(format!(
            "Rollout({step_count} of {} steps, {shown})",
            plan.steps()
        ))
    }
}
