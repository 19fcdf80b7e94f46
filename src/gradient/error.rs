use super::{JointQuantity, OutcomeJacobian};
use crate::dynamics::{RolloutError, RolloutFailure, WorldError};
use crate::mesh::DensityError;
use crate::parallel::Panicked;
use nalgebra::DVector;

/// Reason why a gradient cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GradientError {
    /// The world or the body of a parameter is invalid.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The rollout did not reach its end.
    #[error(transparent)]
    Rollout(#[from] RolloutError),
    /// The density of a body is out of range, or its mass properties are not finite.
    #[error(transparent)]
    Density(#[from] DensityError),
    /// The parameter belongs to a fixed or kinematic body, which forces do not move.
    #[error(
        "{parameter} has no effect, because forces do not move body {body:?}: it is fixed or follows a path"
    )]
    NotDynamic {
        /// Name of the body.
        body: String,
        /// The parameter.
        parameter: String,
    },
    /// The initial pose or velocity of a body on a joint is a parameter.
    #[error(
        "{parameter} has no effect, because a joint gives the state of body {body:?}: use Parameter::joint with the initial position or velocity of the joint"
    )]
    OnJoint {
        /// Name of the body.
        body: String,
        /// The parameter.
        parameter: String,
    },
    /// A parameter names the initial state of a mimicking joint.
    #[error(
        "the {quantity} of joint {joint:?} is not a parameter, because the joint mimics {leader:?}: use the {quantity} of joint {leader:?}"
    )]
    MimickingJoint {
        /// Name of the joint.
        joint: String,
        /// Quantity of the parameter.
        quantity: JointQuantity,
        /// Name of the leader that has a state.
        leader: String,
    },
    /// Derivatives with respect to the shapes of a world with loop joints are requested.
    #[error("derivatives with respect to shapes are not available in worlds with loop joints")]
    LoopsWithShapes,
    /// The modulus of a rigid body is a parameter.
    #[error("body {body:?} is rigid: it has no modulus to differentiate with respect to")]
    NoModulus {
        /// Name of the body.
        body: String,
    },
    /// The friction of a body is a parameter, but its material uses the friction of its contact partners.
    #[error(
        "body {body:?} has no friction of its own, but uses the friction of its partners: set the friction of its material to differentiate with respect to it"
    )]
    NoOwnFriction {
        /// Name of the body.
        body: String,
    },
    /// The coefficients of friction of two bodies that can collide are both zero, and both are parameters. The coefficient of the
    /// pair, 2ab/(a + b), has only directional derivatives there: zero along each coefficient, and nonzero along both.
    #[error(
        "bodies {:?} and {:?} both have zero friction, so the friction of the pair has no derivative with respect to both: use one of them as a parameter, or start above zero",
        .bodies[0], .bodies[1]
    )]
    NoFriction {
        /// Names of the two bodies, in the order of the world.
        bodies: [String; 2],
    },
    /// The number of values or changes differs from the number of parameter components.
    #[error("the parameters have {expected} numbers, but got {found} values or changes")]
    NumberCount {
        /// Number of values or changes.
        found: usize,
        /// Number of parameter components.
        expected: usize,
    },
    /// Two of the parameters that get new values are the same parameter.
    #[error("{parameter} has two values, but must have one")]
    DuplicateParameter {
        /// The parameter.
        parameter: String,
    },
    /// The total number of steps of all rollouts exceeds [`usize::MAX`].
    #[error("{rollouts} rollouts of {steps} steps each have too many steps to count")]
    TooManySteps {
        /// Number of steps of each rollout.
        steps: usize,
        /// Number of rollouts.
        rollouts: usize,
    },
    /// An outcome component is NaN or infinite, although all states are finite.
    #[error(
        "number {row} of the outcome, counted from 0, is {value}, but must be finite: the outcome may divide by zero, or take a root or a logarithm of a negative number"
    )]
    OutcomeNotFinite {
        /// Index of the number.
        row: usize,
        /// Value of the number.
        value: f64,
    },
    /// Derivatives of a state and of the outcome with respect to one number of a parameter are not
    /// finite.
    #[error(
        "step {step} (t = {time} s) took body {body:?} to a state whose derivative with respect to {number} is not finite: a force may take a root or a norm of zero"
    )]
    StateDerivativeNotFinite {
        /// First step after which a derivative is not finite, counted from 1.
        step: usize,
        /// Time of the state (s).
        time: f64,
        /// Name of the body.
        body: String,
        /// Name of the parameter's number, as in
        /// [`DifferenceCheck::numbers`](super::DifferenceCheck::numbers). If there are several,
        /// this is the name of the first number.
        number: String,
        /// All computed derivatives. Finite columns are correct.
        found: Box<OutcomeJacobian>,
    },
    /// A derivative of the outcome is not finite, although the derivatives of all states are finite.
    #[error(
        "number {row} of the outcome, counted from 0, has a derivative with respect to {number} that is not finite, although the derivatives of all states are finite: the outcome may take a root or a norm of zero"
    )]
    OutcomeDerivativeNotFinite {
        /// Index of the outcome component, which is the row of the Jacobian.
        row: usize,
        /// Name of the parameter's number, as in
        /// [`DifferenceCheck::numbers`](super::DifferenceCheck::numbers). If there are several,
        /// this is the name of the first number.
        number: String,
        /// All computed derivatives. Finite numbers are correct.
        found: Box<OutcomeJacobian>,
    },
    /// A derivative with respect to a state is not finite in a reverse sweep.
    #[error(
        "the derivative of the outcome with respect to the state of body {body:?} before step {step} is not finite: the outcome or a force may take a root or a norm of zero"
    )]
    BackwardNotFinite {
        /// Last step, counted from 1, that starts from a state with a derivative that is not
        /// finite. This is the number of steps plus 1 if the derivative with respect to the final
        /// state is not finite.
        step: usize,
        /// Name of the body.
        body: String,
    },
    /// The forces of the world have no parameter of this name.
    #[error("the world has no force parameter {0:?}")]
    NoForceParameter(String),
    /// Derivatives with respect to the mass properties of a body are unknown, because forces may depend on its center of mass.
    #[error(
        "the derivatives with respect to the mass properties of body {0:?} are unknown, because the world has forces that may depend on its center of mass"
    )]
    ForcesByCenter(String),
    /// Derivatives with respect to the vertices of a body are unknown, because its mass properties
    /// are not the mass properties of its shape at a uniform density.
    #[error(
        "the mass properties of body {0:?} depend on its vertices in an unknown way: they are not those of its shape at a uniform density"
    )]
    NotUniform(String),
    /// The derivatives with respect to recorded states do not match the states.
    #[error(
        "expected derivatives with respect to {states} recorded states of {bodies} bodies and {joints} joints each, but got derivatives with respect to {}",
        count_text(found)
    )]
    CovectorCount {
        /// Numbers of bodies and of joints with derivatives, for each state with derivatives.
        found: Vec<[usize; 2]>,
        /// Number of recorded states.
        states: usize,
        /// Number of bodies.
        bodies: usize,
        /// Number of joints with a state.
        joints: usize,
    },
    /// The world has no control of the body, or the control has fewer intervals.
    #[error("interval {interval} of the control of body {body:?} does not exist: {}", interval_text(*intervals))]
    NoControl {
        /// Name of the body.
        body: String,
        /// Index of the interval, counted from 0.
        interval: usize,
        /// Number of intervals, or 0 without a control.
        intervals: usize,
    },
    /// Derivatives with respect to the mass properties of a massless body are requested.
    #[error(
        "body {0:?} is massless: derivatives with respect to its mass properties are not available"
    )]
    Massless(String),
    /// The joint has no schedule, or the index is beyond the values of the schedule.
    #[error("the {quantity} of joint {joint:?} does not exist: the schedule has {count} values")]
    NotScheduled {
        /// Name of the joint.
        joint: String,
        /// Scheduled torque or target.
        quantity: JointQuantity,
        /// Number of values, or 0 without a schedule.
        count: usize,
    },
    /// The length of the outcome differs between rollouts: at perturbed parameters, or on other dual numbers.
    #[error(
        "the outcome has {found} numbers in one rollout and {expected} in another, but its length must not depend on values"
    )]
    OutcomeLength {
        /// Length in the later rollout.
        found: usize,
        /// Length in the first rollout.
        expected: usize,
    },
    /// The outcome of a gradient is not one number.
    #[error(
        "a gradient requires an outcome of one number, but the outcome has {count}: use a Jacobian"
    )]
    NotALoss {
        /// Length of the outcome.
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

/// Returns the only number of an outcome.
pub(super) fn loss_of(numbers: &[f64]) -> Result<f64, GradientError> {
    match numbers {
        [loss] => Ok(*loss),
        _ => Err(GradientError::NotALoss {
            count: numbers.len(),
        }),
    }
}

/// Checks that all outcomes have the same length.
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
    fn from(failure: RolloutFailure<T>) -> Self {
        failure.error.into()
    }
}

impl From<Panicked> for GradientError {
    fn from(panicked: Panicked) -> Self {
        RolloutError::from(panicked).into()
    }
}

/// Describes the intervals of the control of a body.
fn interval_text(intervals: usize) -> String {
    match intervals.checked_sub(1) {
        None => "the body has no control".into(),
        Some(last) => format!("its intervals are 0 to {last}"),
    }
}

/// Describes the number of states, the counts of the first state, and the first counts that differ from them.
fn count_text(counts: &[[usize; 2]]) -> String {
    let state_count = counts.len();
    let Some((&first, rest)) = counts.split_first() else {
        return "no state".into();
    };
    let text = |[bodies, joints]: [usize; 2]| format!("{bodies} bodies and {joints} joints");
    match rest.iter().find(|&&different| different != first) {
        None => format!("{state_count} states of {}", text(first)),
        Some(&different) => format!(
            "{state_count} states, of {} and of {}",
            text(first),
            text(different)
        ),
    }
}
