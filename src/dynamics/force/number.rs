use super::ForceContext;
use crate::dynamics::WorldError;
use crate::dynamics::validate::check_not_negative;
use crate::scalar::{Scalar, lift};

/// Number of a force: a constant, or the name of a force parameter of the world
/// ([`World::with_force_parameter`](crate::dynamics::World::with_force_parameter)). Rollouts can be differentiated with respect to a force
/// parameter ([`Parameter::ForceParameter`](crate::gradient::Parameter::ForceParameter)). Several forces can share one parameter.
///
/// ```
/// use hydroelastic::dynamics::ForceNumber;
///
/// assert_eq!(ForceNumber::from(100.0), ForceNumber::Constant(100.0));
/// assert_eq!(ForceNumber::from("stiffness"), ForceNumber::Parameter("stiffness".into()));
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(untagged))]
pub enum ForceNumber {
    /// Constant value.
    Constant(f64),
    /// Name of the force parameter.
    Parameter(String),
}

impl From<f64> for ForceNumber {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl From<&str> for ForceNumber {
    fn from(name: &str) -> Self {
        Self::Parameter(name.to_owned())
    }
}

impl ForceNumber {
    /// Value of the number. The world has the parameter, because [`Force::check`](super::Force::check) ensures this.
    pub(super) fn value<T: Scalar>(&self, now: &ForceContext<T>) -> T {
        match self {
            Self::Constant(value) => lift(*value),
            Self::Parameter(name) => now.parameter(name).unwrap_or_else(|| lift(0.0)),
        }
    }

    /// Checks that the value is finite and not negative, and that the world has the force parameter
    /// if the number is a force parameter.
    pub(super) fn check(
        &self,
        quantity: &'static str,
        parameters: &[(String, f64)],
    ) -> Result<(), WorldError> {
        let name = match self {
            Self::Constant(value) => return check_not_negative(quantity, *value),
            Self::Parameter(name) => name,
        };
        match parameters.iter().find(|(known, _)| known == name) {
            Some((_, value)) => check_not_negative(quantity, *value),
            None => Err(WorldError::UnknownForceParameter {
                name: name.clone(),
                known: parameters.iter().map(|(known, _)| known.clone()).collect(),
            }),
        }
    }
}
