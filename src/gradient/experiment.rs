use super::{GradientError, Outcome, Parameter};
use crate::dynamics::{Body, ExternalForces, Gravity, Integrator, Recorded, Rollout, World};
use crate::scalar::Scalar;
use crate::threads::contained;
use nalgebra::{DMatrix, DVector};

/// A world rolled out for a number of steps, to be differentiated.
///
/// A rollout that ends early has no outcome. The error says when and why; [`Self::trajectory`] gives
/// the states before. A panic in a function that was passed in (an external force, a path, an
/// outcome) is such an error too.
#[derive(Debug)]
pub struct Experiment<'w, F = Gravity> {
    pub(super) world: &'w World<f64, F>,
    time_step: f64,
    steps: usize,
    integrator: Integrator,
    record_every: usize,
    check_every: Option<usize>,
}

/// What an outcome is, and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct OutcomeJacobian {
    /// The outcome.
    pub value: DVector<f64>,
    /// Its derivatives: a row for each number of the outcome, a column for each number of the
    /// parameters, in the order given.
    pub jacobian: DMatrix<f64>,
}

impl<'w, F: ExternalForces> Experiment<'w, F> {
    /// Leapfrog steps of `time_step` (s) from the world's initial state, all of them recorded.
    ///
    /// # Errors
    /// If the time step is not positive and finite.
    pub fn new(
        world: &'w World<f64, F>,
        time_step: f64,
        steps: usize,
    ) -> Result<Self, GradientError> {
        world.rollout(time_step, Integrator::default())?;
        Ok(Self {
            world,
            time_step,
            steps,
            integrator: Integrator::default(),
            record_every: 1,
            check_every: None,
        })
    }

    /// The same experiment with another integrator.
    #[must_use]
    pub fn with_integrator(self, integrator: Integrator) -> Self {
        Self { integrator, ..self }
    }

    /// The same experiment, recording the initial state, every `every`th after it, and the last: outcomes see no others.
    #[must_use]
    pub fn recording_every(self, every: usize) -> Self {
        Self {
            record_every: every,
            ..self
        }
    }

    /// The same experiment, every rollout of it
    /// [with a stability check](crate::dynamics::Rollout::with_stability_check).
    #[must_use]
    pub fn with_stability_check(self, every: usize) -> Self {
        self.checked_every(Some(every))
    }

    /// The same experiment with a stability check every so many steps, or none.
    pub(super) fn checked_every(self, check_every: Option<usize>) -> Self {
        Self {
            check_every,
            ..self
        }
    }

    /// The recorded states.
    ///
    /// # Errors
    /// If the rollout ends early; the error holds the trajectory up to there.
    pub fn trajectory(&self) -> Recorded {
        self.recorded(self.world)
    }

    /// The outcome without derivatives.
    ///
    /// # Errors
    /// If the rollout ends early.
    pub fn value(&self, outcome: &impl Outcome) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(self.world, outcome)
    }

    /// The outcome and its derivatives by the parameters: forward mode, all in one rollout on dual
    /// numbers if they are no more than 96 numbers, else 96 at a time.
    ///
    /// # Errors
    /// - If a parameter is not one of the world's, or the rollout ends early.
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
        let (found, breakdown) = self.differentiated(parameters, outcome)?;
        match breakdown {
            None => Ok(found),
            Some(breakdown) => Err(breakdown.into_error(self.world, parameters, found)),
        }
    }

    /// A loss and its gradient.
    ///
    /// # Errors
    /// As [`Self::jacobian`], and if the outcome is not one number.
    pub fn gradient(
        &self,
        parameters: &[Parameter],
        loss: &impl Outcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        let OutcomeJacobian { value, jacobian } = self.jacobian(parameters, loss)?;
        if value.len() != 1 {
            return Err(GradientError::NotALoss { count: value.len() });
        }
        Ok((value[0], jacobian.row(0).transpose()))
    }

    /// The outcome after changes of the parameters, as a line search asks for it.
    ///
    /// # Errors
    /// As [`World::changed`], and if the rollout ends early.
    pub fn value_after(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
        outcome: &impl Outcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(&self.world.changed(parameters, changes)?, outcome)
    }

    /// The outcome beside the world's own parameters, where a material's number may have left its
    /// range by a difference's step.
    pub(super) fn value_beside(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
        outcome: &impl Outcome,
    ) -> Result<Vec<f64>, GradientError> {
        self.outcome_of(&changed(self.world, parameters, changes), outcome)
    }

    /// For each number of the parameters, a typical change.
    pub(super) fn scales(&self, parameters: &[Parameter]) -> Vec<f64> {
        let scale = |parameter: &Parameter| {
            std::iter::repeat_n(parameter.scale(self.world), parameter.dimension())
        };
        parameters.iter().flat_map(scale).collect()
    }

    /// The outcome of a rollout of the world, or of one that was made of it.
    pub(super) fn outcome_of<T: Scalar>(
        &self,
        world: &World<T, F>,
        outcome: &impl Outcome,
    ) -> Result<Vec<T>, GradientError> {
        let trajectory = self.recorded(world)?;
        contained(|| Ok(outcome.of(&trajectory)))
    }

    fn recorded<T: Scalar>(&self, world: &World<T, F>) -> Recorded<T> {
        self.rollout(world).recorded(self.steps, self.record_every)
    }

    pub(super) fn rollout<'o, T: Scalar>(&self, world: &'o World<T, F>) -> Rollout<'o, T, F> {
        Rollout::new(world, self.time_step, self.integrator).checked_every(self.check_every)
    }

    pub(super) fn steps(&self) -> usize {
        self.steps
    }
}

impl<F: ExternalForces> World<f64, F> {
    /// The world after changes of the parameters, one number for each number of theirs: what an
    /// optimiser's step makes of it. Shapes are shared, not built again.
    ///
    /// # Errors
    /// If a parameter is not one of the world's, or the count of changes is not that of its numbers,
    /// or a number is out of its range after the change.
    pub fn changed(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
    ) -> Result<Self, GradientError> {
        let (found, expected) = (changes.len(), checked_dimension(self, parameters)?);
        if found != expected {
            return Err(GradientError::ChangeCount { found, expected });
        }
        let world = changed(self, parameters, changes);
        world.bodies.iter().try_for_each(Body::check)?;
        let gravity = world.gravity;
        Ok(world.with_gravity(gravity)?)
    }
}

/// Number of numbers in the parameters, if the world has them.
pub(super) fn checked_dimension<F: ExternalForces>(
    world: &World<f64, F>,
    parameters: &[Parameter],
) -> Result<usize, GradientError> {
    parameters
        .iter()
        .try_for_each(|parameter| parameter.check(world))?;
    Ok(parameters.iter().map(Parameter::dimension).sum())
}

/// The world after changes of the parameters, which it has.
pub(super) fn changed<T: Scalar, F: ExternalForces>(
    world: &World<f64, F>,
    parameters: &[Parameter],
    changes: &[T],
) -> World<T, F> {
    let mut world = world.lifted();
    let mut rest = changes;
    for parameter in parameters {
        let (own, others) = rest.split_at(parameter.dimension());
        parameter.change(&mut world, own);
        rest = others;
    }
    world
}
