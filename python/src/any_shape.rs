//! Conversion of shapes of all kinds: of Python arguments, and of results.

use crate::errors::value_error;
use crate::half_space::HalfSpace;
use crate::rigid_shape::RigidShape;
use crate::shape::Shape;
use hydroelastic::contact::{BodyError, Partner};
use hydroelastic::dynamics::BodyShape;
use hydroelastic::spatial::Pose;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::sync::Arc;

/// Shape of any kind.
#[derive(Clone, IntoPyObject)]
pub enum AnyShape {
    Compliant(Shape),
    Rigid(RigidShape),
    HalfSpace(HalfSpace),
}

/// Converts an argument to a shape.
pub fn shape(argument: &Bound<'_, PyAny>) -> PyResult<AnyShape> {
    if let Ok(it) = argument.cast::<Shape>() {
        return Ok(AnyShape::Compliant(it.get().clone()));
    }
    if let Ok(it) = argument.cast::<RigidShape>() {
        return Ok(AnyShape::Rigid(it.get().clone()));
    }
    match argument.cast::<HalfSpace>() {
        Ok(it) => Ok(AnyShape::HalfSpace(it.get().clone())),
        Err(_) => Err(PyTypeError::new_err(format!(
            "a shape must be a Shape, a RigidShape or a HalfSpace, but is {}",
            argument.repr()?
        ))),
    }
}

impl AnyShape {
    /// Converts the shape of a body of the library.
    pub fn of(shape: &BodyShape) -> PyResult<Self> {
        match shape {
            BodyShape::Compliant(it) => Ok(Self::Compliant(Shape(Arc::clone(it)))),
            BodyShape::Rigid(it) => Ok(Self::Rigid(RigidShape(Arc::clone(it)))),
            BodyShape::HalfSpace(it) => Ok(Self::HalfSpace(HalfSpace(Arc::clone(it)))),
            other => Err(value_error(format!(
                "there is no class for the shape {other:?}"
            ))),
        }
    }

    /// Converts to the shape of a body of the library.
    pub fn inner(&self) -> BodyShape {
        match self {
            Self::Compliant(it) => BodyShape::Compliant(Arc::clone(&it.0)),
            Self::Rigid(it) => BodyShape::Rigid(Arc::clone(&it.0)),
            Self::HalfSpace(it) => BodyShape::HalfSpace(Arc::clone(&it.0)),
        }
    }

    /// Creates the partner of a compliant body, at a pose and with a modulus (Pa). Rigid shapes ignore the modulus.
    pub fn partner(&self, pose: Pose, modulus: f64) -> Result<Partner<'_>, BodyError> {
        match self {
            Self::Compliant(it) => Ok(it.at(pose, modulus)?.into()),
            Self::Rigid(it) => Partner::rigid(&it.0, pose),
            Self::HalfSpace(it) => Partner::half_space(&it.0, pose, modulus),
        }
    }

    pub fn __repr__(&self) -> String {
        match self {
            Self::Compliant(it) => it.__repr__(),
            Self::Rigid(it) => it.__repr__(),
            Self::HalfSpace(it) => it.__repr__(),
        }
    }
}
