use crate::dynamics::WorldError;
use crate::gradient::GradientError;
use crate::spatial::PoseError;
use std::ops::RangeInclusive;

/// Allowed scales. Their squares and inverse squares are normal floating-point numbers.
const SCALES: RangeInclusive<f64> = 1e-150..=1e150;

/// Reason why an identification is invalid or has no result. With the feature `serde`, only the message is
/// serialized, and each deserialized error is an [`IdentificationError::Evaluation`] with this message.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// A parameter or a measured initial state does not fit the world, a rollout ended early, or the cancel flag was set.
    #[error(transparent)]
    Gradient(#[from] GradientError),
    /// The world has no observed body of this name.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A number is not positive and finite.
    #[error("{quantity} is {value}, but must be positive and finite")]
    NotPositive {
        /// Name of the number.
        quantity: String,
        /// Value of the number.
        value: f64,
    },
    /// A standard deviation or the scale of a loss is too small or too large.
    #[error(
        "{quantity} is {value}, but must be positive, from {:e} to {:e}, because a fit divides by its square", SCALES.start(), SCALES.end()
    )]
    UnusableScale {
        /// Name of the number.
        quantity: String,
        /// Value of the number.
        value: f64,
    },
    /// No body is observed.
    #[error("no body is observed: name at least one dynamic body of the world")]
    NoObservedBody,
    /// The world has no dynamic body.
    #[error(
        "no body of the world is dynamic (number of bodies: {0}): add the body whose motion is measured"
    )]
    NoDynamicBody(usize),
    /// An observed body is not dynamic.
    #[error(
        "the observed body {0:?} is fixed or follows a path, but must be dynamic: remove it from the observed bodies"
    )]
    ObservedNotDynamic(String),
    /// A body is observed twice.
    #[error("the body {0:?} is observed twice: remove one of its names")]
    ObservedTwice(String),
    /// A parameter does not have the component.
    #[error("{parameter} has no component {component}: it has {dimension}, counted from 0")]
    NoComponent {
        /// The parameter.
        parameter: String,
        /// Index of the component.
        component: usize,
        /// Number of components.
        dimension: usize,
    },
    /// A value of an unknown is outside its range.
    #[error(
        "{role} of the unknown {unknown:?} is {value}, but must be between {lower} and {upper}, both excluded: change the value or the range"
    )]
    OutOfRange {
        /// Role of the value: the initial guess, the mean of the prior, or the given value.
        role: &'static str,
        /// Name of the unknown.
        unknown: String,
        /// The value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// Two unknowns set the same component of a parameter.
    #[error("the unknowns {:?} and {:?} set the same component of a parameter: remove one of them", .unknowns[0], .unknowns[1])]
    DuplicateUnknown {
        /// Names of the unknowns.
        unknowns: [String; 2],
    },
    /// Two nuisances change the same component of a parameter.
    #[error(
        "two nuisances change component {component} of {parameter} (counted from 0), but each component can have only one: remove one of them"
    )]
    DuplicateNuisance {
        /// The parameter.
        parameter: String,
        /// Index of the component.
        component: usize,
    },
    /// A measurement has fewer than two states.
    #[error("measurement {0:?} has fewer than two states")]
    TooFewStates(String),
    /// The time of a measured state is not a multiple of the time step after the first state.
    #[error(
        "state {state} of measurement {measurement:?} is {after} s after the first state, which is not a multiple of the time step ({time_step} s): change the time step of the plan"
    )]
    OffGrid {
        /// Name of the measurement.
        measurement: String,
        /// Index of the state.
        state: usize,
        /// Time (s) after the first state.
        after: f64,
        /// Time step (s) of the plan.
        time_step: f64,
    },
    /// A measured pose is not a rigid transform.
    #[error(
        "the pose of body {body} in state {state} of measurement {measurement:?} is invalid (indices from 0): {source}"
    )]
    Pose {
        /// Name of the measurement.
        measurement: String,
        /// Index of the state.
        state: usize,
        /// Index of the body.
        body: usize,
        /// Reason.
        source: PoseError,
    },
    /// No measurement is given.
    #[error("an identification needs at least one measurement")]
    NoMeasurement,
    /// No rollout of any measurement reaches its end at the beginning of a fit.
    #[error(
        "no measurement can be simulated with the values at the beginning of the fit. The simulation of {measurement:?} fails: {source}"
    )]
    NoRollout {
        /// Name of the first measurement.
        measurement: String,
        /// Reason why its rollout ends early.
        source: Box<IdentificationError>,
    },
    /// Message of an error that an [`Evaluator`](super::Evaluator) reported, or of a deserialized error.
    #[error("{0}")]
    Evaluation(String),
    /// The horizon index of a checkpoint is larger than the number of horizons.
    #[error(
        "the checkpoint has the horizon index {found}, but the largest index is {count}: use the horizons of the fit that made the checkpoint"
    )]
    HorizonIndex {
        /// Index that was found.
        found: usize,
        /// Number of horizons.
        count: usize,
    },
    /// A count of values, unknowns, nuisances or measurements is wrong.
    #[error("expected {expected} {quantity}, but found {found}")]
    WrongCount {
        /// Name of the counted items.
        quantity: &'static str,
        /// Number that was found.
        found: usize,
        /// Number that was expected.
        expected: usize,
    },
}

/// Checks that a number is positive and finite.
pub(super) fn check_positive(
    quantity: impl Into<String>,
    value: f64,
) -> Result<(), IdentificationError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let quantity = quantity.into();
    Err(IdentificationError::NotPositive { quantity, value })
}

/// Checks that a fit can divide by the square of a number.
pub(super) fn check_scale(
    quantity: impl Into<String>,
    value: f64,
) -> Result<(), IdentificationError> {
    if SCALES.contains(&value) {
        return Ok(());
    }
    let quantity = quantity.into();
    Err(IdentificationError::UnusableScale { quantity, value })
}

/// Checks that a count is the expected count.
pub(super) fn check_count(
    quantity: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), IdentificationError> {
    if found == expected {
        return Ok(());
    }
    Err(IdentificationError::WrongCount {
        quantity,
        found,
        expected,
    })
}
