use super::Shape;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Pose, PoseError, Twist};

/// No pressure may rise by more than this (Pa/m): the square of its gradient would leave double precision.
pub(crate) const STEEPEST: f64 = 1e153;

/// Why a shape, a pose and a modulus are not a body.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// The pose is not finite or not rigid.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// The hydroelastic modulus is not a positive number.
    #[error("the hydroelastic modulus must be positive and finite, but is {0} Pa")]
    Modulus(f64),
    /// The modulus makes the pressure rise by more than contact can be computed with.
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
    /// A number of a surface law is out of range.
    #[error(
        "the {quantity} of a surface law is {value}, but dissipation and friction must be finite and not negative, and the slip tolerance must be from 1e-100 to 1e100 m/s"
    )]
    SurfaceLaw {
        /// Which number.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// There is no vertex of this index.
    #[error("vertex {vertex} of a body that has {count} vertices")]
    Vertex {
        /// Its index.
        vertex: usize,
        /// How many vertices there are.
        count: usize,
    },
}

/// Checks the hydroelastic modulus (Pa) of a compliant body whose extent rises by `steepest` (1/m) at most.
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

/// A shape somewhere in the world, with the modulus that turns its extents into pressures.
#[derive(Debug, Clone, Copy)]
pub struct ContactBody<'a, T = f64> {
    shape: &'a Shape,
    pose: Pose<T>,
    modulus: T,
}

impl<'a, T: Scalar> ContactBody<'a, T> {
    /// From the pose of the body frame in the world and the hydroelastic modulus (Pa).
    ///
    /// # Errors
    /// If the pose is not finite, its rotation not orthonormal, or the modulus not positive, or so large that the pressure
    /// rises by more than 1e153 Pa/m.
    pub fn new(shape: &'a Shape, pose: Pose<T>, modulus: T) -> Result<Self, BodyError> {
        let pose = pose.checked()?;
        check_modulus(real_part(modulus), shape.field().steepest())?;
        Ok(Self {
            shape,
            pose,
            modulus,
        })
    }

    /// From a pose and a modulus that were checked where they came in.
    #[inline]
    pub(crate) fn from_valid(shape: &'a Shape, pose: Pose<T>, modulus: T) -> Self {
        Self {
            shape,
            pose,
            modulus,
        }
    }

    /// The shape.
    #[must_use]
    pub fn shape(&self) -> &'a Shape {
        self.shape
    }

    /// Pose of the body frame in the world.
    #[must_use]
    pub fn pose(&self) -> &Pose<T> {
        &self.pose
    }

    /// Hydroelastic modulus (Pa).
    #[must_use]
    pub fn modulus(&self) -> T {
        self.modulus
    }
}

impl<'a> ContactBody<'a> {
    /// The body after a motion by a twist (see [`Pose::moved_by`]) and a change of its modulus
    /// (Pa), both with real part zero: a seed for derivatives, which leaves the values as they are.
    pub(crate) fn perturbed<T: Scalar>(&self, twist: &Twist<T>, change: T) -> ContactBody<'a, T> {
        ContactBody {
            shape: self.shape,
            pose: Pose::lifted(&self.pose).moved_by(twist),
            modulus: lift::<T>(self.modulus) + change,
        }
    }
}
