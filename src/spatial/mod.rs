//! Rigid-body quantities: [`Pose`], the exponential map, [`Twist`], [`Wrench`], [`MassProperties`].
//!
//! Poses are written in monogram notation: `pose_ab` maps coordinates in B to coordinates in A, so
//! that `pose_wb = pose_wa * pose_ab` cancels by eye. Angular parts come first in every 6-vector:
//! a twist is (angular, linear), a wrench is (torque, force).

mod mass_properties;
mod pose;
mod rotation;
mod twist;
mod wrench;

pub use mass_properties::MassProperties;
pub use pose::{Pose, PoseError};
pub(crate) use rotation::turn_from_real;
pub use rotation::{rotation_from_vector, skew};
pub(crate) use rotation::{times_constant, turned_about_own_axis};
pub use twist::Twist;
pub use wrench::Wrench;
