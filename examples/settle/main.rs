//! How does a block with its weight off center come to rest on soft ground?
//!
//! `cargo run --release -p hydroelastic-examples --example settle [-- --record FILE.glb --plot FILE.svg]`
//!
//! At rest the contact wrench balances the weight. Newton's method finds that pose from the exact
//! Jacobian, without a step in time; a rollout from there then shows that nothing moves, and one from
//! the first pose ends at the same depth.

mod block;
#[path = "../show/mod.rs"]
mod show;

use block::{CENTER_OF_MASS, GRAVITY, MASS, MODULI};
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, Shape};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist, Wrench, skew};
use nalgebra::{Matrix6, Vector6, vector};
use show::{Curve, Panel};
use std::error::Error;
use std::sync::Arc;

/// Height (m) of the middle of the block over the ground where they touch.
const TOUCHING: f64 = 0.05;
/// Thickness (m) of the soft layer of the ground.
const LAYER: f64 = 0.1;
/// Newton's method ends where the net wrench (N, N m) is below this share of the weight (N).
const BALANCED: f64 = 1e-9;
const ITERATIONS: usize = 8;
/// Singular values below this fraction of the largest are zero: sliding on the level ground and
/// turning on it change nothing.
const FREE: f64 = 1e-9;
/// How far the resting block may move in a rollout (m).
const AT_REST: f64 = 1e-9;
/// And how far from the depth at rest (m) the tilted one may be after 1 s: nothing but dissipation
/// slows it, and it still turns on the ground.
const SETTLED: f64 = 1e-7;

fn main() -> Result<(), Box<dyn Error>> {
    let block = Arc::new(Shape::new(shapes::distance_cuboid([0.3, 0.2, 0.1])?));
    let ground = HalfSpace::layer(LAYER)?;
    // Tilted so that one edge is lifted off.
    let tilt = vector![0.02, -0.03, 0.3];
    let tilted = Pose::from_rotation_vector(&tilt, vector![0.1, 0.05, 0.049]);
    let mut pose = tilted;
    let mut residuals = Vec::new();
    for _ in 0..=ITERATIONS {
        let a = ContactBody::new(&block, pose, MODULI[0])?;
        let b = Partner::half_space(&ground, Pose::identity(), MODULI[1])?;
        let (wrench, by_pose) = net_wrench(&ContactPair::new(a, b));
        let residual = wrench.amax() / (MASS * GRAVITY.norm());
        println!("net wrench over weight: {residual:.1e}");
        residuals.push(residual);
        if residual < BALANCED {
            break;
        }
        // The smallest motion that balances the wrench to first order.
        let svd = by_pose.svd(true, true);
        let step = svd.solve(&-wrench, FREE * svd.singular_values.max())?;
        pose = pose.moved_by(&Twist::from_vector(&step));
    }
    let depth = TOUCHING - pose.translation().z;
    println!("it sinks in by {:.3} mm", 1e3 * depth);

    // Quadratic: the last residuals are below the squares of those before.
    let [.., first, second, third] = residuals[..] else {
        return Err("balanced at once".into());
    };
    assert!(second < first * first && third < second * second && third < BALANCED);
    let (_, resting) = block::released(&block, &ground, pose)?;
    let motion = (resting.last().bodies[0].position() - pose.translation()).norm();
    println!("motion in 1 s: {motion:.1e} m");
    assert!(motion < AT_REST);

    let (world, settling) = block::released(&block, &ground, tilted)?;
    let settled = TOUCHING - settling.last().bodies[0].position().z;
    println!("let go tilted, it sinks in by {:.3} mm", 1e3 * settled);
    assert!((settled - depth).abs() < SETTLED);
    let wanted = show::wanted()?;
    wanted.record(|| {
        let recording = Recording::new(&world, &settling);
        Ok(recording.seen_from(vector![-0.45, -0.9, 0.45], vector![0.1, 0.05, 0.06]))
    })?;
    wanted.plot(|| {
        let residuals = Curve::counted("net wrench/weight", residuals.into_iter());
        let newton = Panel::counted("iteration", vec![residuals]);
        vec![newton, show::contact_force(&world, &settling, 0)]
    })
}

/// Contact and weight about the block's origin, and the derivatives by the block's pose.
fn net_wrench(pair: &ContactPair) -> (Vector6<f64>, Matrix6<f64>) {
    let contact = pair.linearized();
    let arm = pair.a().pose().rotation() * CENTER_OF_MASS;
    let force = GRAVITY * MASS;
    let torque = arm.cross(&force);
    let wrench = contact.wrench.on_a + Wrench { torque, force };
    let mut by_pose = contact.by_poses.fixed_view::<6, 6>(0, 0).into_owned();
    // A turn δθ moves the arm by δθ × arm, so δ(arm × F) = F × (arm × δθ).
    let mut by_turn = by_pose.fixed_view_mut::<3, 3>(0, 0);
    by_turn += skew(&force) * skew(&arm);
    (wrench.to_vector(), by_pose)
}
