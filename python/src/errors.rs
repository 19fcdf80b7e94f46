//! Exceptions, with the messages of the library.

use crate::trajectory::Trajectory;
use hydroelastic::dynamics::{self, RolloutError as RolloutCause};
use hydroelastic::gradient::GradientError;
use pyo3::PyTypeInfo;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::fmt::Display;

create_exception!(
    hydroelastic,
    HydroelasticError,
    PyValueError,
    "A number, an array, a name or a file that the library refuses, with the reason."
);
create_exception!(
    hydroelastic,
    RolloutError,
    HydroelasticError,
    "A rollout that ended before its last step, with the reason. `trajectory` holds the states before, or is None where none \
     were recorded."
);

/// The exception for what is refused.
pub fn refused(why: impl Display) -> PyErr {
    HydroelasticError::new_err(why.to_string())
}

/// The exception for a rollout that ended early, without its states.
pub fn ended(why: &RolloutCause) -> PyErr {
    RolloutError::new_err(why.to_string())
}

/// The exception for a rollout that ended early, with the states that were recorded.
pub fn interrupted(py: Python<'_>, why: &RolloutCause, states: dynamics::Trajectory) -> PyErr {
    let error = ended(why);
    match error
        .value(py)
        .setattr("trajectory", Trajectory::from(states))
    {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// The exception for a derivative that was not found.
pub fn not_differentiated(why: &GradientError) -> PyErr {
    match why {
        GradientError::Rollout(cause) => ended(cause),
        other => refused(other),
    }
}

/// Gives [`RolloutError`] a `trajectory` of None until one is set.
pub fn complete(py: Python<'_>) -> PyResult<()> {
    RolloutError::type_object(py).setattr("trajectory", py.None())
}
