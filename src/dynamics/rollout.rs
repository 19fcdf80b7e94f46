use super::workspace::Workspace;
use super::{
    Body, ExternalForces, Gravity, Integrator, Interrupted, Motion, Recorded, RolloutError, State,
    Trajectory, World, WorldError,
};
use crate::scalar::Scalar;
use crate::threads::contained;
use std::mem;

/// An endless iterator over the states that follow a world's initial state, one a time step.
///
/// Each item is the next state. A state that is not finite, or a time step that fails a
/// [stability check](Self::with_stability_check), is given as an error, and after it nothing.
///
/// A panic in a function that was passed in (an external force, a path) passes through the iterator and
/// through [`Self::advance`]. Whoever catches it finds the last good state in [`Self::state`], and
/// may go on: the step is taken again. [`Self::recorded`] makes an error of it.
#[derive(Debug)]
pub struct Rollout<'w, T = f64, F = Gravity> {
    world: &'w World<T, F>,
    state: State<T>,
    /// The next state while it is computed; `state` stays until that one is known to be finite.
    next: State<T>,
    workspace: Workspace<T>,
    /// Time (s) of the state that steps are counted from.
    start: f64,
    time_step: f64,
    integrator: Integrator,
    /// Every how many steps the time step is held against the stability limit, if at all.
    check_every: Option<usize>,
    /// Steps taken since then.
    steps: usize,
    has_failed: bool,
}

impl<'w, T: Scalar, F: ExternalForces> Rollout<'w, T, F> {
    pub(crate) fn new(world: &'w World<T, F>, time_step: f64, integrator: Integrator) -> Self {
        let state = world.initial_state();
        Self {
            world,
            next: state.clone(),
            state,
            workspace: Workspace::default(),
            start: 0.0,
            time_step,
            integrator,
            check_every: None,
            steps: 0,
            has_failed: false,
        }
    }

    /// The same rollout, holding the time step against [`World::largest_stable_step`] in the first step and every
    /// `every`th after it, where the contacts act: by the leapfrog, in the middle of the step. Where it is longer, the rollout ends
    /// with [`RolloutError::TimeStepTooLong`], at a state that is still good. A fast impact happens within a step or two,
    /// which only a check of every step sees.
    ///
    /// A check takes the time of some steps, and allocates. As elsewhere, 0 counts as 1: every step.
    #[must_use]
    pub fn with_stability_check(self, every: usize) -> Self {
        self.checked_every(Some(every))
    }

    /// The same rollout with a stability check every so many steps, or none.
    pub(crate) fn checked_every(self, check_every: Option<usize>) -> Self {
        Self {
            check_every,
            ..self
        }
    }

    /// The same rollout from another state of the world. Bodies that forces do not move are where they belong
    /// from the first step on.
    ///
    /// # Errors
    /// If the state has another number of bodies, a pose that is not rigid, or a number that is not finite.
    pub fn starting_from(self, state: State<T>) -> Result<Self, WorldError> {
        state.check_fits(self.world)?;
        Ok(self.starting_from_fitting(state))
    }

    /// The same rollout from a state that fits the world.
    pub(super) fn starting_from_fitting(self, state: State<T>) -> Self {
        Self {
            start: state.time,
            state,
            steps: 0,
            has_failed: false,
            ..self
        }
    }

    /// The state last given, or the initial one.
    #[must_use]
    pub fn state(&self) -> &State<T> {
        &self.state
    }

    /// Takes a number of steps and keeps the initial state, every `every`th after it (0 counts as 1), and the last.
    ///
    /// # Errors
    /// If a state is not finite or fails the stability check, or an external force or a path panics; the
    /// error holds the trajectory up to there.
    pub fn recorded(mut self, steps: usize, every: usize) -> Recorded<T> {
        let mut trajectory = Trajectory::starting_with(self.state.clone());
        match contained(|| self.record(&mut trajectory, steps, every)) {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(Interrupted { error, trajectory }),
        }
    }

    /// Takes a number of steps and adds every `every`th state to a trajectory, and the last.
    fn record(
        &mut self,
        trajectory: &mut Trajectory<T>,
        steps: usize,
        every: usize,
    ) -> Result<(), RolloutError> {
        for step in 1..=steps {
            let state = self.advance()?;
            if step % every.max(1) == 0 || step == steps {
                trajectory.push(state.clone());
            }
        }
        Ok(())
    }

    /// Takes a step and shows the state it led to: [`Iterator::next`] without a copy. Steps allocate
    /// nothing once the rollout has the room it needs, unless their contacts are so many, or one is so
    /// large, that they are spread over threads.
    ///
    /// # Errors
    /// If the state is not finite, or the step fails the stability check; [`Self::state`] is then still the one before.
    pub fn advance(&mut self) -> Result<&State<T>, RolloutError> {
        let step = self.steps + 1;
        let (world, time_step) = (self.world, self.time_step);
        self.next.time = self.state.time;
        self.next.bodies.clone_from(&self.state.bodies);
        self.integrator.approach(world, &mut self.next, time_step);
        self.stop_at(self.lost_path(step))?;
        self.check_stability(step)?;
        let workspace = &mut self.workspace;
        self.integrator
            .complete(world, &mut self.next, time_step, workspace);
        // From the count of steps: a sum of 10⁶ time steps would have drifted.
        self.next.time = self.start + step as f64 * self.time_step;
        let lost = self.lost_path(step).or_else(|| self.lost_body(step));
        self.stop_at(lost)?;
        mem::swap(&mut self.state, &mut self.next);
        self.steps = step;
        Ok(&self.state)
    }

    /// Ends the rollout by an error, if there is one.
    fn stop_at(&mut self, error: Option<RolloutError>) -> Result<(), RolloutError> {
        self.has_failed |= error.is_some();
        error.map_or(Ok(()), Err)
    }

    /// An error, if a path is not finite at the time of the next state.
    fn lost_path(&self, step: usize) -> Option<RolloutError> {
        let (time, is_prescribed) = (self.next.time, |body: &Body<T>| {
            matches!(body.motion, Motion::Prescribed(_))
        });
        let body = self.lost(is_prescribed)?;
        Some(RolloutError::PathNotFinite { step, time, body })
    }

    /// An error, if the next state is not finite.
    fn lost_body(&self, step: usize) -> Option<RolloutError> {
        let (time, body) = (self.next.time, self.lost(|_| true)?);
        Some(RolloutError::NotFinite { step, time, body })
    }

    /// The name of the first of such bodies whose next state is not finite.
    fn lost(&self, is_such: impl Fn(&Body<T>) -> bool) -> Option<String> {
        let mut bodies = self.world.bodies().iter().zip(&self.next.bodies);
        let (body, _) = bodies.find(|(body, state)| is_such(body) && !state.is_finite())?;
        Some(body.name().to_owned())
    }

    /// Checks the time step where the kick acts, if a check is due in this step.
    fn check_stability(&mut self, step: usize) -> Result<(), RolloutError> {
        let is_due = |every: usize| (step - 1).is_multiple_of(every.max(1));
        if !self.check_every.is_some_and(is_due) {
            return Ok(());
        }
        let exceeded = self.world.exceeded_limit(&self.next.bodies, self.time_step);
        let Some((limit, bodies)) = exceeded else {
            return Ok(());
        };
        self.has_failed = true;
        Err(RolloutError::TimeStepTooLong {
            step,
            time: self.state.time,
            time_step: self.time_step,
            limit,
            bodies,
        })
    }
}

impl<T: Scalar, F: ExternalForces> Iterator for Rollout<'_, T, F> {
    type Item = Result<State<T>, RolloutError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_failed {
            return None;
        }
        Some(self.advance().cloned())
    }

    /// Without copies of the states that are passed over. An error among these ends the iteration;
    /// [`Self::recorded`] tells of it.
    fn nth(&mut self, count: usize) -> Option<Self::Item> {
        for _ in 0..count {
            if self.has_failed || self.advance().is_err() {
                return None;
            }
        }
        self.next()
    }
}
