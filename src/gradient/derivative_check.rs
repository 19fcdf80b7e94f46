use super::dual_widths::DifferentiableOutcome;
use super::motion_slopes::{MotionCheck, WithPositions};
use super::{DerivativeCheck, Experiment, GradientError, Outcome, Parameter};
use crate::dynamics::check_positive;

impl Experiment {
    /// Compares the Jacobian with the slopes of the motion over a width on either side.
    ///
    /// The width is a multiple of the typical change of each number, as in
    /// [`DifferenceCheck::steps`](super::DifferenceCheck::steps). It should be the smallest change that matters, because the check
    /// ignores finer structure. 1e-3 suits most scenes.
    ///
    /// Slopes are differences of outcomes of more accurate rollouts. If the integrator of the plan
    /// is implicit, these rollouts use `Sdirk3` with tight tolerances
    /// ([`Accuracy`](crate::dynamics::Accuracy)): 1e-6 for values and 3e-5 for slopes, or a tenth
    /// of the tolerances of the plan if that is less. The resting speeds are divided by ten, and
    /// the time step is divided by four. If the integrator is explicit, the time step is divided by
    /// eight.
    ///
    /// For n numbers, the check takes 2 + 4 n of these rollouts, two rollouts at even tighter
    /// tolerances, and one more Jacobian if a derivative does not agree.
    ///
    /// Bodies at rest vibrate against each other. A vibration with a period well below the time step is damped in both the
    /// derivative and the slopes, so the check does not see it.
    ///
    /// [`Experiment::difference_check`] compares with differences of the *same* steps instead. It checks that these steps are
    /// differentiated exactly, but not that they follow the motion.
    ///
    /// # Errors
    /// - As [`Self::jacobian`].
    /// - If the width is not positive and finite, or makes a mass zero or negative.
    /// - If a rollout at perturbed parameters ends early.
    pub fn derivative_check(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
        width: f64,
    ) -> Result<DerivativeCheck, GradientError> {
        self.derivative_check_of(parameters, outcome, width)
    }

    /// [`Self::derivative_check`], but not generic, so that it is compiled in this library.
    fn derivative_check_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
        width: f64,
    ) -> Result<DerivativeCheck, GradientError> {
        check_positive("width of a derivative check", width)?;
        let outcome_and_positions = WithPositions(outcome);
        let check = MotionCheck::new(self, parameters, &outcome_and_positions, width)?;
        let names = parameters.iter().flat_map(Parameter::number_names);
        let columns = names.zip(self.scales(parameters)?).enumerate();
        let derivatives =
            columns.map(|(column, (number, scale))| check.checked(number, (column, scale), width));
        Ok(DerivativeCheck {
            derivatives: derivatives.collect::<Result<_, _>>()?,
        })
    }
}
