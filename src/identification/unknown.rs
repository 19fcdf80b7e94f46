use super::IdentificationError;
use super::error::check_positive;
use crate::gradient::Parameter;
use crate::scalar::portable::{exp, ln};

/// An unknown number that all measurements share. Its value in the world of the template is the initial guess.
///
/// The minimizer changes a *coordinate* of the unknown: the value itself, its logarithm ([`Self::logarithmic`]), or the logit
/// of the value between its bounds ([`Self::bounded`]). Covariances refer to coordinates.
///
/// ```
/// use hydroelastic::gradient::Parameter;
/// use hydroelastic::identification::Unknown;
///
/// let modulus = Unknown::new(Parameter::modulus("cube")).logarithmic();
/// let friction = Unknown::new(Parameter::friction("cube")).bounded(0.0, 1.0);
/// let height = Unknown::new(Parameter::initial_position("table")).component(2).named("table height");
/// assert_eq!(height.name(), "table height");
/// ```
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Unknown {
    pub(super) name: String,
    /// Parameters with a component each. All of these numbers have the value of the unknown.
    pub(super) numbers: Vec<(Parameter, usize)>,
    pub(super) scale: Scale,
    /// Expected value and standard deviation of the coordinate.
    pub(super) prior: Option<(f64, f64)>,
}

/// Errors of one measurement in a parameter, with their standard deviation. Their expected value is zero.
///
/// The errors are changes as in [`World::perturbed`](crate::dynamics::World::perturbed): an error of an orientation is a rotation
/// vector (rad) in world axes.
#[derive(Debug, Clone)]
pub struct Nuisance {
    pub(super) parameter: Parameter,
    pub(super) component: Option<usize>,
    pub(super) deviation: f64,
}

/// Map from a coordinate to the value of an unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Scale {
    Linear,
    Logarithmic,
    Bounded { lower: f64, upper: f64 },
}

impl Unknown {
    /// Unknown with the first number of a parameter, on a linear scale. Its name is that of the parameter.
    ///
    /// The value of an orientation is a component of a rotation vector (rad) from the orientation of the template, in world axes.
    #[must_use]
    pub fn new(parameter: Parameter) -> Self {
        Self {
            name: parameter.to_string(),
            numbers: vec![(parameter, 0)],
            scale: Scale::Linear,
            prior: None,
        }
    }

    /// Selects a component of the last parameter, counted from 0.
    #[must_use]
    pub fn component(mut self, component: usize) -> Self {
        if let Some((_, last)) = self.numbers.last_mut() {
            *last = component;
        }
        self
    }

    /// Sets another parameter to the same value.
    #[must_use]
    pub fn tied_to(mut self, parameter: Parameter) -> Self {
        self.numbers.push((parameter, 0));
        self
    }

    /// Sets the name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..self
        }
    }

    /// Uses the logarithm as the coordinate, so that the value stays positive.
    #[must_use]
    pub fn logarithmic(self) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..self
        }
    }

    /// Keeps the value between bounds, both excluded. The coordinate is the logit ln((value − lower)/(upper − value)).
    /// [`Identification::new`](super::Identification::new) checks the bounds.
    #[must_use]
    pub fn bounded(self, lower: f64, upper: f64) -> Self {
        Self {
            scale: Scale::Bounded { lower, upper },
            ..self
        }
    }

    /// Adds a normal prior on the coordinate. Its mean is the coordinate of the value, and its standard deviation has the unit of the
    /// coordinate. For a logarithmic unknown the deviation is relative.
    #[must_use]
    pub fn with_prior(self, value: f64, deviation: f64) -> Self {
        Self {
            prior: Some((value, deviation)),
            ..self
        }
    }

    /// Name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl Nuisance {
    /// Errors of all components of a parameter with a standard deviation (unit of the parameter).
    #[must_use]
    pub fn new(parameter: Parameter, deviation: f64) -> Self {
        Self {
            parameter,
            component: None,
            deviation,
        }
    }

    /// Restricts the error to one component, counted from 0.
    #[must_use]
    pub fn component(self, component: usize) -> Self {
        Self {
            component: Some(component),
            ..self
        }
    }
}

impl Scale {
    /// Range of values, both ends excluded.
    fn range(self) -> [f64; 2] {
        match self {
            Self::Linear => [f64::NEG_INFINITY, f64::INFINITY],
            Self::Logarithmic => [0.0, f64::INFINITY],
            Self::Bounded { lower, upper } => [lower, upper],
        }
    }

    /// Coordinate of a value with a role, of the named unknown.
    ///
    /// # Errors
    /// If the value is out of range, or the width of the bounds is not positive and finite.
    pub fn checked(
        self,
        (role, unknown): (&'static str, &str),
        value: f64,
    ) -> Result<f64, IdentificationError> {
        let [lower, upper] = self.range();
        if let Self::Bounded { .. } = self {
            let width = format!("the width of the bounds of the unknown {unknown:?}");
            check_positive(width, upper - lower)?;
        }
        if lower < value && value < upper {
            return Ok(self.coordinate(value));
        }
        let unknown = unknown.to_owned();
        Err(IdentificationError::OutOfRange {
            role,
            unknown,
            value,
            lower,
            upper,
        })
    }

    /// Coordinate of a value in the range.
    fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => ln(value),
            Self::Bounded { lower, upper } => ln((value - lower) / (upper - value)),
        }
    }

    /// Value at a coordinate, and its derivative with respect to the coordinate.
    pub fn value(self, coordinate: f64) -> [f64; 2] {
        match self {
            Self::Linear => [coordinate, 1.0],
            Self::Logarithmic => [exp(coordinate); 2],
            Self::Bounded { lower, upper } => {
                let share = 1.0 / (1.0 + exp(-coordinate));
                let width = upper - lower;
                [lower + width * share, width * share * (1.0 - share)]
            }
        }
    }
}
