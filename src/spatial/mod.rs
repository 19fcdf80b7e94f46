//! Rigid-body quantities: [`Pose`], the exponential map, [`Twist`], [`Wrench`], [`MassProperties`].
//!
//! Poses are written in monogram notation: `pose_ab` maps coordinates in B to coordinates in A.
//! Inner letters cancel in a product, as in `pose_wb = pose_wa * pose_ab`. The angular part comes
//! first in every 6-vector: a twist is (angular, linear), and a wrench is (torque, force).
//!
//! With the feature `serde`, [`Pose`] and [`Twist`] (`T = f64`) are saved as
//!
//! ```json
//! { "rotation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "translation": [0.0, 0.0, 0.3] }
//! { "angular": [0.0, 0.0, 0.0], "linear": [0.5, 0.0, 0.0] }
//! ```
//!
//! The rotation is saved by the rows of its matrix, so that no bit is lost. Loading checks a pose
//! as [`Pose::new`] does. A rotation that is orthonormal to 1e-14 keeps its bits. Every rotation in
//! a rollout is that accurate. Less accurate rotations are corrected. With `serde_json`, enable its
//! feature `float_roundtrip`. Otherwise the last digit of some numbers changes.

mod isometry;
mod mass_properties;
mod pose;
mod rotation;
#[cfg(feature = "serde")]
mod serial;
mod twist;
mod wrench;

pub use mass_properties::{MassGradient, MassProperties};
pub use pose::{Pose, PoseError};
pub(crate) use rotation::{
    add_block, left_jacobian, times_constant, turn_from_real, turned_about_own_axis, turned_by,
    turned_real,
};
pub use rotation::{rotation_from_vector, skew};
pub use twist::Twist;
pub use wrench::Wrench;
