use super::dual_widths::DifferentiableOutcome;
use super::motion_slopes::{MotionCheck, WithPositions};
use super::{DerivativeCheck, Experiment, GradientError, Outcome, Parameter};

impl Experiment {
    /// Compares the Jacobian with the slopes of the motion.
    ///
    /// Slopes are computed over decreasing changes of each number. The outcomes are at 1e-2 to 8e-5 typical changes, as in
    /// [`DifferenceCheck::steps`](super::DifferenceCheck::steps). The changes stop decreasing when the noise of the rollouts exceeds 3 % of
    /// the slope. A derivative is right if it differs by at most 3 % from the slopes over two successive changes. One change suffices if
    /// the next change fails or is too noisy. [`CheckedDerivative::width`](super::CheckedDerivative::width) is the larger change. The check
    /// does not detect variations of the outcome over smaller changes.
    ///
    /// Slopes are differences of outcomes of more accurate rollouts. If the integrator of the plan
    /// is implicit, these rollouts use `Sdirk3` with tight tolerances
    /// ([`Accuracy`](crate::dynamics::Accuracy)): 1e-6 for values and 3e-5 for slopes, or a tenth
    /// of the tolerances of the plan if that is less. The resting speeds are divided by ten, and
    /// the time step is divided by four. If the integrator is explicit, the time step is divided by
    /// eight.
    ///
    /// For a right derivative, the check takes at least 6 of these rollouts. For other derivatives, it takes up to 16. Two more rollouts,
    /// and two at even tighter tolerances, measure the noise. If any derivative is not right, the check also takes one Jacobian at tight
    /// tolerances. If a rollout at changed parameters fails, the check tries the next smaller change.
    ///
    /// Bodies at rest vibrate against each other. A vibration with a period well below the time step is damped in both the
    /// derivative and the slopes, so the check does not see it.
    ///
    /// [`Experiment::difference_check`] compares with differences of the *same* steps instead. It checks that these steps are
    /// differentiated exactly, but not that they follow the motion.
    ///
    /// # Errors
    /// - As [`Self::jacobian`].
    /// - If the rollout at tight tolerances with unchanged parameters fails.
    /// - If no change of a number has successful rollouts.
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
