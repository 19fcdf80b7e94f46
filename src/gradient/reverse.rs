use super::experiment::{changed, checked_dimension};
use super::outcome_covectors::OutcomeCovectors;
use super::parameter::check_together;
use super::widths::{DifferentiableOutcome, WIDE};
use super::{Experiment, GradientError, Outcome, Parameter, RolloutGradient};
use crate::dynamics::{
    AnyWorld, Reversal, RolloutError, SystemGradient, Tape, Trajectory, WithSystem,
};
use crate::threads::contained;
use nalgebra::DVector;
use std::sync::Arc;

/// From which end a rollout is differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mode {
    /// By dual numbers, from the parameters to all later states: the time grows with the number of parameters, up to 96
    /// of which share one rollout; any number of outcomes takes no more.
    Forward,
    /// From the outcome back to the start, step by step, from states that were kept or are computed again: for one outcome, in a
    /// time that does not depend on the number of parameters.
    Reverse,
}

impl Mode {
    /// For a gradient: backwards where more than one rollout forwards would be needed (`cargo bench --bench reverse`).
    pub(super) fn of_gradient_by(parameters: &[Parameter]) -> Self {
        let count: usize = parameters.iter().map(Parameter::dimension).sum();
        if count > WIDE {
            Self::Reverse
        } else {
            Self::Forward
        }
    }
}

impl Experiment {
    /// A loss and its gradient, by a sweep back from the outcome.
    pub(super) fn swept_back(
        &self,
        parameters: &[Parameter],
        loss: &dyn DifferentiableOutcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        let count = checked_dimension(self.system(), parameters)?;
        check_together(parameters, self.system())?;
        // Bodies whose friction is a parameter rub, even without any.
        let system = changed(self.system(), parameters, &vec![0.0; count]);
        let world = WithSystem::<f64>::with_system(self.world(), system);
        let (value, gradient) = contained(|| self.sweep(&world, loss, false))?;
        let numbers = parameters
            .iter()
            .flat_map(|it| it.own(self.system(), &gradient));
        Ok((value, DVector::from_iterator(count, numbers)))
    }

    /// A loss and its derivatives by all that the rollout depends on, the shapes of all bodies among them: by a sweep back from
    /// the outcome.
    ///
    /// Those by dissipation and friction of two bodies of which neither has any are not known, and 0.
    ///
    /// # Errors
    /// As [`Self::gradient_by`] backwards.
    pub fn gradient_by_all(&self, loss: &impl Outcome) -> Result<RolloutGradient, GradientError> {
        let world = WithSystem::<f64>::with_system(self.world(), self.system().clone());
        let (value, gradient) = contained(|| self.sweep(&world, loss, true))?;
        Ok(RolloutGradient {
            value,
            system: self.system().clone(),
            gradient,
            has_forces: world.has_forces(),
        })
    }

    /// The loss, and its derivatives by all that the rollout of a world depends on.
    fn sweep(
        &self,
        world: &Arc<dyn AnyWorld<f64>>,
        loss: &dyn DifferentiableOutcome,
        by_shapes: bool,
    ) -> Result<(f64, SystemGradient), GradientError> {
        let plan = self.plan();
        let mut reversal = Reversal::of(&**world, plan);
        if by_shapes {
            reversal = reversal.with_shapes();
        }
        let mut tape = Tape::new(&**world, plan);
        let trajectory = self.taped(world, &mut tape)?;
        let mut outcome = OutcomeCovectors::of(loss, world.system(), &trajectory)?;
        outcome.add_to(trajectory.states().len() - 1, &mut reversal);
        for step in (1..=plan.steps()).rev() {
            if self.is_stopped() {
                return Err(RolloutError::Stopped.into());
            }
            self.check_finite(&reversal, step + 1)?;
            reversal.step_back(step, tape.back_to(step - 1)?)?;
            if plan.records(step - 1) {
                outcome.add_to((step - 1) / plan.record_every(), &mut reversal);
            }
        }
        self.check_finite(&reversal, 1)?;
        Ok((outcome.value, reversal.finished()))
    }

    /// The rollout of a world, with its states on a tape.
    fn taped(
        &self,
        world: &Arc<dyn AnyWorld<f64>>,
        tape: &mut Tape,
    ) -> Result<Trajectory, GradientError> {
        let rollout = self.rollout_of(Arc::clone(world));
        Ok(rollout.recorded_with(|taken, steps| tape.keep(taken, steps))?)
    }

    fn check_finite(&self, reversal: &Reversal, step: usize) -> Result<(), GradientError> {
        match reversal.lost() {
            None => Ok(()),
            Some(body) => Err(GradientError::BackwardNotFinite {
                step,
                body: self.system().bodies[body].name().to_owned(),
            }),
        }
    }
}
