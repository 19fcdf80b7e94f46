//! A ball above a block.

use super::Answer;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, Trajectory, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Radius of the ball, and initial height of its center above the block (m).
pub const RADIUS: f64 = 0.05;
const HEIGHT: f64 = 0.4;

/// Hydroelastic modulus of ball and block (Pa).
const MODULUS: f64 = 3e6;

/// Time step (s) and number of steps.
const TIME_STEP: f64 = 1e-4;
const STEPS: usize = 18_000;

/// Drops a ball of 1 kg on a block whose upper face is z = 0, and returns every state. Both bodies have the dissipation (s/m).
pub fn drop_with(dissipation: f64) -> Answer<(World, Trajectory)> {
    let skin = Material::elastic(MODULUS).with_dissipation(dissipation);
    let ball = Shape::new(shapes::icosphere(RADIUS, 3)?);
    let block = Shape::new(shapes::cuboid([0.4, 0.4, 0.2])?);
    let at_height = |z| Pose::from_translation(vector![0.0, 0.0, z]);
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(1.0))?.with_pose(at_height(HEIGHT));
    let block = Body::fixed("block", block, skin)?.with_pose(at_height(-0.1));
    let world = World::new(vec![ball, block])?.with_gravity(vector![0.0, 0.0, -9.81])?;
    let trajectory = world.rollout(&Plan::new(TIME_STEP, STEPS)?).run()?;
    Ok((world, trajectory))
}
