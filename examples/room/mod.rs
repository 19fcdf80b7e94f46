//! A room with a ball.

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Mass, Material, World};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::error::Error;
use std::f64::consts::FRAC_PI_2;

/// Initial position (m), radius (m) and mass (kg) of the ball.
const START: Vector3<f64> = Vector3::new(0.0, 0.0, 0.5);
pub const RADIUS: f64 = 0.05;
const MASS: f64 = 0.1;
/// Thickness (m) of the soft layer of floor and wall. Rigid ones would require shorter steps.
const LAYER: f64 = 0.25;
/// Slip tolerance (m/s), below which friction is less than full. At a tenth of this value, steps of half a millisecond are too long for a
/// ball that stops sliding.
const SLIP_TOLERANCE: f64 = 1e-2;
/// Position of the camera and the point in the middle of its view (m).
const EYE: Vector3<f64> = Vector3::new(-0.15, -1.25, 0.62);
const MIDDLE: Vector3<f64> = Vector3::new(0.42, 0.1, 0.27);

/// Returns a ball with a number of subdivisions and a velocity (m/s) between the floor z = 0 and the wall x = 1 m.
pub fn with_ball(subdivisions: usize, velocity: Vector3<f64>) -> Result<World, Box<dyn Error>> {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.05)
        .with_friction(0.3);
    let ball = Shape::new(shapes::icosphere(RADIUS, subdivisions)?);
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(MASS))?
        .with_pose(Pose::from_translation(START))
        .with_velocity(velocity);
    let soft = |name| Ok::<_, Box<dyn Error>>(Body::fixed(name, HalfSpace::layer(LAYER)?, skin)?);
    // This rotates the outward normal, z of the wall's frame, to −x.
    let upright =
        Pose::from_rotation_vector(&vector![0.0, -FRAC_PI_2, 0.0], vector![1.0, 0.0, 0.0]);
    let (floor, wall) = (soft("floor")?, soft("wall")?.with_pose(upright));
    let room = World::new(vec![ball, floor, wall])?.with_gravity(vector![0.0, 0.0, -9.81])?;
    Ok(room.with_slip_tolerance(SLIP_TOLERANCE)?)
}

/// Returns the recording with a camera.
pub fn seen(recording: Recording) -> Recording {
    recording.seen_from(EYE, MIDDLE)
}
