//! A ball above an incline.

use super::Answer;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, Trajectory, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Vector3, vector};

pub const GRAVITY: f64 = 9.81;

/// Angle θ of the slope (rad).
pub const SLOPE: f64 = 0.3;

/// Radius (m) and mass (kg) of the ball, and height (m) of its center above the first point of contact.
pub const RADIUS: f64 = 0.1;
const MASS: f64 = 1.0;
const DROP_HEIGHT: f64 = 0.6;

/// Hydroelastic modulus (Pa), dissipation (s/m) and coefficient of friction of ball and slope.
const MODULUS: f64 = 3e7;
const DISSIPATION: f64 = 0.35;
const FRICTION: f64 = 0.5;

/// Time step (s), number of steps, and steps between recorded states.
const TIME_STEP: f64 = 2e-4;
const STEPS: usize = 9_000;
const RECORDED: usize = 5;

/// Returns the direction down the slope.
pub fn downhill() -> Vector3<f64> {
    vector![SLOPE.cos(), 0.0, -SLOPE.sin()]
}

/// Returns the world and its trajectory. The slope's surface contains the origin.
pub fn rolled_down() -> Answer<(World, Trajectory)> {
    let elastic = Material::elastic(MODULUS);
    let skin = elastic
        .with_dissipation(DISSIPATION)
        .with_friction(FRICTION);
    let ball = Shape::new(shapes::icosphere(RADIUS, 4)?);
    let solid = MassProperties::solid_ball(MASS, RADIUS);
    let slope = Shape::new(shapes::cuboid([8.0, 1.0, 0.4])?);
    let turned = Pose::from_rotation_vector(&vector![0.0, SLOPE, 0.0], Vector3::zeros());
    let below = turned * Pose::from_translation(vector![0.0, 0.0, -0.2]);
    let above = Pose::from_translation(vector![0.0, 0.0, DROP_HEIGHT]);
    let world = World::new(vec![
        Body::dynamic("ball", ball, skin, Mass::Properties(solid))?.with_pose(above),
        Body::fixed("slope", slope, skin)?.with_pose(below),
    ])?
    .with_gravity(vector![0.0, 0.0, -GRAVITY])?;
    let plan = Plan::new(TIME_STEP, STEPS)?.recording_every(RECORDED);
    let trajectory = world.rollout(&plan).run()?;
    Ok((world, trajectory))
}
