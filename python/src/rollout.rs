//! Steps of a world, one after another.

use crate::errors::{ended, interrupted};
use crate::interrupt::{Progress, Shared, run};
use crate::plan::Plan;
use crate::report::StepReport;
use crate::state::State;
use crate::trajectory::Trajectory;
use hydroelastic::dynamics::{self, RolloutError};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The steps of a world by a plan: an iterator over the states after each, as many as are planned. Made by World.rollout.
///
/// A rollout cannot be pickled: what implicit steps remember of earlier ones does not travel. World.rollout with rollout.state
/// for its start goes on from there, explicit steps with the same bits.
///
/// A step that leads to a state that is not finite, fails the stability check or is not solved raises RolloutError.
#[pyclass(module = "hydroelastic")]
pub struct Rollout {
    steps: dynamics::Rollout,
    plan: dynamics::Plan,
    taken: usize,
    total: Option<dynamics::StepReport>,
    /// Ends the steps once it is true.
    stop: Arc<AtomicBool>,
}

impl Rollout {
    pub fn of(steps: dynamics::Rollout, plan: dynamics::Plan) -> Self {
        let (taken, total, stop) = (0, None, Arc::<AtomicBool>::default());
        Self {
            steps: steps.stopped_by(Arc::clone(&stop)),
            plan,
            taken,
            total,
            stop,
        }
    }

    /// The same steps without a flag that is set: a job that was stopped may go on.
    fn begun(&self) -> Shared {
        self.stop.store(false, Ordering::Relaxed);
        Shared {
            stop: Arc::clone(&self.stop),
            ..Shared::default()
        }
    }

    /// Takes a step that Ctrl-C ends if it is implicit: explicit ones are short.
    pub fn next_step(&mut self, py: Python<'_>) -> PyResult<()> {
        let shared = self.begun();
        let found = if self.plan.integrator().is_implicit() {
            run(py, &shared, None, || self.step())?
        } else {
            py.detach(|| self.step())
        };
        found.map_err(|why| ended(&why))
    }

    fn step(&mut self) -> Result<(), RolloutError> {
        self.steps.advance()?;
        self.taken += 1;
        if let Some(report) = self.steps.report() {
            *self.total.get_or_insert_default() += *report;
        }
        Ok(())
    }

    /// The remaining steps; the states that are to be recorded go on a list.
    fn record(
        &mut self,
        states: &mut Vec<dynamics::State>,
        shared: &Shared,
    ) -> Result<(), RolloutError> {
        while self.taken < self.plan.steps() {
            self.step()?;
            if self.taken.is_multiple_of(self.plan.record_every())
                || self.taken == self.plan.steps()
            {
                states.push(self.steps.state().clone());
            }
            shared.done.store(self.taken, Ordering::Relaxed);
        }
        Ok(())
    }
}

#[pymethods]
impl Rollout {
    /// The plan.
    #[getter]
    fn plan(&self) -> Plan {
        Plan(self.plan)
    }

    /// The state last reached, or the initial one.
    #[getter]
    pub fn state(&self) -> State {
        State(self.steps.state().clone())
    }

    /// Number of steps taken.
    #[getter]
    fn taken(&self) -> usize {
        self.taken
    }

    /// What the last step took; None before it, and for explicit steps.
    #[getter]
    fn report(&self) -> Option<StepReport> {
        self.steps.report().copied().map(StepReport)
    }

    /// What all steps took so far; None before the first, and for explicit steps.
    #[getter]
    fn total_report(&self) -> Option<StepReport> {
        self.total.map(StepReport)
    }

    /// Takes all remaining steps and returns the states that the plan records, the present one first.
    ///
    /// progress : True for a progress bar of tqdm, if that is installed; or a function of (done, total) steps.
    ///
    /// Raises
    /// ------
    /// RolloutError, with the states so far as its trajectory. Ctrl-C ends the rollout before its next step, or during an
    /// implicit one.
    #[pyo3(signature = (*, progress=None))]
    fn recorded(
        &mut self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Trajectory> {
        let progress = Progress::of(py, progress, self.plan.steps())?;
        let shared = self.begun();
        let mut states = vec![self.steps.state().clone()];
        let result = run(py, &shared, progress.as_ref(), || {
            self.record(&mut states, &shared)
        })?;
        let trajectory = dynamics::Trajectory::new(states).map_err(crate::errors::refused)?;
        match result {
            Ok(()) => Ok(trajectory.into()),
            Err(why) => Err(interrupted(py, &why, trajectory)),
        }
    }

    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __next__(&mut self, py: Python<'_>) -> PyResult<Option<State>> {
        if self.taken >= self.plan.steps() {
            return Ok(None);
        }
        self.next_step(py)?;
        Ok(Some(self.state()))
    }

    #[allow(clippy::unused_self, reason = "a method, to pickle")]
    fn __reduce__(&self) -> PyResult<()> {
        Err(PyTypeError::new_err(
            "a Rollout cannot be pickled or copied: what its implicit steps remember of earlier ones stays in this process. The \
             world, the plan and rollout.state can, and world.rollout(plan, start=state) goes on from there",
        ))
    }

    fn __repr__(&self) -> String {
        let (taken, plan) = (self.taken, Plan(self.plan).__repr__());
        format!("Rollout({taken} of {} steps, {plan})", self.plan.steps())
    }
}
