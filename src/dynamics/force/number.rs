use super::Situation;
use crate::dynamics::WorldError;
use crate::dynamics::settings::check_not_negative;
use crate::scalar::{Scalar, lift};

/// A number of a force: a constant, or the name of a force parameter of the world
/// ([`World::with_force_parameter`](crate::dynamics::World::with_force_parameter)). Derivatives are taken by a parameter
/// ([`Parameter::OfForces`](crate::gradient::Parameter::OfForces)), and several forces may share it.
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
    /// The number itself.
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
    /// The number in a world that has the parameter, which the check of a force ensures.
    pub(super) fn value<T: Scalar>(&self, now: &Situation<T>) -> T {
        match self {
            Self::Constant(value) => lift(*value),
            Self::Parameter(name) => now.parameter(name).unwrap_or_else(|| lift(0.0)),
        }
    }

    /// Checks that the number is not negative, and that it is among the parameters if it is one of them.
    pub(super) fn check(
        &self,
        quantity: &'static str,
        parameters: &[(String, f64)],
    ) -> Result<(), WorldError> {
        let name = match self {
            Self::Constant(value) => return check_not_negative(quantity, *value),
            Self::Parameter(name) => name,
        };
        match parameters.iter().find(|(own, _)| own == name) {
            Some((_, value)) => check_not_negative(quantity, *value),
            None => Err(WorldError::UnknownForceParameter {
                name: name.clone(),
                known: parameters.iter().map(|(own, _)| own.clone()).collect(),
            }),
        }
    }
}
