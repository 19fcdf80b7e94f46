//! The tilted tool pressed into the block, both fixed.

use super::archimedes::buoyancy;
use super::scene::{self, BLOCK_SIZE, MODULUS, slope};
use super::show::{Curve, Panel};
use hydroelastic::contact::{BodyError, ContactBody, ContactPair, Partner, RigidShape, Shape};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use std::error::Error;

/// Tilt of the tool (rad), which results in a torque.
const TILT: Vector3<f64> = Vector3::new(0.2, 0.3, 0.0);

/// Wrenches on the tool about the origin of its frame at a depth (m), by the library and by Archimedes' principle.
pub struct Pressed {
    pub depth: f64,
    pub wrenches: [Wrench; 2],
}

/// Computes the wrenches at depths of the tool's lowest point.
pub fn at_depths(depths: &[f64]) -> Result<Vec<Pressed>, Box<dyn Error>> {
    let (block, tool) = (Shape::new(scene::block()?), RigidShape::new(scene::tool()?));
    let block = ContactBody::new(&block, Pose::identity(), MODULUS)?;
    let top = BLOCK_SIZE[2] / 2.0;
    let turned = Pose::from_rotation_vector(&TILT, Vector3::zeros());
    let heights = tool.surface().vertices().iter();
    let lowest = heights
        .map(|vertex| turned.transformed_point(vertex).z)
        .fold(f64::INFINITY, f64::min);
    let at_depth = |&depth: &f64| {
        let place = vector![0.0, 0.0, top - depth - lowest];
        let pose = Pose::from_rotation_vector(&TILT, place);
        let pair = ContactPair::new(block, Partner::rigid(&tool, pose)?);
        let expected = buoyancy(tool.surface(), &pose, top, slope());
        let wrenches = [pair.wrench().on_b, expected];
        Ok::<_, BodyError>(Pressed { depth, wrenches })
    };
    Ok(depths.iter().map(at_depth).collect::<Result<_, _>>()?)
}

/// Returns the larger of the relative differences of forces and of torques.
pub fn deviation(pressed: &Pressed) -> f64 {
    let [found, expected] = &pressed.wrenches;
    let parts = [
        (found.force - expected.force).norm() / expected.force.norm(),
        (found.torque - expected.torque).norm() / expected.torque.norm(),
    ];
    parts[0].max(parts[1])
}

/// Plots force against depth.
pub fn over_depth(pressed: &[Pressed]) -> Panel {
    let curve = |name, which: usize| {
        let force = |at: &Pressed| (1e3 * at.depth, at.wrenches[which].force.z);
        Curve::new(name, pressed.iter().map(force))
    };
    Panel {
        x_label: "depth (mm)",
        y_label: "force (N)",
        is_log: false,
        curves: vec![curve("contact", 0), curve("Archimedes", 1)],
    }
}
