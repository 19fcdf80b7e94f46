//! A block with its weight off center on soft ground.

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, Trajectory, World};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Vector3};
use std::error::Error;
use std::sync::Arc;

/// Moduli (Pa) of block and ground, and their dissipation (s/m).
pub const MODULI: [f64; 2] = [2e5, 5e4];
const DISSIPATION: f64 = 5.0;
/// Gravity (m/s²), mass of the block (kg), and position of its center of mass (m) relative to its middle.
pub const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
pub const MASS: f64 = 2.0;
pub const CENTER_OF_MASS: Vector3<f64> = Vector3::new(0.02, -0.01, -0.01);
/// Time step (s) and number of steps. The steps are implicit, so a resting block stays at rest at any step size.
const TIME_STEP: f64 = 5e-3;
const STEPS: usize = 200;

/// Returns the motion of the block after its release.
pub fn released(
    block: &Arc<Shape>,
    ground: &HalfSpace,
    pose: Pose,
) -> Result<(World, Trajectory), Box<dyn Error>> {
    let solid = MassProperties {
        mass: MASS,
        center_of_mass: CENTER_OF_MASS,
        inertia: Matrix3::identity() * 0.01,
    };
    let skin = |modulus| Material::elastic(modulus).with_dissipation(DISSIPATION);
    let [block_skin, ground_skin] = MODULI.map(skin);
    let block = Body::dynamic(
        "block",
        Arc::clone(block),
        block_skin,
        Mass::Properties(solid),
    )?;
    let ground = Body::fixed("ground", ground.clone(), ground_skin)?;
    let world = World::new(vec![block.with_pose(pose), ground])?.with_gravity(GRAVITY)?;
    let plan = Plan::new(TIME_STEP, STEPS)?.with_integrator(Integrator::Sdirk3);
    let trajectory = world.rollout(&plan).run()?;
    Ok((world, trajectory))
}
