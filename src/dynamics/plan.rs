use super::validate::{check_finite, check_positive};
use super::{Accuracy, Integrator, WorldError};

/// Solver tolerance of a new plan: the last correction, which is applied, leaves far less.
pub(super) const SOLVER_TOLERANCE: f64 = 1e-10;

/// Number of steps of a converged plan for each step of the plan, of implicit and of explicit ones.
const SHORTER: [usize; 2] = [4, 8];

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
    checks_stability: bool,
    solver_tolerance: f64,
    accuracy: Accuracy,
}

impl Plan {
    /// A number of leapfrog steps of `time_step` (s), with every state recorded.
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

    /// The same plan, recording the initial state, every `every`th state after it, and the last state. Zero records the initial and
    /// the last state alone, as [`Self::recording_ends`]. Outcomes see no other states.
    #[must_use]
    pub fn recording_every(self, every: usize) -> Self {
        let record_every = if every == 0 { usize::MAX } else { every };
        Self {
            record_every,
            ..self
        }
    }

    /// The same plan, recording the initial and the last state alone.
    #[must_use]
    pub fn recording_ends(self) -> Self {
        self.recording_every(0)
    }

    /// Turns off the stability check of explicit steps.
    ///
    /// By default, explicit steps are checked where contact begins or changes fast. If a check fails, the rollout ends at the last
    /// good state with one of two errors:
    ///
    /// - [`RolloutError::TimeStepTooLong`](super::RolloutError::TimeStepTooLong) if the time step exceeds
    ///   [`World::largest_stable_step`](super::World::largest_stable_step) at the poses where the contacts act. Friction is left
    ///   out, because the chatter of bodies at rest is bounded.
    /// - [`RolloutError::EnergyGained`](super::RolloutError::EnergyGained) if a contact returns more than twice the energy that
    ///   it has absorbed, in this step or over many.
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

    /// The same plan with another accuracy of implicit steps with error control. The time step is then the longest substep, and
    /// the shortest interval between recorded states.
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

    /// Number of steps from one recorded state to the next, or [`usize::MAX`] if only the ends are recorded.
    #[must_use]
    pub fn record_every(&self) -> usize {
        self.record_every
    }

    /// Whether explicit steps are checked.
    #[must_use]
    pub fn checks_stability(&self) -> bool {
        self.checks_stability
    }

    /// The plan whose outcomes serve as those of the motion: shorter steps, and for implicit ones `Sdirk3` at tight tolerances.
    pub(crate) fn converged(&self) -> Self {
        let [implicit, explicit] = SHORTER;
        if !self.integrator.is_implicit() {
            return self.divided(explicit);
        }
        let tight = self.with_accuracy(self.accuracy.tight());
        tight.with_integrator(Integrator::Sdirk3).divided(implicit)
    }

    /// A plan that is finer than a converged one.
    pub(crate) fn finer(&self) -> Self {
        if self.integrator.is_implicit() {
            self.with_accuracy(self.accuracy.tenth())
        } else {
            self.divided(2)
        }
    }

    /// Divides each step into so many. States are recorded at the same times.
    fn divided(&self, parts: usize) -> Self {
        Self {
            time_step: self.time_step / parts as f64,
            steps: self.steps.saturating_mul(parts),
            record_every: self.record_every.saturating_mul(parts),
            ..*self
        }
    }

    /// Whether the state after so many steps is recorded.
    pub(crate) fn records(&self, step: usize) -> bool {
        step.is_multiple_of(self.record_every) || step == self.steps
    }
}
