//! Derivatives by dual numbers: seed the inputs, run the pipeline, read the derivatives.
//!
//! [`dual_wrench_jacobian`] is the reference that the closed form of
//! [`ContactPair::wrench_and_jacobian`](crate::contact::ContactPair::wrench_and_jacobian) is
//! checked against: the same numbers by an independent way, differentiating through every slice
//! and clip. Any other derivative is a call of num-dual on the library's functions:
//!
//! ```
//! use hydroelastic::contact::{ContactBody, ContactPair, Shape};
//! use hydroelastic::mesh::shapes;
//! use hydroelastic::scalar::lift;
//! use hydroelastic::spatial::Pose;
//! use nalgebra::{Vector3, vector};
//! use num_dual::{DualSVec64, gradient};
//!
//! let ball = Shape::new(shapes::icosphere(0.1, 1)?);
//! let energy = |position: Vector3<DualSVec64<3>>| {
//!     let a = ContactBody::new(&ball, Pose::from_translation(position), lift(1e5))?;
//!     let b = ContactBody::new(&ball, Pose::identity(), lift(1e5))?;
//!     Ok::<_, hydroelastic::contact::BodyError>(ContactPair::new(a, b).potential_energy())
//! };
//! let (energy, slope) = gradient(energy, &vector![0.01, 0.02, 0.18])?;
//! assert!(energy > 0.0 && slope.z < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod wrench_jacobian;

pub use wrench_jacobian::dual_wrench_jacobian;
