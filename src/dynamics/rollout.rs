use super::dyn_world::DynWorld;
use super::steps::Stepper;
use super::{
    Force, Plan, RolloutError, RolloutFailure, RolloutResult, State, StepReport, Trajectory, World,
    WorldError,
};
use crate::parallel::contained;
use crate::scalar::Scalar;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// An endless iterator over the states that follow a world's initial state, one a time step; [`Self::run`] takes the
/// steps that were planned.
///
/// Each item is the next state. The iterator returns an error and ends if a state is not finite, an explicit step fails the
/// [stability check](Plan::without_stability_check), or an implicit step is not solved.
///
/// A panic in a function that was passed in (a force, a path) passes through the iterator and
/// through [`Self::advance`]. Whoever catches it finds the last good state in [`Self::state`], and
/// may go on: the step is taken again. [`Self::run`] makes an error of it.
#[derive(Clone)]
pub struct Rollout<T = f64> {
    world: Arc<dyn DynWorld<T>>,
    plan: Plan,
    steps: Stepper<T>,
    count: Option<Arc<AtomicUsize>>,
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Steps from the initial state, by a plan.
    #[must_use]
    pub fn rollout(&self, plan: &Plan) -> Rollout<T> {
        Rollout::new(self, plan)
    }

    /// The state one time step after another one, by the time step, the integrator and the stability check of a plan.
    /// [`Rollout::advance`] takes many steps without allocating, at times that are multiples of the time step. Its stability check is
    /// cheaper too, because it compares each step with the previous step.
    ///
    /// # Errors
    /// If the state does not fit the world (see [`Rollout::with_state`]), or the next one is not finite or fails the
    /// stability check.
    pub fn step(&self, state: &State<T>, plan: &Plan) -> Result<State<T>, RolloutError> {
        state.check_fits(self.bodies())?;
        let mut steps = Stepper::from(self.model.with_prescribed_states(state.clone()));
        steps.advance(self, plan)?;
        Ok(steps.state)
    }
}

impl<T: Scalar> Rollout<T> {
    /// Steps of a world, which may be shared, from its initial state.
    #[must_use]
    pub fn new<F: Force>(world: impl Into<Arc<World<T, F>>>, plan: &Plan) -> Self {
        Self::of(world.into(), plan)
    }

    /// The same of a world whatever its forces.
    pub(crate) fn of(world: Arc<dyn DynWorld<T>>, plan: &Plan) -> Self {
        let steps = Stepper::from(world.model().initial_state());
        Self {
            world,
            plan: *plan,
            steps,
            count: None,
        }
    }

    /// The same rollout from another state of the world. Bodies that forces do not move are where they belong.
    ///
    /// # Errors
    /// If the state has another number of bodies, a pose that is not rigid, or a number that is not finite.
    pub fn with_state(self, state: State<T>) -> Result<Self, WorldError> {
        state.check_fits(&self.world.model().bodies)?;
        let steps = Stepper::from(self.world.model().with_prescribed_states(state));
        let steps = steps.with_cancel_flag(self.steps.stop);
        Ok(Self { steps, ..self })
    }

    /// Ends the rollout with [`RolloutError::Stopped`] once the flag is true: before its next step, or during an implicit step.
    /// Another thread or a signal handler can set the flag. [`Self::state`] stays the state before the step.
    #[must_use]
    pub fn with_cancel_flag(self, flag: Arc<AtomicBool>) -> Self {
        let steps = self.steps.with_cancel_flag(flag);
        Self { steps, ..self }
    }

    /// The same rollout, of which [`Self::run`] adds 1 to a number for each step taken: for another thread to read, that
    /// shows how far the rollout has come.
    #[must_use]
    pub fn with_step_counter(self, count: Arc<AtomicUsize>) -> Self {
        let count = Some(count);
        Self { count, ..self }
    }

    /// The state last given, or the initial one.
    #[must_use]
    pub fn state(&self) -> &State<T> {
        &self.steps.state
    }

    /// What the last implicit step took, rejected substeps included; none before it, or if steps are explicit.
    #[must_use]
    pub fn step_report(&self) -> Option<&StepReport> {
        self.steps
            .integrator_state
            .as_ref()
            .map(|integrator_state| &integrator_state.report)
    }

    /// Takes the planned number of steps and keeps the states that are to be recorded.
    ///
    /// # Errors
    /// If a state is not finite or fails the stability check, a force or a path panics, or the rollout is
    /// [stopped](Self::with_cancel_flag); the error holds the trajectory up to there.
    pub fn run(self) -> RolloutResult<T> {
        self.run_with_observer(|_, _| {})
    }

    /// The same, showing how far it has come before and after every step, with the number of steps taken.
    pub(crate) fn run_with_observer(
        mut self,
        mut show: impl FnMut(usize, &Stepper<T>),
    ) -> RolloutResult<T> {
        let mut trajectory = Trajectory::starting_with(self.state().clone());
        show(0, &self.steps);
        match contained(|| self.record(&mut trajectory, show)) {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(RolloutFailure { error, trajectory }),
        }
    }

    fn record(
        &mut self,
        trajectory: &mut Trajectory<T>,
        mut show: impl FnMut(usize, &Stepper<T>),
    ) -> Result<(), RolloutError> {
        for step in 1..=self.plan.steps() {
            self.steps.advance(&*self.world, &self.plan)?;
            show(step, &self.steps);
            if self.plan.records(step) {
                trajectory.push(self.steps.state.clone());
            }
            if let Some(count) = &self.count {
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    /// Takes a step and shows the state it led to: [`Iterator::next`] without a copy. Explicit
    /// steps allocate nothing once the buffers are large enough, with two exceptions: the stability check linearizes contacts, and
    /// many contacts, or a large one, are computed by several threads. Implicit steps allocate, because the size of their matrices
    /// depends on which bodies touch.
    ///
    /// # Errors
    /// If the state is not finite, the step fails the stability check, or the rollout is [stopped](Self::with_cancel_flag).
    /// [`Self::state`] then stays the state before the step.
    pub fn advance(&mut self) -> Result<&State<T>, RolloutError> {
        self.steps.advance(&*self.world, &self.plan)
    }
}

impl<T: fmt::Debug> fmt::Debug for Rollout<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Rollout")
            .field("plan", &self.plan)
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl<T: Scalar> Iterator for Rollout<T> {
    type Item = Result<State<T>, RolloutError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.steps.has_failed {
            return None;
        }
        Some(self.advance().cloned())
    }

    /// Without copies of the states that are passed over. An error among these ends the iteration;
    /// [`Self::run`] tells of it.
    fn nth(&mut self, count: usize) -> Option<Self::Item> {
        for _ in 0..count {
            if self.steps.has_failed || self.advance().is_err() {
                return None;
            }
        }
        self.next()
    }
}
