use super::{
    ExternalForces, Gravity, Integrator, Interrupted, RolloutError, State, Trajectory, World,
    WorldError,
};
use crate::scalar::Scalar;

/// An endless iterator over the states that follow a world's initial state, one a time step.
///
/// Each item is the next state. A state that is not finite is given as an error, and after it
/// nothing.
#[derive(Debug)]
pub struct Rollout<'w, T = f64, F = Gravity> {
    world: &'w World<T, F>,
    state: State<T>,
    /// Time (s) of the state that steps are counted from.
    start: f64,
    time_step: f64,
    integrator: Integrator,
    /// Steps taken since then.
    steps: usize,
    has_failed: bool,
}

impl<'w, T: Scalar, F: ExternalForces> Rollout<'w, T, F> {
    pub(super) fn new(world: &'w World<T, F>, time_step: f64, integrator: Integrator) -> Self {
        Self {
            world,
            state: world.initial_state(),
            start: 0.0,
            time_step,
            integrator,
            steps: 0,
            has_failed: false,
        }
    }

    /// The same rollout from another state of the world.
    ///
    /// # Errors
    /// If the state has another number of bodies.
    pub fn starting_from(mut self, state: State<T>) -> Result<Self, WorldError> {
        let (found, expected) = (state.bodies.len(), self.world.bodies().len());
        if found != expected {
            return Err(WorldError::StateSize { found, expected });
        }
        self.start = state.time;
        self.state = state;
        self.steps = 0;
        self.has_failed = false;
        Ok(self)
    }

    /// The state last given, or the initial one.
    #[must_use]
    pub fn state(&self) -> &State<T> {
        &self.state
    }

    /// Takes a number of steps and keeps the initial state and every `every`th after it.
    ///
    /// # Errors
    /// If a state is not finite; the error holds the trajectory up to there.
    pub fn recorded(mut self, steps: usize, every: usize) -> Result<Trajectory<T>, Interrupted<T>> {
        let mut trajectory = Trajectory::starting_with(self.state.clone());
        for step in 1..=steps {
            match self.advanced() {
                Ok(()) if step % every.max(1) == 0 => trajectory.push(self.state.clone()),
                Ok(()) => {}
                Err(error) => return Err(Interrupted { error, trajectory }),
            }
        }
        Ok(trajectory)
    }

    /// Takes a step.
    fn advanced(&mut self) -> Result<(), RolloutError> {
        let mut next = self
            .integrator
            .step(self.world, &self.state, self.time_step);
        let step = self.steps + 1;
        // From the count of steps: a sum of 10⁶ time steps would have drifted.
        next.time = self.start + step as f64 * self.time_step;
        if let Some(index) = next.bodies.iter().position(|body| !body.is_finite()) {
            self.has_failed = true;
            return Err(RolloutError::NotFinite {
                step,
                time: next.time,
                body: self.world.bodies()[index].name().to_owned(),
            });
        }
        self.state = next;
        self.steps = step;
        Ok(())
    }
}

impl<T: Scalar, F: ExternalForces> Iterator for Rollout<'_, T, F> {
    type Item = Result<State<T>, RolloutError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_failed {
            return None;
        }
        Some(self.advanced().map(|()| self.state.clone()))
    }
}
