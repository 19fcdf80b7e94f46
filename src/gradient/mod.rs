//! Derivatives of rollouts, in forward mode (dual numbers) and in reverse mode (adjoints).
//!
//! An [`Experiment`] differentiates any [`Outcome`] of a rollout with respect to any selection of named [`Parameter`]s.
//! [`Experiment::difference_check`] compares the derivatives with differences of the same steps.
//! [`Experiment::derivative_check`] compares them with the slopes of the motion.
//!
//! ```
//! use hydroelastic::contact::Shape;
//! use hydroelastic::dynamics::{Plan, Body, Mass, Material, World};
//! use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
//! use hydroelastic::mesh::shapes;
//! use nalgebra::Vector3;
//!
//! let ball = Shape::new(shapes::icosphere(0.1, 1)?);
//! let world = World::new(vec![Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?])?
//!     .with_gravity(Vector3::new(0.0, 0.0, -9.81))?;
//! let experiment = Experiment::new(&world, &Plan::new(1e-3, 500)?);
//! let outcome = FinalPosition::of_body(&world, "ball")?;
//! let by_velocity = experiment.jacobian(&[Parameter::initial_velocity("ball")], &outcome)?;
//! assert!((by_velocity.jacobian[(0, 0)] - 0.5).abs() < 1e-12); // half a second of flight
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`dual_wrench_jacobian`] is the reference for tests of the closed form,
//! [`ContactPair::linearized`](crate::contact::ContactPair::linearized). It computes the same numbers independently, by
//! differentiating every slicing and clipping operation. Its derivatives may be wrong if a vertex of one body lies exactly in a
//! face of a tetrahedron of the other body.
//!
//! To compute any other derivative, call num-dual on the functions of the library:
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

#[cfg(feature = "argmin")]
mod argmin;
mod batch;
mod clearance;
mod derivative_check;
mod difference_check;
mod dual_jacobian;
mod dual_widths;
mod error;
mod experiment;
mod linearized;
mod mode;
mod motion_slopes;
mod non_finite;
mod outcome;
mod outcome_covectors;
mod parameter;
mod passes;
mod problem;
mod reverse;
mod rollout_gradient;
#[cfg(feature = "serde")]
mod serial;
mod slots;
mod values;
mod verdict;
mod vjp;

pub use clearance::{FirstContact, RolloutClearance};
pub use difference_check::DifferenceCheck;
pub use dual_jacobian::dual_wrench_jacobian;
pub use error::GradientError;
pub use experiment::Experiment;
pub use linearized::LinearizedRollout;
pub use mode::Mode;
pub use outcome::{
    FinalPosition, FinalState, Integrand, Outcome, OutcomeJacobian, RecordedStates, TimeIntegral,
};
pub use parameter::{JointQuantity, Parameter};
pub use problem::Problem;
pub use rollout_gradient::{HoldFixed, RolloutGradient};
pub use verdict::{CheckedDerivative, DerivativeCheck, Verdict};
pub use vjp::VectorJacobianProduct;
