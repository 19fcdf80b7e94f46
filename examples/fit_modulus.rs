//! Does Gauss–Newton find a ball's modulus in a measured force–depth curve?
//!
//! `cargo run --release -p hydroelastic-examples --example fit_modulus`
//!
//! An indenter presses a soft ball against a rigid plate and records force and depth, with noise. The forces are those of the
//! closed form, F = πE(d² − 2d³/(3R)); the model is a mesh of the ball. The modulus is fitted by its logarithm: it stays
//! positive, and forces that are proportional to it take a few steps from a guess a hundred times off.

use hydroelastic::contact::{BodyError, ContactBody, ContactPair, Partner, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::f64::consts::PI;

/// Radius of the ball (m).
const RADIUS: f64 = 0.05;
/// Modulus of the ball (Pa), and the first guess of it.
const TRUTH: f64 = 1.3e5;
const GUESS: f64 = 1e3;
/// Number of readings, and the depth (m) of the last; the force is 74 N there.
const READINGS: u32 = 40;
const DEEPEST: f64 = 0.3 * RADIUS;
/// Standard deviation of the readings' noise (N).
const NOISE: f64 = 1.5;
/// Relative error of the modulus that the facets of the ball make at these depths.
const FACETS: f64 = 0.007;
/// A step of the logarithm below which nothing is left to correct.
const CONVERGED: f64 = 1e-9;
/// Most steps until then.
const STEPS: usize = 50;

/// A depth (m) and the force (N) measured there.
type Reading = (f64, f64);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut random = StdRng::seed_from_u64(1);
    // Uniform numbers between ∓√3 have standard deviation 1.
    let mut noise = || NOISE * 3.0_f64.sqrt() * random.random_range(-1.0..1.0);
    let depths = (1..=READINGS).map(|k| DEEPEST * f64::from(k) / f64::from(READINGS));
    let clean: Vec<Reading> = depths.map(|depth| (depth, force(depth))).collect();
    let noisy: Vec<Reading> = clean.iter().map(|&(d, f)| (d, f + noise())).collect();
    for (name, readings) in [("clean", clean), ("noisy", noisy)] {
        let (modulus, information) = fitted(&readings)?;
        let (error, deviation) = (modulus / TRUTH - 1.0, NOISE / information.sqrt());
        println!(
            "{name}: {modulus:.0} Pa, off by {error:+.4}; noise makes a deviation of {deviation:.4}"
        );
        let allowed = FACETS
            + if name == "noisy" {
                3.0 * deviation
            } else {
                0.0
            };
        assert!(error.abs() < allowed);
    }
    Ok(())
}

/// The closed form (N) on a rigid plate.
fn force(depth: f64) -> f64 {
    PI * TRUTH * (depth.powi(2) - 2.0 * depth.powi(3) / (3.0 * RADIUS))
}

/// The modulus (Pa) with the least squares of misfits, and Σ (∂F/∂log E)² (N²) there.
fn fitted(readings: &[Reading]) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    let ball = Shape::new(shapes::icosphere(RADIUS, 4)?);
    let mut modulus = GUESS;
    for _ in 0..STEPS {
        let (mut slope, mut information) = (0.0, 0.0);
        for &(depth, measured) in readings {
            let (force, by_modulus) = pressed(&ball, depth, modulus)?;
            let by_logarithm = modulus * by_modulus;
            slope += by_logarithm * (measured - force);
            information += by_logarithm * by_logarithm;
        }
        // At most by a factor e: far from the answer the step of a linear model is too long.
        let step = (slope / information).clamp(-1.0, 1.0);
        modulus *= step.exp();
        if step.abs() < CONVERGED {
            return Ok((modulus, information));
        }
    }
    Err(format!("not converged after {STEPS} steps, at {modulus} Pa").into())
}

/// The force (N) on the ball of this modulus (Pa) at a depth (m) in the plate, and its derivative by the modulus (N/Pa).
fn pressed(ball: &Shape, depth: f64, modulus: f64) -> Result<(f64, f64), BodyError> {
    let center = Pose::from_translation(vector![0.0, 0.0, RADIUS - depth]);
    let ball = ContactBody::new(ball, center, modulus)?;
    let plate = Partner::rigid_half_space(Pose::identity())?;
    let contact = ContactPair::new(ball, plate).linearized();
    Ok((contact.wrench.on_a.force.z, contact.by_moduli[(5, 0)]))
}
