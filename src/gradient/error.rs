use crate::dynamics::{Interrupted, RolloutError, WorldError};
use crate::threads::Panicked;

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
    /// The parameter belongs to a body that forces do not move.
    #[error("{parameter} has no effect, because body {body:?} is not dynamic")]
    NotDynamic {
        /// Name of the body.
        body: String,
        /// The parameter.
        parameter: String,
    },
    /// Changes and the numbers of the parameters do not pair up.
    #[error("{expected} numbers of parameters need as many changes, but got {found}")]
    ChangeCount {
        /// How many changes were given.
        found: usize,
        /// How many the parameters have.
        expected: usize,
    },
    /// A gradient was asked of an outcome that is not one number.
    #[error("a gradient needs an outcome of one number, but it has {count}: use a Jacobian")]
    NotALoss {
        /// How many numbers it has.
        count: usize,
    },
}

impl<T> From<Interrupted<T>> for GradientError {
    fn from(interrupted: Interrupted<T>) -> Self {
        interrupted.error.into()
    }
}

impl From<Panicked> for GradientError {
    fn from(panicked: Panicked) -> Self {
        RolloutError::from(panicked).into()
    }
}
