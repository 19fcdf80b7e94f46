use super::motion_slopes::{MotionCheck, WithPositions};
use super::widths::DifferentiableOutcome;
use super::{Experiment, GradientError, Outcome, Parameter};
use crate::dynamics::check_positive;
use std::fmt;

/// How a derivative of the numerical solution compares with the slope of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Verdict {
    /// The derivative is the slope.
    Right,
    /// The derivative, that of the plan or that at tight tolerances, is the slope on one side, but not that over both.
    Kink,
    /// The derivative is the slope at tight tolerances, but not at those of the plan: its steps do not resolve the motion.
    Unresolved,
    /// Even at tight tolerances the derivative is not the slope over the width. The motion amplifies small changes, or the outcome bends
    /// within the width. Dissipation, finer meshes, or a larger resting speed make it smoother.
    Chaotic,
    /// The derivative agrees with the slope within the noise of the rollouts, but this noise exceeds 3 % of the slope. A larger width
    /// tells more.
    Noisy,
}

/// A derivative of an outcome by one number of the parameters, compared with the slope of the motion.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct CheckedDerivative {
    /// A parameter, and which of its numbers.
    pub number: String,
    /// How they compare.
    pub verdict: Verdict,
    /// Largest difference between derivative and slope, relative to the larger of their largest entries. Zero if it is below the noise
    /// of the rollouts. With the verdict noisy, it is this noise, relative to the same.
    pub error: f64,
    /// The time (s) of the first recorded state in which the derivative of a position is not the slope, and the name of the body. None if
    /// the verdict is right or noisy, or the derivatives of all recorded positions agree with their slopes.
    pub first_mismatch: Option<(f64, String)>,
}

/// The derivatives of an outcome, compared with the slopes of the motion: see [`Experiment::derivative_check`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DerivativeCheck {
    /// One for each number of the parameters.
    pub derivatives: Vec<CheckedDerivative>,
}

impl DerivativeCheck {
    /// Whether all derivatives are right.
    #[must_use]
    pub fn is_right(&self) -> bool {
        let mut derivatives = self.derivatives.iter();
        derivatives.all(|derivative| derivative.verdict == Verdict::Right)
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Right => "right",
            Self::Kink => "kink",
            Self::Unresolved => "unresolved",
            Self::Chaotic => "chaotic",
            Self::Noisy => "noisy",
        })
    }
}

impl fmt::Display for CheckedDerivative {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.error;
        let (number, verdict) = (&self.number, self.verdict);
        if verdict == Verdict::Noisy {
            return write!(
                formatter,
                "{number}: {verdict}, slope known to ±{percent:.0} %"
            );
        }
        write!(formatter, "{number}: {verdict}, {percent:.1} % off")?;
        match &self.first_mismatch {
            Some((time, body)) => write!(formatter, ", from body {body:?} at {time:.4} s on"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for DerivativeCheck {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, derivative) in self.derivatives.iter().enumerate() {
            if place > 0 {
                writeln!(formatter)?;
            }
            write!(formatter, "{derivative}")?;
        }
        Ok(())
    }
}

impl Experiment {
    /// Compares the Jacobian with the slopes of the motion over a width on either side.
    ///
    /// The width is a multiple of the typical change of each number, as in
    /// [`DifferenceCheck::steps`](super::DifferenceCheck::steps). It should be the smallest change that matters, because the check
    /// ignores what is finer. 1e-3 suits most scenes.
    ///
    /// Slopes are differences of outcomes at tight tolerances ([`Accuracy`](crate::dynamics::Accuracy)), 1e-6 for values and 3e-5 for
    /// slopes, or a tenth of those of the plan if that is less, with a tenth of the resting speeds and a quarter of the time step. Steps of
    /// `ImplicitEuler` are compared with the same motion. Explicit steps are divided by eight instead. This takes 2 + 4 n such rollouts for n numbers, two at even tighter
    /// tolerances, and one more Jacobian if a derivative does not agree.
    ///
    /// Bodies at rest vibrate against each other. A vibration with a period well below the time step is damped in both the
    /// derivative and the slopes, so the check does not see it.
    ///
    /// [`Experiment::difference_check`] compares with differences of the *same* steps instead. It tells whether these steps are
    /// differentiated exactly, and not whether they follow the motion.
    ///
    /// # Errors
    /// As [`Self::jacobian`]; if the width is not positive and finite, or makes a mass zero or negative; and if a rollout at changed parameters
    /// ends early.
    pub fn derivative_check(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
        width: f64,
    ) -> Result<DerivativeCheck, GradientError> {
        self.derivative_check_of(parameters, outcome, width)
    }

    /// Not generic, so that it is compiled in this library.
    fn derivative_check_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
        width: f64,
    ) -> Result<DerivativeCheck, GradientError> {
        check_positive("width of a derivative check", width)?;
        let watched = WithPositions(outcome);
        let check = MotionCheck::new(self, parameters, &watched, width)?;
        let names = parameters.iter().flat_map(Parameter::number_names);
        let columns = names.zip(self.scales(parameters)?).enumerate();
        let derivatives =
            columns.map(|(column, (number, scale))| check.checked(number, (column, scale), width));
        Ok(DerivativeCheck {
            derivatives: derivatives.collect::<Result<_, _>>()?,
        })
    }
}
