use super::error::check_outcome;
use super::slots::Slots;
use super::values::{perturbed, with_values};
use super::widths::{DifferentiableOutcome, DifferentiableWorld, OutcomeIn, WIDE};
use super::{GradientError, Mode, Outcome, Parameter};
use crate::dynamics::{Body, DynWorld, Force, Model, Plan, Rollout, RolloutResult, World};
use crate::parallel::contained;
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};

/// Memory (bytes) for the steps that a sweep back goes over, unless [`Experiment::with_memory`] sets another.
const MEMORY: usize = 256 << 20;

/// A world rolled out for a number of steps, to be differentiated.
///
/// A rollout that ends early has no outcome. The error says when and why; [`Self::trajectory`] gives
/// the states before. A panic in a function that was passed in (a force, a path, an
/// outcome) is such an error too.
#[derive(Clone)]
pub struct Experiment {
    world: Arc<dyn DifferentiableWorld>,
    plan: Plan,
    stop: Arc<AtomicBool>,
    count: Arc<AtomicUsize>,
    /// Memory (bytes) for the steps that a sweep back goes over.
    memory: usize,
}

/// What an outcome is, and its derivatives.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OutcomeJacobian {
    /// The outcome.
    pub value: DVector<f64>,
    /// Its derivatives: a row for each number of the outcome, a column for each number of the
    /// parameters, in the order given.
    pub jacobian: DMatrix<f64>,
}

impl Experiment {
    /// Rollouts of a world, which may be shared, from its initial state, by a plan.
    #[must_use]
    pub fn new<F: Force>(world: impl Into<Arc<World<f64, F>>>, plan: &Plan) -> Self {
        let world: Arc<World<f64, F>> = world.into();
        Self {
            world,
            plan: *plan,
            stop: Arc::default(),
            count: Arc::default(),
            memory: MEMORY,
        }
    }

    /// Ends the rollouts of the experiment with [`RolloutError::Stopped`](crate::dynamics::RolloutError::Stopped) once the flag is
    /// true: before their next step, or during an implicit step. Another thread or a signal handler can set the flag.
    #[must_use]
    pub fn with_cancel_flag(self, flag: Arc<AtomicBool>) -> Self {
        Self { stop: flag, ..self }
    }

    /// The same experiment, whose rollouts add 1 to a number for each step taken: for another thread to read.
    /// [`Self::step_count_for`] tells how many there will be. Steps taken back, or taken again on the way back, are not counted.
    #[must_use]
    pub fn with_step_counter(self, count: Arc<AtomicUsize>) -> Self {
        Self { count, ..self }
    }

    /// The same experiment, whose sweeps back keep as many steps of the rollout as go into about this memory (bytes; 256 MiB
    /// unless set), and at least sixteen. Values and derivatives have the same bits with any memory.
    ///
    /// A step takes 144 bytes a body, an implicit one about 500, or more where it was divided. If s of l steps are kept, none
    /// is taken again more than r times, where r is the least number with (s + r + 1)! / (s! (r + 1)!) ≥ l: for
    /// s ≥ √(2l) once, which is a further rollout at most; for 27 of a million steps five times.
    #[must_use]
    pub fn with_memory(self, memory: usize) -> Self {
        Self { memory, ..self }
    }

    /// Memory (bytes) for the steps that a sweep back goes over.
    pub(super) fn memory(&self) -> usize {
        self.memory
    }

    /// How many steps a Jacobian by so many `numbers` of the parameters takes: those of the plan, once for every 96 numbers. A
    /// value, and a gradient that is swept back, take those of the plan, as by 0 numbers.
    #[must_use]
    pub fn step_count_for(&self, numbers: usize) -> usize {
        self.plan.steps() * numbers.div_ceil(WIDE).max(1)
    }

    /// The same experiment by another plan.
    pub(super) fn with_plan(&self, plan: Plan) -> Self {
        Self {
            plan,
            ..self.clone()
        }
    }

    /// Stop flag of the experiment.
    pub(super) fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// The rollout of the world, or of one that was made of it.
    pub(super) fn rollout_of<T: Scalar>(&self, world: Arc<dyn DynWorld<T>>) -> Rollout<T> {
        let rollout = Rollout::of(world, &self.plan).with_cancel_flag(self.stop());
        rollout.with_step_counter(Arc::clone(&self.count))
    }

    /// All of the world but its forces.
    pub(super) fn system(&self) -> &Model {
        self.world.model()
    }

    /// The world.
    pub(super) fn world(&self) -> &dyn DifferentiableWorld {
        &*self.world
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The recorded states.
    ///
    /// # Errors
    /// If the rollout ends early; the error holds the trajectory up to there.
    pub fn trajectory(&self) -> RolloutResult {
        self.rollout_of(self.world.clone()).run()
    }

    /// The outcome without derivatives.
    ///
    /// # Errors
    /// If the rollout ends early, or a number of the outcome is not finite.
    pub fn value(&self, outcome: &impl Outcome) -> Result<Vec<f64>, GradientError> {
        let value = self.value_of(outcome)?;
        check_outcome(&value)?;
        Ok(value)
    }

    /// The outcome in the world itself. Not generic, so that it is compiled in this library.
    pub(super) fn value_of(
        &self,
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(self.world.clone(), outcome)
    }

    /// The outcome and its derivatives by the parameters: forward mode, all in one rollout on dual
    /// numbers if they are no more than 96 numbers, else 96 at a time.
    ///
    /// # Errors
    /// - If a parameter is not one of the world's, or the rollout ends early.
    /// - [`GradientError::OutcomeNotFinite`] if a number of the outcome is not finite.
    /// - If a derivative of the outcome is not finite. The error tells by which number of the parameters,
    ///   and the first step that led to a state with such a derivative, or that the outcome itself has
    ///   lost it; it holds the value and the other derivatives. To find the step takes the rollout's time
    ///   once more.
    /// - If two bodies that may touch both have the friction 0, and both frictions are among the
    ///   parameters: [`GradientError::NoFriction`].
    /// - If the outcome has another length in another of the rollouts.
    pub fn jacobian(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Result<OutcomeJacobian, GradientError> {
        self.jacobian_of(parameters, outcome)
    }

    /// Not generic, so that it is compiled in this library.
    pub(super) fn jacobian_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<OutcomeJacobian, GradientError> {
        let (found, breakdown) = self.differentiated(parameters, outcome)?;
        check_outcome(found.value.as_slice())?;
        match breakdown {
            None => Ok(found),
            Some(breakdown) => Err(breakdown.into_error(self.system(), parameters, found)),
        }
    }

    /// A loss and its gradient, by the faster mode: see [`Self::mode_for`].
    ///
    /// # Errors
    /// As [`Self::gradient_with_mode`].
    pub fn gradient(
        &self,
        parameters: &[Parameter],
        loss: &impl Outcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        self.gradient_with_mode(self.mode_for(parameters), parameters, loss)
    }

    /// A loss and its gradient.
    ///
    /// # Errors
    /// As [`Self::jacobian`], and if the outcome is not one number. Backwards, derivatives that are not finite are told by
    /// [`GradientError::BackwardNotFinite`].
    pub fn gradient_with_mode(
        &self,
        mode: Mode,
        parameters: &[Parameter],
        loss: &impl Outcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        let OutcomeJacobian { value, jacobian } = match mode {
            Mode::Forward => self.jacobian(parameters, loss)?,
            Mode::Reverse => return self.swept_back(parameters, loss),
        };
        if value.len() != 1 {
            return Err(GradientError::NotALoss { count: value.len() });
        }
        Ok((value[0], jacobian.row(0).transpose()))
    }

    /// The outcome at other values of the parameters, which are in the order of [`World::values`].
    ///
    /// # Errors
    /// As [`World::with_values`], and as [`Self::value`].
    pub fn value_at(
        &self,
        parameters: &[Parameter],
        values: &[f64],
        outcome: &impl Outcome,
    ) -> Result<Vec<f64>, GradientError> {
        let system = with_values(self.system(), parameters, values)?;
        let value = self.value_in(system, outcome)?;
        check_outcome(&value)?;
        Ok(value)
    }

    /// The outcome after changes of the parameters, as in [`World::perturbed`].
    ///
    /// # Errors
    /// As [`World::perturbed`], and as [`Self::value`].
    pub fn value_perturbed(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
        outcome: &impl Outcome,
    ) -> Result<Vec<f64>, GradientError> {
        let system = perturbed(self.system(), parameters, changes)?;
        let value = self.value_in(system, outcome)?;
        check_outcome(&value)?;
        Ok(value)
    }

    /// The outcome beside the world's own parameters, where a material's number may have left its range by a difference's step, but no
    /// mass.
    pub(super) fn value_beside(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Vec<f64>, GradientError> {
        let slots = Slots::resolve(parameters, self.system())?;
        let system = slots.perturbed(self.system(), changes);
        system.bodies.iter().try_for_each(Body::check_mass)?;
        self.value_in(system, outcome)
    }

    /// The outcome in another system. Not generic, so that it is compiled in this library.
    fn value_in(
        &self,
        system: Model,
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(self.world.with_model(system), outcome)
    }

    /// For each number of the parameters, a typical change.
    pub(super) fn scales(&self, parameters: &[Parameter]) -> Result<Vec<f64>, GradientError> {
        let slots = Slots::resolve(parameters, self.system())?;
        Ok(slots.scales(self.system()))
    }

    /// The outcome of a rollout of the world, or of one that was made of it.
    pub(super) fn outcome_of<T: Scalar>(
        &self,
        world: Arc<dyn DynWorld<T>>,
        outcome: &dyn OutcomeIn<T>,
    ) -> Result<Vec<T>, GradientError> {
        let trajectory = self.rollout_of(world).run()?;
        contained(|| Ok(outcome.of_trajectory(&trajectory)))
    }
}

impl fmt::Debug for Experiment {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Experiment")
            .field("plan", &self.plan)
            .finish_non_exhaustive()
    }
}
