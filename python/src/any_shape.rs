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
    if let Ok(shape) = argument.cast::<Shape>() {
        return Ok(AnyShape::Compliant(shape.get().clone()));
    }
    if let Ok(shape) = argument.cast::<RigidShape>() {
        return Ok(AnyShape::Rigid(shape.get().clone()));
    }
    match argument.cast::<HalfSpace>() {
        Ok(half_space) => Ok(AnyShape::HalfSpace(half_space.get().clone())),
        Err(_) => Err(PyTypeError::new_err(format!(
            "a shape must be a Shape, a RigidShape or a HalfSpace, but is {}",
            argument.repr()?
        ))),
    }
}

/// Converts an argument to a shape, or None.
pub fn optional_shape(argument: &Bound<'_, PyAny>) -> PyResult<Option<AnyShape>> {
    if argument.is_none() {
        return Ok(None);
    }
    shape(argument).map(Some)
}

impl AnyShape {
    /// Converts the shape of a body of the library. The result is `None` for a body without a shape.
    pub fn of(shape: &BodyShape) -> PyResult<Option<Self>> {
        let shape = match shape {
            BodyShape::Compliant(shape) => Self::Compliant(Shape(Arc::clone(shape))),
            BodyShape::Rigid(shape) => Self::Rigid(RigidShape(Arc::clone(shape))),
            BodyShape::HalfSpace(half_space) => Self::HalfSpace(HalfSpace(Arc::clone(half_space))),
            BodyShape::None => return Ok(None),
            unknown => {
                return Err(value_error(format!(
                    "there is no class for the shape {unknown:?}"
                )));
            }
        };
        Ok(Some(shape))
    }

    /// Converts to the shape of a body of the library.
    pub fn inner(&self) -> BodyShape {
        match self {
            Self::Compliant(shape) => BodyShape::Compliant(Arc::clone(&shape.0)),
            Self::Rigid(shape) => BodyShape::Rigid(Arc::clone(&shape.0)),
            Self::HalfSpace(half_space) => BodyShape::HalfSpace(Arc::clone(&half_space.0)),
        }
    }

    /// Creates the partner of a compliant body, at a pose and with a modulus (Pa). Rigid shapes ignore the modulus.
    pub fn partner(&self, pose: Pose, modulus: f64) -> Result<Partner<'_>, BodyError> {
        match self {
            Self::Compliant(shape) => Ok(shape.at(pose, modulus)?.into()),
            Self::Rigid(shape) => Partner::rigid(&shape.0, pose),
            Self::HalfSpace(half_space) => Partner::half_space(&half_space.0, pose, modulus),
        }
    }

    pub fn __repr__(&self) -> String {
        match self {
            Self::Compliant(shape) => shape.__repr__(),
            Self::Rigid(shape) => shape.__repr__(),
            Self::HalfSpace(half_space) => half_space.__repr__(),
        }
    }
}
