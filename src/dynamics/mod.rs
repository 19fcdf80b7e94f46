//! Rigid-body dynamics with hydroelastic contact: a [`World`] of bodies, stepped forward in time.
//!
//! A [`Body`] is a shape with a material, a mass and an initial state. A [`World`] is a list of bodies with gravity, [forces](Force) and
//! [controls](Control). A [`Rollout`] is an iterator over the states of a world, and a [`Batch`] runs many independent rollouts.
//! All types are generic over the scalar. A rollout on dual numbers carries the derivatives of every later state with respect to the
//! seeded numbers; [`crate::gradient`] seeds them.
//!
//! ```
//! use hydroelastic::contact::Shape;
//! use hydroelastic::dynamics::{Body, Mass, Material, Plan, World};
//! use hydroelastic::mesh::shapes;
//! use hydroelastic::spatial::Pose;
//! use nalgebra::Vector3;
//!
//! let ball = Shape::new(shapes::icosphere(0.1, 1)?);
//! let floor = Shape::new(shapes::cuboid([1.0, 1.0, 0.2])?);
//! let skin = Material::elastic(1e5);
//! let world = World::new(vec![
//!     Body::dynamic("ball", ball, skin, Mass::Total(1.0))?
//!         .with_pose(Pose::from_translation(Vector3::new(0.0, 0.0, 0.3))),
//!     Body::fixed("floor", floor, skin)?,
//! ])?
//! .with_gravity(Vector3::new(0.0, 0.0, -9.81))?;
//!
//! let trajectory = world.rollout(&Plan::new(1e-3, 400)?).run()?;
//! let lowest = trajectory.states().iter().map(|s| s.bodies[0].position().z);
//! assert!(lowest.fold(f64::INFINITY, f64::min) < 0.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! With the feature `serde`, [`BodyState`], [`State`], [`Material`] and [`Trajectory`] (`T = f64`) are saved with the names of their
//! fields. A trajectory is saved as `{ "states": [...] }`. Poses and twists are saved as in [`crate::spatial`]. Loading checks the
//! following:
//!
//! - A trajectory has at least one state, the same number of bodies in every state, and states in the order of time.
//! - Materials are in range.
//! - Every number is finite.
//!
//! A rollout that starts from a loaded state ([`Rollout::with_state`]) has the same bits as a rollout that starts from the saved state.

mod accuracy;
mod articulation;
mod batch;
mod body;
mod body_shape;
mod clearance;
mod contacts;
mod diagnostics;
mod dyn_world;
mod error;
mod force;
mod free_rotation;
mod half_space_outlines;
mod implicit;
mod inertia;
mod integrator;
mod joint;
mod joint_schedule;
#[cfg(feature = "serde")]
mod joint_serial;
mod kinetics;
mod loop_joint;
mod mass;
mod material;
mod mechanism;
mod model;
mod motion;
mod multibody;
mod plan;
mod reverse;
mod rigid_motion;
mod rollout;
mod rollout_error;
mod schedule;
#[cfg(feature = "serde")]
mod serial;
mod stability;
mod state;
mod stepper;
mod sweep;
mod tactile_image;
mod tangent;
mod trajectory;
mod validate;
mod workspace;
mod world;
mod world_builder;
#[cfg(feature = "serde")]
mod world_serial;
mod wrenches;

pub use accuracy::Accuracy;
pub use batch::{Batch, Job, Progress};
pub use body::Body;
pub use body_shape::BodyShape;
pub(crate) use clearance::{Approach, PairClearance};
pub use contacts::Contact;
pub use diagnostics::{ContactTopology, Diagnostics, Momentum};
pub(crate) use dyn_world::{DynWorld, WithModel};
pub use error::WorldError;
use force::TimeSpan;
pub use force::{
    Control, Drag, Force, ForceContext, ForceNumber, Spring, Thruster, WrenchAccumulator,
};
pub use implicit::{BodyErrors, EnergyBalance, StepReport, Work};
pub use inertia::Inertia;
pub use integrator::Integrator;
pub use joint::{Actuator, Joint, JointKind, JointLaw, JointState, Mimic, Stops};
pub use kinetics::{ForwardDynamicsDerivatives, InverseDynamicsDerivatives, Kinetics};
pub use loop_joint::LoopJoint;
pub use mass::Mass;
pub(crate) use mass::check_mass_number;
pub use material::Material;
pub use mechanism::Mechanism;
pub(crate) use model::Model;
pub use motion::KinematicPath;
pub(crate) use motion::Motion;
pub use plan::Plan;
pub use reverse::{BodyStateGradient, JointStateGradient, Kink, KinkSummary, StateGradient};
pub(crate) use reverse::{ModelGradient, ReverseSweep, Tape};
pub(crate) use rigid_motion::turn_between;
pub use rollout::Rollout;
pub use rollout_error::RolloutError;
pub use schedule::Schedule;
pub use state::{BodyState, State};
pub(crate) use tangent::{STATE_DIM, TangentPart};
pub use trajectory::{RolloutFailure, RolloutResult, Trajectory};
pub use world::World;
pub use world_builder::WorldBuilder;
