//! A soft block on the ground, and a steel tool above it.

use super::hand::Hand;
use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, World, WorldError};
use hydroelastic::io::{Placement, read_triangle_surface};
use hydroelastic::mesh::{PressureField, TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::error::Error;

/// Indices of the bodies in the world.
pub const BLOCK: usize = 0;
pub const TOOL: usize = 1;

/// File written by make_tool.py, in millimeters.
const TOOL_FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tool_use/tool.stl");
const MILLIMETER: f64 = 0.001;
/// Density of the tool (kg/m³).
const STEEL: f64 = 7850.0;

/// Edges of the block (m).
pub const BLOCK_SIZE: [f64; 3] = [0.12, 0.08, 0.03];
/// Density of the block (kg/m³).
const RUBBER: f64 = 1100.0;
/// Modulus of the block (Pa). The block has no dissipation, which would add drag on the tool's flanks.
pub const MODULUS: f64 = 5e5;
/// Coefficients of friction of the block, of the tool, and of the ground, which holds the block.
const FRICTIONS: [f64; 3] = [0.5, 0.3, 1.0];
/// Slip tolerance (m/s), below which friction is less than full.
const SLIP_TOLERANCE: f64 = 1e-4;

/// Number of steps per second.
pub const RATE: f64 = 500.0;
pub const STEPS: usize = 225;

/// Returns the surface of the hook (m), its lowest point at the origin.
pub fn tool() -> Result<TriangleSurface, Box<dyn Error>> {
    Ok(read_triangle_surface(
        TOOL_FILE,
        &Placement::from_unit(MILLIMETER),
    )?)
}

/// Returns the field of the block, its center at the origin.
pub fn block() -> Result<PressureField, Box<dyn Error>> {
    Ok(shapes::cuboid(BLOCK_SIZE)?)
}

/// Returns the pressure gradient below the upper face of the block (Pa/m). The depth of the core is half the height.
pub fn slope() -> f64 {
    2.0 * MODULUS / BLOCK_SIZE[2]
}

/// Returns the world in which the tool is guided along a path with this lowest height (m).
pub fn world(lowest: f64) -> Result<World<f64, Hand>, Box<dyn Error>> {
    let [of_block, of_tool, of_ground] = FRICTIONS;
    let rubber = Material::elastic(MODULUS);
    let rigid = |friction| Material::rigid().with_friction(friction);
    let hand = Hand { tool: TOOL, lowest };
    let [start, _] = hand.path_at(0.0);
    let bodies = [
        Body::dynamic(
            "block",
            Shape::new(block()?),
            rubber.with_friction(of_block),
            Mass::Density(RUBBER),
        )?
        .with_pose(Pose::from_translation(vector![
            0.0,
            0.0,
            BLOCK_SIZE[2] / 2.0
        ])),
        Body::dynamic(
            "tool",
            RigidShape::new(tool()?),
            rigid(of_tool),
            Mass::Density(STEEL),
        )?
        .with_pose(Pose::from_translation(start)),
        Body::fixed("ground", HalfSpace::rigid(), rigid(of_ground))?,
    ];
    // Both bodies are rigid and would pass through each other.
    let world = World::builder()
        .bodies(bodies)
        .ignore("tool", "ground")
        .gravity(vector![0.0, 0.0, -9.81])
        .slip_tolerance(SLIP_TOLERANCE)
        .build()?;
    Ok(world.with_forces(hand)?)
}

/// Returns the coefficient of friction between block and tool: the harmonic mean.
pub fn friction() -> f64 {
    let [block, tool, _] = FRICTIONS;
    2.0 * block * tool / (block + tool)
}

/// Returns a plan with steps of implicit Euler, because all motion is slow and the outcome must have no jumps.
pub fn plan() -> Result<Plan, WorldError> {
    Ok(Plan::new(1.0 / RATE, STEPS)?.with_integrator(Integrator::ImplicitEuler))
}
