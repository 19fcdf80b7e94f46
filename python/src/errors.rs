//! Python exceptions that carry the error messages of the library.

use crate::trajectory::Trajectory;
use hydroelastic::dynamics::{self, RolloutError as RolloutCause};
use hydroelastic::gradient::GradientError;
use hydroelastic::io::FileError;
use hydroelastic::io::urdf::UrdfError;
use pyo3::PyTypeInfo;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::fmt::Display;
use std::io::{self, ErrorKind};

create_exception!(
    hydroelastic,
    HydroelasticError,
    PyValueError,
    "Invalid number, array, name or file. The message gives the reason."
);
create_exception!(
    hydroelastic,
    RolloutError,
    HydroelasticError,
    "Rollout that ended before its last step. The message gives the reason.\n\nThe attribute `trajectory` holds the states that were \
     recorded before the failure, or None if there are none."
);

/// Creates the exception for an invalid argument.
pub fn value_error(why: impl Display) -> PyErr {
    HydroelasticError::new_err(why.to_string())
}

/// Creates the exception for a file: a subclass of OSError for errors of the operating system.
pub fn file_error(why: FileError) -> PyErr {
    os_error(kind_of(&why), why)
}

/// Creates the exception for a robot: a subclass of OSError for errors of the operating system.
pub fn urdf_error(why: UrdfError) -> PyErr {
    let kind = match &why {
        UrdfError::Read { source, .. } => Some(source.kind()),
        UrdfError::MeshFile { source, .. } => kind_of(source),
        _ => None,
    };
    os_error(kind, why)
}

/// Kind of the error of the operating system, if there is one.
fn kind_of(why: &FileError) -> Option<ErrorKind> {
    match why {
        FileError::Read { source, .. } | FileError::Write { source, .. } => Some(source.kind()),
        _ => None,
    }
}

fn os_error(kind: Option<ErrorKind>, why: impl Display) -> PyErr {
    match kind {
        Some(kind) => io::Error::new(kind, why.to_string()).into(),
        None => value_error(why),
    }
}

/// Creates the exception for a rollout that ended early, without recorded states.
pub fn rollout_error_without_trajectory(why: &RolloutCause) -> PyErr {
    let message = match why {
        RolloutCause::Joints { body, .. } => format!(
            "explicit steps cannot integrate joints, but body {body:?} has a joint: use Integrator.SDIRK3 or Integrator.IMPLICIT_EULER"
        ),
        why => why.to_string(),
    };
    RolloutError::new_err(message)
}

/// Creates the exception for a rollout that ended early, with the recorded states.
pub fn rollout_error(py: Python<'_>, why: &RolloutCause, states: dynamics::Trajectory) -> PyErr {
    let error = rollout_error_without_trajectory(why);
    match error
        .value(py)
        .setattr("trajectory", Trajectory::from(states))
    {
        Ok(()) => error,
        Err(attribute_error) => attribute_error,
    }
}

/// Creates the exception for a derivative that could not be computed.
pub fn gradient_error(why: &GradientError) -> PyErr {
    match why {
        GradientError::Rollout(cause) => rollout_error_without_trajectory(cause),
        cause => value_error(cause),
    }
}

/// Sets the default of `trajectory` to None on the class [`RolloutError`].
pub fn complete(py: Python<'_>) -> PyResult<()> {
    RolloutError::type_object(py).setattr("trajectory", py.None())
}
