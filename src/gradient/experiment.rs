use super::dual_widths::{DifferentiableOutcome, DifferentiableWorld, OutcomeIn, WIDE};
use super::error::{check_outcome, loss_of};
use super::slots::Slots;
use super::values::{perturbed, values, with_values};
use super::{GradientError, Mode, Outcome, OutcomeJacobian, Parameter};
use crate::dynamics::{
    Body, DynWorld, Force, Model, Plan, Rollout, RolloutResult, State, World, WorldError,
};
use crate::parallel::contained;
use crate::scalar::Scalar;
use nalgebra::DVector;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};

/// Default memory (bytes) of a reverse sweep for recorded steps. [`Experiment::with_memory`] changes it.
const DEFAULT_MEMORY: usize = 256 << 20;

/// A world and a plan, whose rollout can be differentiated.
///
/// A rollout that ends early has no outcome. The error holds the time and the cause, and [`Self::trajectory`] returns the states
/// before it. A panic in a user function (a force, a path or an outcome) also becomes an error.
#[derive(Clone)]
pub struct Experiment {
    world: Arc<dyn DifferentiableWorld>,
    plan: Plan,
    stop: Arc<AtomicBool>,
    count: Arc<AtomicUsize>,
    /// Memory (bytes) of a reverse sweep for recorded steps.
    memory: usize,
}

impl Experiment {
    /// Creates an experiment that rolls a world out from its initial state, with a plan. The world can be shared.
    #[must_use]
    pub fn new<F: Force>(world: impl Into<Arc<World<f64, F>>>, plan: &Plan) -> Self {
        let world: Arc<World<f64, F>> = world.into();
        Self {
            world,
            plan: *plan,
            stop: Arc::default(),
            count: Arc::default(),
            memory: DEFAULT_MEMORY,
        }
    }

    /// Ends the rollouts of the experiment with [`RolloutError::Stopped`](crate::dynamics::RolloutError::Stopped) once the flag is
    /// true: before their next step, or during an implicit step. Another thread or a signal handler can set the flag.
    #[must_use]
    pub fn with_cancel_flag(self, flag: Arc<AtomicBool>) -> Self {
        Self { stop: flag, ..self }
    }

    /// Adds 1 to a counter for each step of the rollouts. Another thread can read the counter. [`Self::step_count_for`] returns
    /// the final count. Backward steps and recomputed steps of a reverse sweep are not counted.
    #[must_use]
    pub fn with_step_counter(self, count: Arc<AtomicUsize>) -> Self {
        Self { count, ..self }
    }

    /// Sets the approximate memory (bytes) in which a reverse sweep stores steps of the rollout. The default is 256 MiB. At least
    /// 16 steps are stored. The memory does not change the bits of values and derivatives.
    ///
    /// An explicit step takes 144 bytes per body. An implicit step takes about 500 bytes per body, or more if it was subdivided.
    ///
    /// If s of l steps are stored, each step is recomputed at most r times, where r is the smallest number with
    /// (s + r + 1)! / (s! (r + 1)!) ≥ l. For s ≥ √(2l) this is once, so the sweep costs at most one additional rollout. For 27
    /// stored steps of a million it is five times.
    #[must_use]
    pub fn with_memory(self, memory: usize) -> Self {
        Self { memory, ..self }
    }

    /// Memory (bytes) of a reverse sweep for recorded steps.
    pub(super) fn memory(&self) -> usize {
        self.memory
    }

    /// Number of steps for a Jacobian with respect to `numbers` numbers of parameters: the steps of the plan, once for every 96
    /// numbers. A value and a reverse-mode gradient take the steps of the plan once, as for 0 numbers.
    ///
    /// # Errors
    /// [`GradientError::TooManySteps`] if the number exceeds [`usize::MAX`].
    pub fn step_count_for(&self, numbers: usize) -> Result<usize, GradientError> {
        let (steps, rollouts) = (self.plan.steps(), numbers.div_ceil(WIDE).max(1));
        let count = steps.checked_mul(rollouts);
        count.ok_or(GradientError::TooManySteps { steps, rollouts })
    }

    /// Values of the parameters, as in [`World::values`].
    ///
    /// # Errors
    /// If the world does not have one of the parameters.
    pub fn values(&self, parameters: &[Parameter]) -> Result<DVector<f64>, GradientError> {
        values(self.model(), parameters)
    }

    /// Index of the body with this name in every state.
    ///
    /// # Errors
    /// If no body has the name.
    pub fn index_of(&self, name: &str) -> Result<usize, WorldError> {
        self.model().index_of(name)
    }

    /// The experiment with new values of the parameters, which are in the order of [`World::values`].
    ///
    /// # Errors
    /// As [`World::with_values`].
    pub fn at(&self, parameters: &[Parameter], values: &[f64]) -> Result<Self, GradientError> {
        self.rebuilt(with_values(self.model(), parameters, values)?)
    }

    /// The experiment after changes of the parameters, as in [`World::perturbed`].
    ///
    /// # Errors
    /// As [`World::perturbed`].
    pub fn perturbed(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
    ) -> Result<Self, GradientError> {
        self.rebuilt(perturbed(self.model(), parameters, changes)?)
    }

    /// The experiment with another initial state and its time.
    ///
    /// # Errors
    /// As [`World::with_initial_state`].
    pub fn starting_from(&self, state: &State) -> Result<Self, GradientError> {
        self.rebuilt(self.model().clone().with_initial_state(state)?)
    }

    /// The experiment on the world with another model.
    fn rebuilt(&self, model: Model) -> Result<Self, GradientError> {
        Ok(Self {
            world: self.world.rebuilt(model)?,
            ..self.clone()
        })
    }

    /// The experiment with another plan.
    #[must_use]
    pub fn with_plan(&self, plan: Plan) -> Self {
        Self {
            plan,
            ..self.clone()
        }
    }

    /// Cancel flag of the experiment.
    pub(super) fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Returns a rollout of the world of the experiment or of a perturbed world.
    pub(super) fn rollout_of<T: Scalar>(&self, world: Arc<dyn DynWorld<T>>) -> Rollout<T> {
        let rollout = Rollout::of(world, &self.plan).with_cancel_flag(self.stop());
        rollout.with_step_counter(Arc::clone(&self.count))
    }

    /// All data of the world except its forces.
    pub(crate) fn model(&self) -> &Model {
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

    /// Runs the rollout and returns the recorded states.
    ///
    /// # Errors
    /// If the rollout ends early. The error holds the trajectory up to that time.
    pub fn trajectory(&self) -> RolloutResult {
        self.rollout_of(self.world.clone()).run()
    }

    /// Value of the outcome, without derivatives.
    ///
    /// # Errors
    /// - If the rollout ends early.
    /// - [`GradientError::OutcomeNotFinite`] if an outcome component is not finite.
    pub fn value(&self, outcome: &impl Outcome) -> Result<Vec<f64>, GradientError> {
        let value = self.value_of(outcome)?;
        check_outcome(&value)?;
        Ok(value)
    }

    /// Outcome of the unperturbed world. Not generic, so that it is compiled in this library.
    pub(super) fn value_of(
        &self,
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(self.world.clone(), outcome)
    }

    /// Outcome and its derivatives with respect to the parameters, in forward mode. Each rollout on dual numbers handles up to 96 parameter
    /// components.
    ///
    /// # Errors
    /// - If the world does not have one of the parameters.
    /// - If the rollout ends early.
    /// - [`GradientError::OutcomeNotFinite`] if an outcome component is not finite.
    /// - [`GradientError::StateDerivativeNotFinite`] if a derivative of the outcome is not finite
    ///   because a derivative of a state is not finite. The error names the parameter and the first
    ///   step with a derivative that is not finite. Another rollout finds this step.
    /// - [`GradientError::OutcomeDerivativeNotFinite`] if a derivative of the outcome is not finite
    ///   although the derivatives of all states are finite. Both errors hold the value and the
    ///   other derivatives.
    /// - [`GradientError::NoFriction`] if two bodies that can collide have zero friction, and both coefficients are parameters.
    /// - [`GradientError::OutcomeLength`] if the length of the outcome differs between rollouts.
    pub fn jacobian(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Result<OutcomeJacobian, GradientError> {
        self.jacobian_of(parameters, outcome)
    }

    /// [`Self::jacobian`], but not generic, so that it is compiled in this library.
    pub(super) fn jacobian_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<OutcomeJacobian, GradientError> {
        let (jacobian, non_finite) = self.jacobian_unchecked(parameters, outcome)?;
        check_outcome(jacobian.value.as_slice())?;
        match non_finite {
            None => Ok(jacobian),
            Some(non_finite) => Err(non_finite.into_error(self.model(), parameters, jacobian)),
        }
    }

    /// Loss and its gradient, in the mode that [`Self::mode_for`] selects.
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

    /// Loss and its gradient, in a given mode.
    ///
    /// # Errors
    /// - As [`Self::jacobian`]. In reverse mode, [`GradientError::BackwardNotFinite`] reports derivatives that are not finite.
    /// - [`GradientError::NotALoss`] if the outcome is not one number.
    pub fn gradient_with_mode(
        &self,
        mode: Mode,
        parameters: &[Parameter],
        loss: &impl Outcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        let OutcomeJacobian { value, jacobian } = match mode {
            Mode::Forward => self.jacobian(parameters, loss)?,
            Mode::Reverse => return self.reverse_gradient(parameters, loss),
        };
        Ok((loss_of(value.as_slice())?, jacobian.row(0).transpose()))
    }

    /// Outcome at other values of the parameters, in the order of [`World::values`].
    ///
    /// # Errors
    /// As [`World::with_values`] and [`Self::value`].
    pub fn value_at(
        &self,
        parameters: &[Parameter],
        values: &[f64],
        outcome: &impl Outcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.at(parameters, values)?.value(outcome)
    }

    /// Outcome after changes of the parameters, as in [`World::perturbed`].
    ///
    /// # Errors
    /// As [`World::perturbed`] and [`Self::value`].
    pub fn value_perturbed(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
        outcome: &impl Outcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.perturbed(parameters, changes)?.value(outcome)
    }

    /// Outcome after changes of the parameters. Only masses are validated, because the step of a difference may take a number of a
    /// material out of its range.
    pub(super) fn value_perturbed_unchecked(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Vec<f64>, GradientError> {
        let slots = Slots::resolve(parameters, self.model())?;
        let model = slots.perturbed(&slots.differentiated(self.model()), changes);
        model.bodies.iter().try_for_each(Body::check_mass)?;
        self.value_in(model, outcome)
    }

    /// Outcome of another model. Not generic, so that it is compiled in this library.
    fn value_in(
        &self,
        model: Model,
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(self.world.with_model(model), outcome)
    }

    /// Typical change of each parameter component.
    pub(super) fn scales(&self, parameters: &[Parameter]) -> Result<Vec<f64>, GradientError> {
        let slots = Slots::resolve(parameters, self.model())?;
        Ok(slots.scales(self.model()))
    }

    /// Outcome of a rollout of the world of the experiment or of a perturbed world.
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
