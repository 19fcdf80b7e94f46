use super::dual_widths::DifferentiableOutcome;
use super::motion_slopes::{MotionCheck, WithPositions};
use super::{DerivativeCheck, Experiment, GradientError, Outcome, Parameter};

impl Experiment {
    /// Compares the Jacobian with the slopes of the motion.
    ///
    /// Slopes are taken over decreasing changes of each number, from 1e-2 to 8e-5 typical changes as in
    /// [`DifferenceCheck::steps`](super::DifferenceCheck::steps), as far as they exceed the noise of the rollouts. A derivative is right if
    /// the error of its linear prediction vanishes faster than the change: it must agree with the slopes over two changes in succession,
    /// each to 3 %. [`CheckedDerivative::width`](super::CheckedDerivative::width) is the larger change. The check ignores finer structure.
    ///
    /// Slopes are differences of outcomes of more accurate rollouts. If the integrator of the plan
    /// is implicit, these rollouts use `Sdirk3` with tight tolerances
    /// ([`Accuracy`](crate::dynamics::Accuracy)): 1e-6 for values and 3e-5 for slopes, or a tenth
    /// of the tolerances of the plan if that is less. The resting speeds are divided by ten, and
    /// the time step is divided by four. If the integrator is explicit, the time step is divided by
    /// eight.
    ///
    /// A right derivative takes at least 6 of these rollouts, another derivative up to 16, and one more Jacobian. If a rollout at changed
    /// parameters fails, the next width is tried. The noise is measured by two rollouts at even tighter tolerances.
    ///
    /// Bodies at rest vibrate against each other. A vibration with a period well below the time step is damped in both the
    /// derivative and the slopes, so the check does not see it.
    ///
    /// [`Experiment::difference_check`] compares with differences of the *same* steps instead. It checks that these steps are
    /// differentiated exactly, but not that they follow the motion.
    ///
    /// # Errors
    /// - As [`Self::jacobian`].
    /// - If the rollout at tight tolerances fails, or the rollouts at all changes of a number.
    /// - [`GradientError::OutcomeLength`] if the length of the outcome differs between rollouts.
    pub fn derivative_check(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Result<DerivativeCheck, GradientError> {
        self.derivative_check_of(parameters, outcome)
    }

    /// [`Self::derivative_check`], but not generic, so that it is compiled in this library.
    fn derivative_check_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<DerivativeCheck, GradientError> {
        let outcome_and_positions = WithPositions(outcome);
        let check = MotionCheck::new(self, parameters, &outcome_and_positions)?;
        let numbers = parameters.iter().flat_map(Parameter::number_names);
        let derivatives = numbers
            .enumerate()
            .map(|(column, number)| check.checked(number, column));
        Ok(DerivativeCheck {
            derivatives: derivatives.collect::<Result<_, _>>()?,
        })
    }
}
