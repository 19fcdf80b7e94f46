//! Faces of a rigid body that lie in faces inside a compliant body.

use super::rigid;
use crate::support::reference::shape;
use crate::support::worlds::{at, cuboid};
use hydroelastic::contact::{ContactBody, ContactPair, Partner, RigidShape, Shape};
use hydroelastic::spatial::Pose;

/// Printed precision of the other program's force (N).
const PRINTED: f64 = 2e-9;

/// Distance (m) from the layer at which one-sided slopes are evaluated, and tolerance (N/m) of these slopes.
const BESIDE: f64 = 1e-7;
const NEAR: f64 = 1e-5;

/// Rounding error of forces and slopes of order one.
const ROUNDED: f64 = 1e-12;

/// Height of the layer of vertices in which the cube's lower side lies, and half of the cube's edge (m).
const LAYER: f64 = 0.25;
const HALF: f64 = 0.45;

/// Returns the force on the block along z, and its derivative with respect to a translation of the cube along z.
fn force_and_slope(block: &Shape, cube: &RigidShape, height: f64) -> [f64; 2] {
    let pose = at(0.013, -0.021, height + HALF);
    let block = ContactBody::new(block, Pose::identity(), 1.0).unwrap();
    let pair = ContactPair::new(block, Partner::rigid(cube, pose).unwrap());
    let contact = pair.linearized();
    [contact.wrench.on_a.force.z, contact.by_poses[(5, 11)]]
}

/// The force is that of an independent program. Its slope jumps when the cube's side passes the layer. At the layer, the slope is the mean
/// of both sides.
#[test]
fn the_slope_in_a_layer_of_the_mesh_is_the_mean_of_both_sides() {
    let block = shape("grid4");
    let cube = rigid(&cuboid([2.0 * HALF; 3]));
    let [force, slope] = force_and_slope(&block, &cube, LAYER);
    assert!((force + 0.272_960_168).abs() < PRINTED, "{force}");
    let known = [0.125, 0.990_654];
    let [below, above] =
        [-BESIDE, BESIDE].map(|beside| force_and_slope(&block, &cube, LAYER + beside)[1]);
    assert!((below - known[0]).abs() < NEAR, "{below}");
    assert!((above - known[1]).abs() < NEAR, "{above}");
    let mean = f64::midpoint(known[0], known[1]);
    assert!((slope - mean).abs() < NEAR, "{slope}");
    // Round-off has no effect.
    for beside in [1e-16, 1e-15, 1e-14] {
        for height in [LAYER - beside, LAYER + beside] {
            let [near, near_slope] = force_and_slope(&block, &cube, height);
            assert!((near - force).abs() < ROUNDED, "{near}");
            assert!((near_slope - slope).abs() < ROUNDED, "{near_slope}");
        }
    }
}
