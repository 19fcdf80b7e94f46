use crate::dynamics::WorldError;
use crate::gradient::GradientError;
use crate::spatial::PoseError;

/// Reason why an identification is invalid or has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// The world does not have a parameter of an unknown or of a nuisance.
    #[error(transparent)]
    Gradient(#[from] GradientError),
    /// A body or a state does not fit the world.
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
    /// A parameter does not have the component.
    #[error("{parameter} has no number {component}, counted from 0: it has {dimension}")]
    NoComponent {
        /// The parameter.
        parameter: String,
        /// Index of the component.
        component: usize,
        /// Number of components.
        dimension: usize,
    },
    /// A value of an unknown is outside its range: the value in the world of the template, the mean of a prior, or a known value.
    #[error(
        "a value of the unknown {unknown:?} is {value}, but must be between {lower} and {upper}, both excluded: change the value or the range"
    )]
    OutOfRange {
        /// Name of the unknown.
        unknown: String,
        /// The value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// Two unknowns set the same number.
    #[error("the unknowns {:?} and {:?} set the same number: remove one of them", .unknowns[0], .unknowns[1])]
    SameNumber {
        /// Names of the unknowns.
        unknowns: [String; 2],
    },
    /// A measurement has fewer than two states.
    #[error("measurement {0:?} has fewer than two states")]
    Short(String),
    /// The time of a measured state is not a multiple of the time step after the first state.
    #[error(
        "state {state} of measurement {measurement:?} is {after} s after the first state, but must be a multiple of the time step of {time_step} s after it: change the time step of the plan"
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
        "state {state} of measurement {measurement:?}, body {body}, both counted from 0: {source}"
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
    /// No rollout of any measurement reaches its end at the initial values.
    #[error(
        "no measurement can be simulated with the initial values of the unknowns; the first, {measurement:?}: {source}"
    )]
    NoRollout {
        /// Name of the first measurement.
        measurement: String,
        /// Reason why its rollout ends early.
        source: GradientError,
    },
    /// The number of values or of measurements differs from that of the identification.
    #[error("expected {expected} {quantity}, but found {found}")]
    Count {
        /// Name of the numbers.
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

/// Checks that a count is the expected count.
pub(super) fn check_count(
    quantity: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), IdentificationError> {
    if found == expected {
        return Ok(());
    }
    Err(IdentificationError::Count {
        quantity,
        found,
        expected,
    })
}
