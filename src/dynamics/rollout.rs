use super::dyn_world::DynWorld;
use super::stepper::Stepper;
use super::{
    Force, Plan, RolloutError, RolloutFailure, RolloutResult, State, StepReport, Trajectory, World,
    WorldError,
};
use crate::parallel::contained;
use crate::scalar::Scalar;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Endless iterator over the states that follow the initial state of a world, one for each time step. [`Self::run`] takes only the planned
/// steps.
///
/// Each item is the next state. The iterator returns an error and ends if a state is not finite, an explicit step fails the
/// [stability check](Plan::without_stability_check), or an implicit step is not solved.
///
/// A panic in a user function (a force or a path) passes through the iterator and through [`Self::advance`]. A caller that catches the
/// panic finds the last good state in [`Self::state`], and can continue: the step is taken again. [`Self::run`] returns a panic as an
/// error.
#[derive(Clone)]
pub struct Rollout<T = f64> {
    world: Arc<dyn DynWorld<T>>,
    plan: Plan,
    stepper: Stepper<T>,
    count: Option<Arc<AtomicUsize>>,
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Rollout of a plan from the initial state.
    #[must_use]
    pub fn rollout(&self, plan: &Plan) -> Rollout<T> {
        Rollout::new(self, plan)
    }

    /// Advances a state by one time step of a plan, with the integrator and the stability check of
    /// the plan. [`Rollout::advance`] takes many steps without allocation, at times that are
    /// multiples of the time step. Its stability check is also cheaper, because it compares each
    /// step with the previous step.
    ///
    /// # Errors
    /// - If the state does not fit the world (see [`Rollout::with_state`]).
    /// - If the next state is not finite or fails the stability check.
    pub fn step(&self, state: &State<T>, plan: &Plan) -> Result<State<T>, RolloutError> {
        state.check_fits(self.bodies())?;
        let state = self.model.with_prescribed_states(state.clone());
        self.model.check_later_loops(&state)?;
        let mut stepper = Stepper::from(state);
        stepper.advance(self, plan)?;
        Ok(stepper.state)
    }
}

impl<T: Scalar> Rollout<T> {
    /// Rollout of a world from its initial state. The world may be shared.
    #[must_use]
    pub fn new<F: Force>(world: impl Into<Arc<World<T, F>>>, plan: &Plan) -> Self {
        Self::of(world.into(), plan)
    }

    /// Rollout of a type-erased world.
    pub(crate) fn of(world: Arc<dyn DynWorld<T>>, plan: &Plan) -> Self {
        let stepper = Stepper::from(world.model().initial_state());
        Self {
            world,
            plan: *plan,
            stepper,
            count: None,
        }
    }

    /// Sets the state from which the rollout starts. Fixed and kinematic bodies keep their prescribed states.
    ///
    /// # Errors
    /// If the state has another number of bodies, a pose that is not rigid, or a number that is not finite, or if a loop joint is open by more than 0.05 m or 0.05 rad.
    pub fn with_state(self, state: State<T>) -> Result<Self, WorldError> {
        let model = self.world.model();
        state.check_fits(&model.bodies)?;
        let state = model.with_prescribed_states(state);
        model.check_later_loops(&state)?;
        let stepper = Stepper::from(state);
        let stepper = stepper.with_cancel_flag(self.stepper.stop);
        Ok(Self { stepper, ..self })
    }

    /// Ends the rollout with [`RolloutError::Stopped`] once the flag is true: before its next step, or during an implicit step.
    /// Another thread or a signal handler can set the flag. [`Self::state`] stays the state before the step.
    #[must_use]
    pub fn with_cancel_flag(self, flag: Arc<AtomicBool>) -> Self {
        let stepper = self.stepper.with_cancel_flag(flag);
        Self { stepper, ..self }
    }

    /// Sets a counter to which [`Self::run`] adds 1 for each step. Another thread can read it to observe the progress.
    #[must_use]
    pub fn with_step_counter(self, count: Arc<AtomicUsize>) -> Self {
        let count = Some(count);
        Self { count, ..self }
    }

    /// Last returned state, or the initial state.
    #[must_use]
    pub fn state(&self) -> &State<T> {
        &self.stepper.state
    }

    /// Report of the last implicit step, including rejected substeps. `None` before the first step and for explicit steps.
    #[must_use]
    pub fn step_report(&self) -> Option<&StepReport> {
        self.stepper
            .integrator_state
            .as_ref()
            .map(|integrator_state| &integrator_state.report)
    }

    /// Takes the planned number of steps and returns the recorded states.
    ///
    /// # Errors
    /// The error contains the trajectory up to the last good state.
    ///
    /// - If a state is not finite or fails the stability check.
    /// - If an implicit step is not solved.
    /// - If a force or a path panics.
    /// - If the rollout is [stopped](Self::with_cancel_flag).
    pub fn run(self) -> RolloutResult<T> {
        self.run_with_observer(|_, _| {})
    }

    /// [`Self::run`] with an observer, which is called before the first step and after every step with the number of steps taken.
    pub(crate) fn run_with_observer(
        mut self,
        mut observe: impl FnMut(usize, &Stepper<T>),
    ) -> RolloutResult<T> {
        let mut trajectory = Trajectory::starting_with(self.state().clone());
        observe(0, &self.stepper);
        match contained(|| self.record(&mut trajectory, observe)) {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(RolloutFailure { error, trajectory }),
        }
    }

    fn record(
        &mut self,
        trajectory: &mut Trajectory<T>,
        mut observe: impl FnMut(usize, &Stepper<T>),
    ) -> Result<(), RolloutError> {
        for step in 1..=self.plan.steps() {
            self.stepper.advance(&*self.world, &self.plan)?;
            observe(step, &self.stepper);
            if self.plan.records(step) {
                trajectory.push(self.stepper.state.clone());
            }
            if let Some(count) = &self.count {
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    /// Takes a step and returns the next state: [`Iterator::next`] without a copy.
    ///
    /// Explicit steps allocate nothing once the buffers are large enough, with two exceptions. The stability check linearizes contacts.
    /// Many contacts, or a large contact, are computed by several threads. Implicit steps allocate, because the size of their matrices
    /// depends on which bodies touch.
    ///
    /// # Errors
    /// [`Self::state`] then stays the state before the step.
    ///
    /// - If the next state is not finite or fails the stability check.
    /// - If an implicit step is not solved.
    /// - If the rollout is [stopped](Self::with_cancel_flag).
    pub fn advance(&mut self) -> Result<&State<T>, RolloutError> {
        self.stepper.advance(&*self.world, &self.plan)
    }
}

impl<T: fmt::Debug> fmt::Debug for Rollout<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Rollout")
            .field("plan", &self.plan)
            .field("steps", &self.stepper)
            .finish_non_exhaustive()
    }
}

impl<T: Scalar> Iterator for Rollout<T> {
    type Item = Result<State<T>, RolloutError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.stepper.has_failed {
            return None;
        }
        Some(self.advance().cloned())
    }

    /// Skips states without copying them. An error in a skipped state ends the iteration.
    /// [`Self::run`] returns this error.
    fn nth(&mut self, count: usize) -> Option<Self::Item> {
        for _ in 0..count {
            if self.stepper.has_failed || self.advance().is_err() {
                return None;
            }
        }
        self.next()
    }
}
