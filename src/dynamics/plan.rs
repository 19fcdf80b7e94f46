use super::settings::check_positive;
use super::{Integrator, WorldError};

/// Solver tolerance of a new plan: the last correction, which is applied, leaves far less.
pub(super) const SOLVER_TOLERANCE: f64 = 1e-10;

/// How a world is stepped, and what is recorded of it: the settings of a [`Rollout`](super::Rollout), a
/// [`Batch`](super::Batch) or an [`Experiment`](crate::gradient::Experiment).
///
/// ```
/// use hydroelastic::dynamics::{Integrator, Plan};
///
/// let plan = Plan::new(1e-3, 500)?
///     .with_integrator(Integrator::SymplecticEuler)
///     .recording_every(10);
/// assert_eq!((plan.steps(), plan.duration()), (500, 0.5));
/// # Ok::<(), hydroelastic::dynamics::WorldError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    time_step: f64,
    steps: usize,
    integrator: Integrator,
    record_every: usize,
    check_every: Option<usize>,
    solver_tolerance: f64,
}

impl Plan {
    /// A number of leapfrog steps of `time_step` (s), with every state recorded.
    ///
    /// # Errors
    /// If the time step is not positive and finite.
    pub fn new(time_step: f64, steps: usize) -> Result<Self, WorldError> {
        check_positive("time step", time_step)?;
        Ok(Self {
            time_step,
            steps,
            integrator: Integrator::default(),
            record_every: 1,
            check_every: None,
            solver_tolerance: SOLVER_TOLERANCE,
        })
    }

    /// The same plan with another number of steps.
    #[must_use]
    pub fn with_steps(self, steps: usize) -> Self {
        Self { steps, ..self }
    }

    /// The same plan with another integrator.
    #[must_use]
    pub fn with_integrator(self, integrator: Integrator) -> Self {
        Self { integrator, ..self }
    }

    /// The same plan, recording the initial state, every `every`th after it (0 counts as 1), and the last. Outcomes see
    /// no other states.
    #[must_use]
    pub fn recording_every(self, every: usize) -> Self {
        Self {
            record_every: every.max(1),
            ..self
        }
    }

    /// The same plan, holding the time step against
    /// [`World::largest_stable_step`](super::World::largest_stable_step) in the first step and every `every`th after it
    /// (0 counts as 1), where the contacts act: by the leapfrog, in the middle of the step. Where it is longer, the rollout
    /// ends with [`RolloutError::TimeStepTooLong`](super::RolloutError::TimeStepTooLong), at a state that is still good. A
    /// fast impact happens within a step or two, which only a check of every step sees.
    ///
    /// A check takes the time of some steps, and allocates. Implicit steps need none, and are not checked.
    #[must_use]
    pub fn with_stability_check(self, every: usize) -> Self {
        Self {
            check_every: Some(every.max(1)),
            ..self
        }
    }

    /// The same plan with another tolerance of implicit steps: velocities are solved for until a correction is below this
    /// fraction of the velocities at hand (default 1e-10). The last correction is applied, so what is left is smaller by far;
    /// derivatives lose digits with a looser one before values do.
    ///
    /// # Errors
    /// If it is not positive and finite.
    pub fn with_solver_tolerance(self, tolerance: f64) -> Result<Self, WorldError> {
        check_positive("solver tolerance", tolerance)?;
        Ok(Self {
            solver_tolerance: tolerance,
            ..self
        })
    }

    /// Tolerance of implicit steps.
    #[must_use]
    pub fn solver_tolerance(&self) -> f64 {
        self.solver_tolerance
    }

    /// Time step (s).
    #[must_use]
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Time (s) of all steps.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.steps as f64 * self.time_step
    }

    /// The integrator.
    #[must_use]
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// After how many steps a state is recorded.
    #[must_use]
    pub fn record_every(&self) -> usize {
        self.record_every
    }

    /// After how many steps the time step is checked, if it is.
    #[must_use]
    pub fn check_every(&self) -> Option<usize> {
        self.check_every
    }

    /// Whether the state after so many steps is recorded.
    pub(crate) fn records(&self, step: usize) -> bool {
        step.is_multiple_of(self.record_every) || step == self.steps
    }

    /// Whether the time step is checked in a step, counted from 1.
    pub(super) fn checks(&self, step: usize) -> bool {
        let is_due = |every: usize| (step - 1).is_multiple_of(every);
        self.check_every.is_some_and(is_due)
    }
}
