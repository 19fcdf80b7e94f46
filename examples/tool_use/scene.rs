//! A soft block on the ground, and a tool of steel over it.

use super::hand::Hand;
use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, World, WorldError};
use hydroelastic::io::read_triangle_surface;
use hydroelastic::mesh::{PressureField, TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::error::Error;

/// Places in the world's list.
pub const BLOCK: usize = 0;
pub const TOOL: usize = 1;

/// Made by make_tool.py, in millimeters.
const TOOL_FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tool_use/tool.stl");
const MILLIMETER: f64 = 0.001;
/// Density of the tool (kg/m³).
const STEEL: f64 = 7850.0;

/// Edges of the block (m).
pub const BLOCK_SIZE: [f64; 3] = [0.12, 0.08, 0.03];
/// Density of the block (kg/m³).
const RUBBER: f64 = 1100.0;
/// Modulus of the block (Pa). It has no dissipation, which would add a drag on the tool's flanks.
pub const MODULUS: f64 = 5e5;
/// Coefficients of friction of the block, of the tool, and of the ground, which holds the block.
const FRICTIONS: [f64; 3] = [0.5, 0.3, 1.0];
/// Speed (m/s) below which friction is not full.
const SLIP_TOLERANCE: f64 = 1e-4;

/// Steps per second.
pub const RATE: f64 = 500.0;
pub const STEPS: usize = 225;

/// The surface of the hook (m), its lowest point at the origin.
pub fn tool() -> Result<TriangleSurface, Box<dyn Error>> {
    Ok(read_triangle_surface(TOOL_FILE, MILLIMETER)?)
}

/// The field of the block, its center at the origin.
pub fn block() -> Result<PressureField, Box<dyn Error>> {
    Ok(shapes::cuboid(BLOCK_SIZE)?)
}

/// How fast the pressure grows below the upper face of the block (Pa/m): the core is half the height deep.
pub fn slope() -> f64 {
    2.0 * MODULUS / BLOCK_SIZE[2]
}

/// The world in which the tool is guided along a path with this lowest height (m).
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
    // Both are rigid: they would pass through each other.
    let world = World::builder()
        .bodies(bodies)
        .ignore("tool", "ground")
        .gravity(vector![0.0, 0.0, -9.81])
        .slip_tolerance(SLIP_TOLERANCE)
        .build()?;
    Ok(world.with_forces(hand)?)
}

/// Coefficient of friction between block and tool: the harmonic mean.
pub fn friction() -> f64 {
    let [block, tool, _] = FRICTIONS;
    2.0 * block * tool / (block + tool)
}

/// Steps of implicit Euler: all goes slowly, and the outcome is to have no jumps.
pub fn plan() -> Result<Plan, WorldError> {
    Ok(Plan::new(1.0 / RATE, STEPS)?.with_integrator(Integrator::ImplicitEuler))
}
