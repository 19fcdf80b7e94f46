use std::fmt;

/// Result of comparing a derivative of the numerical solution with the slope of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Verdict {
    /// The derivative agrees with the slope.
    Right,
    /// The derivative agrees with a one-sided slope, but not with the central slope. It is the derivative of the plan or the
    /// derivative at tight tolerances.
    Kink,
    /// The derivative agrees with the slope at tight tolerances, but not at the tolerances of the plan, because the steps of the plan do
    /// not resolve the motion.
    Unresolved,
    /// The derivative disagrees with the slope at every width, even at tight tolerances. Either the motion amplifies small changes, or the
    /// derivative is wrong. Dissipation, finer meshes or a larger resting speed make the outcome smoother.
    Chaotic,
    /// The derivative agrees with the slope within the noise of the rollouts, but this noise exceeds 3 % of the slope at every width.
    Noisy,
}

/// Derivative of an outcome with respect to one parameter component, compared with the slope of the motion.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct CheckedDerivative {
    /// Name of the number: a parameter, and a component if there are several.
    pub number: String,
    /// Result of the comparison.
    pub verdict: Verdict,
    /// Largest difference between derivative and slope, relative to the larger of their largest entries. Zero if the difference is
    /// below the noise of the rollouts. For [`Verdict::Noisy`], the noise relative to the same entry.
    pub error: f64,
    /// Change of the number (unit of the number) over which the slope was taken. For [`Verdict::Right`], it is the largest tested
    /// change whose effect the derivative predicts.
    pub width: f64,
    /// Time (s) of the first recorded state in which the derivative of a position does not agree with the slope, and the name of the
    /// body. `None` if the verdict is right or noisy, or if the derivatives of all recorded positions agree with their slopes.
    pub first_mismatch: Option<(f64, String)>,
}

/// Derivatives of an outcome, compared with the slopes of the motion: see
/// [`Experiment::derivative_check`](super::Experiment::derivative_check).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DerivativeCheck {
    /// One entry for each parameter component.
    pub derivatives: Vec<CheckedDerivative>,
}

impl DerivativeCheck {
    /// Whether all verdicts are [`Verdict::Right`].
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
        for (index, derivative) in self.derivatives.iter().enumerate() {
            if index > 0 {
                writeln!(formatter)?;
            }
            write!(formatter, "{derivative}")?;
        }
        Ok(())
    }
}
