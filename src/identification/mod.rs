//! Identification of a world from measured motions: estimates of moduli, dissipation, friction and other numbers, with their
//! uncertainty.
//!
//! An [`Identification`] has a world as a template, a plan, and the [`Unknown`]s that all measurements share. A [`Measurement`] is a
//! recorded motion of the bodies of the world. Each measurement has its own [`Nuisance`] numbers, such as the errors of its initial
//! state. [`Identification::fit`] minimizes
//!
//! Σ ½ρ(s) + Σ ½(deviation from the prior)²
//!
//! over unknowns and nuisances. The first sum is over all measured poses, with the squared deviation s of the simulated pose in units
//! of the [`Noise`], and a [`RobustLoss`] ρ. The minimizer is the Levenberg–Marquardt method with exact derivatives of the rollouts.
//! The nuisances of each measurement are eliminated by Schur complements, so that the computing time is proportional to the number
//! of measurements. Rollouts are spread over all threads, or an [`Evaluator`] spreads them over other machines.
//!
//! Motions through impacts are sensitive to their initial state. Two methods help:
//!
//! - Growing horizons: [`Identification::with_horizons`] fits the beginning of each motion first.
//! - Multiple shooting: [`Measurement::windows`] divides a measurement into short ones, each with an initial state of its own.
//!
//! ```
//! use hydroelastic::contact::{HalfSpace, Shape};
//! use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, World};
//! use hydroelastic::gradient::Parameter;
//! use hydroelastic::identification::{Identification, Measurement, Noise, Unknown};
//! use hydroelastic::mesh::shapes;
//! use hydroelastic::spatial::Pose;
//! use nalgebra::vector;
//!
//! let world = |friction| -> Result<World, Box<dyn std::error::Error>> {
//!     let skin = Material::elastic(1e6).with_friction(friction);
//!     let block = Body::dynamic("block", Shape::new(shapes::cuboid([0.1; 3])?), skin, Mass::Total(1.0))?
//!         .with_pose(Pose::from_translation(vector![0.0, 0.0, 0.0499]))
//!         .with_velocity(vector![1.0, 0.0, 0.0]);
//!     let table = Body::fixed("table", HalfSpace::rigid(), Material::rigid())?;
//!     Ok(World::new(vec![block, table])?.with_gravity(vector![0.0, 0.0, -9.81])?)
//! };
//! let plan = Plan::new(1e-2, 10)?.with_integrator(Integrator::Sdirk3);
//! let recorded = world(0.2)?.rollout(&plan).run()?; // a real recording has noise
//! let unknown = Unknown::new(Parameter::friction("block")).logarithmic();
//! let template = world(0.5)?;
//! let identification = Identification::new(&template, &plan, &[unknown])?.with_noise(Noise::new(1e-3, 1e-2)?);
//! let fit = identification.fit(&[Measurement::new("slide", recorded)])?;
//! assert!((fit.estimates[0].value - 0.2).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod checkpoint;
mod coordinates;
mod deviations;
mod equations;
mod error;
mod evaluator;
mod fit;
mod fitting;
mod measurement;
mod minimizer;
mod noise;
mod prediction;
mod problem;
mod robust_loss;
#[cfg(feature = "serde")]
mod serial;
#[cfg(test)]
mod tests;
mod trial;
mod unknown;

pub use checkpoint::{Checkpoint, Iteration};
pub use equations::Equations;
pub use error::IdentificationError;
pub use evaluator::{Evaluated, Evaluator};
pub use fit::{Direction, Estimate, Fit};
pub use measurement::Measurement;
pub use minimizer::{FittedMeasurement, Termination};
pub use noise::Noise;
pub use prediction::{Prediction, StartingState};
pub use problem::Identification;
pub use robust_loss::RobustLoss;
pub use unknown::{Nuisance, Unknown};
