use super::validate::{check_finite, check_positive};
use super::{Accuracy, Integrator, WorldError};

/// Default solver tolerance. The error is much smaller, because the last correction is applied.
pub(super) const SOLVER_TOLERANCE: f64 = 1e-10;

/// Number of steps of a converged plan for each step of the plan, for implicit and for explicit
/// steps.
const SHORTER: [usize; 2] = [4, 8];

/// Settings of a [`Rollout`](super::Rollout), a [`Batch`](super::Batch) or an [`Experiment`](crate::gradient::Experiment): integrator, time
/// step, number of steps, recorded states and tolerances.
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
    checks_stability: bool,
    solver_tolerance: f64,
    accuracy: Accuracy,
}

impl Plan {
    /// Plan of `steps` leapfrog steps of `time_step` (s). Every state is recorded.
    ///
    /// # Errors
    /// If the time step is not positive and finite, or the duration of all steps is not finite.
    pub fn new(time_step: f64, steps: usize) -> Result<Self, WorldError> {
        check_positive("time step", time_step)?;
        check_finite("duration of a plan", &[time_step * steps as f64])?;
        Ok(Self {
            time_step,
            steps,
            integrator: Integrator::default(),
            record_every: 1,
            checks_stability: true,
            solver_tolerance: SOLVER_TOLERANCE,
            accuracy: Accuracy::default(),
        })
    }

    /// Sets the number of steps.
    #[must_use]
    pub fn with_steps(self, steps: usize) -> Self {
        Self { steps, ..self }
    }

    /// Sets the integrator.
    #[must_use]
    pub fn with_integrator(self, integrator: Integrator) -> Self {
        Self { integrator, ..self }
    }

    /// Records the initial state, every `every`th state after it, and the last state. Zero records only the initial and the last state, as
    /// [`Self::recording_ends`] does. Outcomes are computed from recorded states only.
    #[must_use]
    pub fn recording_every(self, every: usize) -> Self {
        let record_every = if every == 0 { usize::MAX } else { every };
        Self {
            record_every,
            ..self
        }
    }

    /// Records only the initial and the last state.
    #[must_use]
    pub fn recording_ends(self) -> Self {
        self.recording_every(0)
    }

    /// Turns off the stability check of explicit steps.
    ///
    /// By default, explicit steps are checked if contact begins or changes fast. If a check fails, the rollout ends at the last good state
    /// with one of two errors:
    ///
    /// - [`RolloutError::TimeStepTooLong`](super::RolloutError::TimeStepTooLong) if the time step exceeds
    ///   [`World::largest_stable_step`](super::World::largest_stable_step) at the poses where the contacts act. Friction is omitted,
    ///   because the chatter of bodies at rest is bounded.
    /// - [`RolloutError::EnergyGained`](super::RolloutError::EnergyGained) if a contact returns
    ///   more than twice the energy that it has absorbed, in this step or over many steps.
    ///
    /// The check does not change states. Below half of the limit it costs less than a step. Above half of the limit, each step in
    /// contact is linearized.
    #[must_use]
    pub fn without_stability_check(self) -> Self {
        Self {
            checks_stability: false,
            ..self
        }
    }

    /// Sets the tolerance of implicit steps (default 1e-10). A stage is solved when a correction is below this fraction of the current
    /// velocities. The last correction is applied, so the remaining error is much smaller. With a looser tolerance, derivatives lose digits
    /// before values do.
    ///
    /// # Errors
    /// If the tolerance is not positive and finite.
    pub fn with_solver_tolerance(self, tolerance: f64) -> Result<Self, WorldError> {
        check_positive("solver tolerance", tolerance)?;
        Ok(Self {
            solver_tolerance: tolerance,
            ..self
        })
    }

    /// Sets the accuracy of implicit steps with error control. The time step is then the longest substep and the shortest interval between
    /// recorded states.
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    /// Accuracy of implicit steps with error control.
    #[must_use]
    pub fn accuracy(&self) -> Accuracy {
        self.accuracy
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

    /// Duration (s) of all steps.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.steps as f64 * self.time_step
    }

    /// Integrator.
    #[must_use]
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// Number of steps from one recorded state to the next, or [`usize::MAX`] if only the ends are recorded.
    #[must_use]
    pub fn record_every(&self) -> usize {
        self.record_every
    }

    /// Whether the stability of explicit steps is checked.
    #[must_use]
    pub fn checks_stability(&self) -> bool {
        self.checks_stability
    }

    /// Plan for converged outcomes: shorter steps, and `Sdirk3` with tight tolerances if the integrator is implicit.
    pub(crate) fn converged(&self) -> Self {
        let [implicit, explicit] = SHORTER;
        if !self.integrator.is_implicit() {
            return self.divided(explicit);
        }
        let tight = self.with_accuracy(self.accuracy.tight());
        tight.with_integrator(Integrator::Sdirk3).divided(implicit)
    }

    /// Plan that is finer than a converged plan.
    pub(crate) fn finer(&self) -> Self {
        if self.integrator.is_implicit() {
            self.with_accuracy(self.accuracy.tenth())
        } else {
            self.divided(2)
        }
    }

    /// Divides each step into `parts` steps. States are recorded at the same times.
    fn divided(&self, parts: usize) -> Self {
        Self {
            time_step: self.time_step / parts as f64,
            steps: self.steps.saturating_mul(parts),
            record_every: self.record_every.saturating_mul(parts),
            ..*self
        }
    }

    /// Whether the state after `step` steps is recorded.
    pub(crate) fn records(&self, step: usize) -> bool {
        step.is_multiple_of(self.record_every) || step == self.steps
    }
}
