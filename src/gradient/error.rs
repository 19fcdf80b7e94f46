use super::OutcomeJacobian;
use crate::dynamics::{RolloutError, RolloutFailure, WorldError};
use crate::mesh::DensityError;
use crate::parallel::Panicked;
use nalgebra::DVector;

/// Why a gradient could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GradientError {
    /// The world, or a parameter's body, is not as it must be.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The rollout did not reach its end.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    /// The density of a body is out of range, or gives mass properties that are not finite.
    #[error(transparent)]
    Density(#[from] DensityError),
    /// The parameter belongs to a body that forces do not move.
    #[error(
        "{parameter} has no effect, because forces do not move body {body:?}: it is fixed or follows a path"
    )]
    NotDynamic {
        /// Name of the body.
        body: String,
        /// The parameter.
        parameter: String,
    },
    /// The modulus of a rigid body is a parameter.
    #[error("body {body:?} is rigid: it has no modulus to differentiate by")]
    NoModulus {
        /// Name of the body.
        body: String,
    },
    /// The friction of a body is a parameter, but its material takes the friction of its partners.
    #[error(
        "body {body:?} has no friction of its own, but takes the friction of its partners: give its material a friction to differentiate by"
    )]
    NoOwnFriction {
        /// Name of the body.
        body: String,
    },
    /// Derivatives by the coefficients of friction of two bodies that may touch, both of which are 0: the
    /// coefficient of the pair, 2ab/(a + b), has none there, only directional ones, 0 by each and not 0
    /// by both.
    #[error(
        "bodies {:?} and {:?} both have the friction 0, where that of the pair has no derivative by both: take one alone, or begin above 0",
        .bodies[0], .bodies[1]
    )]
    NoFriction {
        /// Names of the two bodies, in the order of the world's.
        bodies: [String; 2],
    },
    /// The number of values or changes is not that of the parameters.
    #[error("the parameters have {expected} numbers, but got {found} values or changes")]
    NumberCount {
        /// Number of values or changes that were passed.
        found: usize,
        /// Number of numbers of the parameters.
        expected: usize,
    },
    /// A number of the outcome is NaN or infinite, at states that are finite.
    #[error(
        "number {row} of the outcome, counted from 0, is {value}, but must be finite: the outcome may divide by zero, or take a root or a logarithm of a negative number"
    )]
    OutcomeNotFinite {
        /// Index of the number.
        row: usize,
        /// Its value.
        value: f64,
    },
    /// A derivative of a state is not finite, and neither is one of the outcome's by the same number.
    #[error(
        "step {step} (t = {time} s) took body {body:?} to a state whose derivative by {number} is not finite: a force may take a root or a norm of zero"
    )]
    StateDerivativeNotFinite {
        /// The first step that gave such a state, counted from 1.
        step: usize,
        /// The time of the state (s).
        time: f64,
        /// Name of the body.
        body: String,
        /// Which number of the parameters it is by, the first if there are several: a name as in
        /// [`DifferenceCheck::numbers`](super::DifferenceCheck::numbers).
        number: String,
        /// What was computed. Columns that are finite are right.
        found: Box<OutcomeJacobian>,
    },
    /// A derivative of the outcome is not finite, though those of all states are.
    #[error(
        "number {row} of the outcome, counted from 0, has a derivative by {number} that is not finite, though those of all states are: the outcome may take a root or a norm of zero"
    )]
    OutcomeDerivativeNotFinite {
        /// Which number of the outcome: the row of the Jacobian.
        row: usize,
        /// Which number of the parameters it is by, the first if there are several: a name as in
        /// [`DifferenceCheck::numbers`](super::DifferenceCheck::numbers).
        number: String,
        /// What was computed. Numbers that are finite are right.
        found: Box<OutcomeJacobian>,
    },
    /// A derivative by a state is not finite, in a sweep from the outcome back to the start.
    #[error(
        "the derivative of the outcome by the state of body {body:?} before step {step} is not finite: the outcome or a force may take a root or a norm of zero"
    )]
    BackwardNotFinite {
        /// The last step, counted from 1, that such a derivative leads back to; one more than there are if the outcome has none
        /// by the last state.
        step: usize,
        /// Name of the body.
        body: String,
    },
    /// There is no number of this name for the world's forces.
    #[error("the world has no force parameter {0:?}")]
    NoForceParameter(String),
    /// Derivatives by a center of mass in a world whose forces may depend on it.
    #[error(
        "the derivatives by the mass properties of body {0:?} are not known, because forces act that may depend on its center of mass"
    )]
    ForcesByCenter(String),
    /// Derivatives by the vertices of a body whose mass properties are not those of its shape at a uniform density.
    #[error(
        "how the mass properties of body {0:?} depend on its vertices is not known: they are not those of its shape at a uniform density"
    )]
    NotUniform(String),
    /// Derivatives by recorded states do not pair up with the states.
    #[error(
        "derivatives by {states} recorded states of {bodies} bodies each were expected, but those given are by {}",
        bodies_given(found)
    )]
    CovectorCount {
        /// By how many bodies there are derivatives, for each state that there are any for.
        found: Vec<usize>,
        /// How many states are recorded.
        states: usize,
        /// How many bodies there are.
        bodies: usize,
    },
    /// The world has no control on the body, or it has not so many intervals.
    #[error("interval {interval} of the control of body {body:?} was asked for, but {}", intervals_found(*intervals))]
    NoControl {
        /// Name of the body.
        body: String,
        /// The interval asked for, counted from 0.
        interval: usize,
        /// How many there are.
        intervals: usize,
    },
    /// An outcome of more or fewer numbers in one rollout than in another: beside the world's parameters,
    /// or on other dual numbers.
    #[error(
        "the outcome has {found} numbers in one rollout and {expected} in another, but its length must not depend on values"
    )]
    OutcomeLength {
        /// How many numbers it has in the later one.
        found: usize,
        /// How many it has in the first.
        expected: usize,
    },
    /// A gradient was asked of an outcome that is not one number.
    #[error("a gradient needs an outcome of one number, but it has {count}: use a Jacobian")]
    NotALoss {
        /// How many numbers it has.
        count: usize,
    },
}

/// Checks that the numbers of an outcome are finite.
pub(super) fn check_outcome(numbers: &[f64]) -> Result<(), GradientError> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(row) => Err(GradientError::OutcomeNotFinite {
            row,
            value: numbers[row],
        }),
    }
}

/// Checks that outcomes have as many numbers as the first of them.
pub(super) fn same_length<'o>(
    outcomes: impl IntoIterator<Item = &'o DVector<f64>>,
) -> Result<(), GradientError> {
    let mut lengths = outcomes.into_iter().map(DVector::len);
    let Some(expected) = lengths.next() else {
        return Ok(());
    };
    match lengths.find(|&found| found != expected) {
        None => Ok(()),
        Some(found) => Err(GradientError::OutcomeLength { found, expected }),
    }
}

impl<T> From<RolloutFailure<T>> for GradientError {
    fn from(interrupted: RolloutFailure<T>) -> Self {
        interrupted.error.into()
    }
}

impl From<Panicked> for GradientError {
    fn from(panicked: Panicked) -> Self {
        RolloutError::from(panicked).into()
    }
}

/// Which intervals a body's control has.
fn intervals_found(intervals: usize) -> String {
    match intervals.checked_sub(1) {
        None => "the body has no control".into(),
        Some(last) => format!("its intervals are 0 to {last}"),
    }
}

/// How many bodies each of some states has, the first that differs from the first of all.
fn bodies_given(found: &[usize]) -> String {
    let count = found.len();
    let Some((&first, rest)) = found.split_first() else {
        return "no state".into();
    };
    match rest.iter().find(|&&bodies| bodies != first) {
        None => format!("{count} states of {first}"),
        Some(other) => format!("{count} states, of {first} and of {other}"),
    }
}
