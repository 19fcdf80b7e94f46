//! A ball, thrown in a room.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::error::Error;

/// Radius (m), mass (kg) and modulus (Pa) of the ball, which is soft enough to flatten visibly.
const RADIUS: f64 = 0.1;
const MASS: f64 = 0.5;
const BALL_MODULUS: f64 = 4e4;
/// Modulus (Pa) of floor and wall.
const ROOM_MODULUS: f64 = 4e5;
/// Hunt–Crossley dissipation (s/m) and coefficient of friction of all bodies.
const DISSIPATION: f64 = 0.02;
const FRICTION: f64 = 0.4;
/// Slip tolerance (m/s), below which friction decreases. It exceeds the change of slip by friction in a time step, about μ F Δt · 7/(2 m) =
/// 0.04 m/s for the solid ball at 155 N. Below that, friction would oscillate.
const SLIP_TOLERANCE: f64 = 0.1;
/// Initial position (m) and velocity (m/s) of the ball.
const START: Vector3<f64> = Vector3::new(-0.3, -0.1, 0.31);
const VELOCITY: Vector3<f64> = Vector3::new(1.8, 0.2, -2.2);
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Returns a ball in the air, the floor z = 0 and the wall x = 0.5 m.
pub fn world() -> Result<World, Box<dyn Error>> {
    let ball = Shape::new(shapes::icosphere(RADIUS, 3)?);
    let ball = Body::dynamic("ball", ball, skin(BALL_MODULUS), Mass::Total(MASS))?
        .at(Pose::from_translation(START))
        .with_velocity(VELOCITY);
    let floor = slab("floor", [1.1, 0.6, 0.06], vector![-0.05, 0.0, -0.03])?;
    let wall = slab("wall", [0.06, 0.6, 0.6], vector![0.53, 0.0, 0.27])?;
    Ok(World::new(vec![ball, floor, wall])?
        .with_gravity(GRAVITY)?
        .with_slip_tolerance(SLIP_TOLERANCE)?)
}

/// Creates a fixed cuboid of the given edges (m) about a center (m).
fn slab(name: &str, edges: [f64; 3], center: Vector3<f64>) -> Result<Body, Box<dyn Error>> {
    let shape = Shape::new(shapes::cuboid(edges)?);
    let slab = Body::fixed(name, shape, skin(ROOM_MODULUS))?;
    Ok(slab.at(Pose::from_translation(center)))
}

fn skin(modulus: f64) -> Material {
    Material::elastic(modulus)
        .with_dissipation(DISSIPATION)
        .with_friction(FRICTION)
}
