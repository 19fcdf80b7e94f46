use super::Shape;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Pose, PoseError, Twist};

/// Largest gradient of a pressure (Pa/m). The square of a larger gradient may overflow double precision.
pub(crate) const STEEPEST: f64 = 1e153;

/// The reason why a shape, a pose and a modulus do not make a body.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// The pose is not finite or not rigid.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// The hydroelastic modulus is not a positive number.
    #[error("the hydroelastic modulus must be positive and finite, but is {0} Pa")]
    Modulus(f64),
    /// The gradient of the pressure exceeds the limit of contact computations.
    #[error(
        "a hydroelastic modulus of {modulus:e} Pa makes the pressure rise by {slope:e} Pa/m, but {most:e} Pa/m is the most that can be computed with",
        most = STEEPEST
    )]
    Steep {
        /// The modulus (Pa).
        modulus: f64,
        /// The modulus times the steepest gradient of the extent (Pa/m).
        slope: f64,
    },
    /// A parameter of a surface law is out of range.
    #[error(
        "the {quantity} of a surface law is {value}, but dissipation and friction must be finite and not negative, and the slip tolerance must be from 1e-100 to 1e100 m/s"
    )]
    SurfaceLaw {
        /// Name of the parameter.
        quantity: &'static str,
        /// Value of the parameter.
        value: f64,
    },
    /// The vertex index is out of range.
    #[error("vertex {vertex} of a body that has {count} vertices")]
    Vertex {
        /// The index.
        vertex: usize,
        /// Number of vertices.
        count: usize,
    },
}

/// Checks the hydroelastic modulus (Pa) of a compliant body. `steepest` is the largest gradient of its extent (1/m).
pub(super) fn check_modulus(modulus: f64, steepest: f64) -> Result<(), BodyError> {
    let slope = modulus * steepest;
    if !(modulus > 0.0 && modulus.is_finite()) {
        Err(BodyError::Modulus(modulus))
    } else if slope > STEEPEST {
        Err(BodyError::Steep { modulus, slope })
    } else {
        Ok(())
    }
}

/// A shape with a pose in the world, and the modulus that converts its extents into pressures.
#[derive(Debug, Clone, Copy)]
pub struct ContactBody<'a, T = f64> {
    shape: &'a Shape,
    pose: Pose<T>,
    modulus: T,
}

impl<'a, T: Scalar> ContactBody<'a, T> {
    /// Creates a body from the pose of its frame in the world and its hydroelastic modulus (Pa).
    ///
    /// # Errors
    /// Returns an error if the pose is not finite, its rotation is not orthonormal, or the modulus is not positive and
    /// finite. Also returns an error if the gradient of the pressure exceeds 1e153 Pa/m.
    pub fn new(shape: &'a Shape, pose: Pose<T>, modulus: T) -> Result<Self, BodyError> {
        let pose = pose.checked()?;
        check_modulus(real_part(modulus), shape.field().steepest())?;
        Ok(Self {
            shape,
            pose,
            modulus,
        })
    }

    /// Creates a body from a pose and a modulus that have already been checked.
    #[inline]
    pub(crate) fn from_valid(shape: &'a Shape, pose: Pose<T>, modulus: T) -> Self {
        Self {
            shape,
            pose,
            modulus,
        }
    }

    /// Returns the shape.
    #[must_use]
    pub fn shape(&self) -> &'a Shape {
        self.shape
    }

    /// Returns the pose of the body frame in the world.
    #[must_use]
    pub fn pose(&self) -> &Pose<T> {
        &self.pose
    }

    /// Returns the hydroelastic modulus (Pa).
    #[must_use]
    pub fn modulus(&self) -> T {
        self.modulus
    }
}

impl<'a> ContactBody<'a> {
    /// Moves the body by a twist (see [`Pose::moved_by`]) and changes its modulus (Pa). Both changes must have real
    /// part zero: they seed derivatives and leave values unchanged.
    pub(crate) fn perturbed<T: Scalar>(&self, twist: &Twist<T>, change: T) -> ContactBody<'a, T> {
        ContactBody {
            shape: self.shape,
            pose: Pose::lifted(&self.pose).moved_by(twist),
            modulus: lift::<T>(self.modulus) + change,
        }
    }
}
