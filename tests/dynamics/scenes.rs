//! Balls, boxes, a floor and mass properties for several tests of worlds, and the bits of a state.

use crate::support::worlds::{cuboid, dynamic, fixed, icosphere};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, BodyState, Material, Plan, Rollout, State, World, WorldError};
use hydroelastic::spatial::{MassProperties, Pose, Twist, rotation_from_vector};
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

pub const GRAVITY: f64 = 9.81;

/// Accumulated rounding error of a few thousand steps.
pub const ROUND_OFF: f64 = 1e-12;

pub const SKIN: Material = Material {
    modulus: Some(1e5),
    dissipation: 0.0,
    friction: Some(0.0),
};

pub fn ball_shape() -> Arc<Shape> {
    Arc::new(icosphere(0.1, 1))
}

pub fn box_shape(lengths: [f64; 3]) -> Arc<Shape> {
    Arc::new(cuboid(lengths))
}

pub fn ball(name: &str) -> Body {
    dynamic(name, ball_shape(), SKIN, 1.0)
}

/// Returns a body whose top is z = 0.
pub fn floor(skin: Material) -> Body {
    let slab = box_shape([1.0, 1.0, 0.4]);
    let floor = fixed("floor", slab, skin);
    floor.with_pose(at(0.0, 0.0, -0.2))
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

/// Returns the bits of the time and of every number of every body.
pub fn bits(state: &State) -> Vec<u64> {
    let numbers = state.bodies.iter().flat_map(|body| {
        let pose = body.pose.rotation().iter().chain(body.pose.translation());
        let twist = body.twist.angular.iter().chain(&body.twist.linear);
        pose.chain(twist).copied()
    });
    let numbers = std::iter::once(state.time).chain(numbers);
    numbers.map(f64::to_bits).collect()
}

pub fn down() -> Vector3<f64> {
    vector![0.0, 0.0, -GRAVITY]
}

/// Asserts that an error's message starts with the expected text.
pub fn assert_names(error: &WorldError, beginning: &str) {
    let message = error.to_string();
    assert!(
        message.starts_with(beginning),
        "{message:?}, not {beginning:?}"
    );
}

pub fn still_at(x: f64) -> BodyState {
    BodyState {
        pose: at(x, 0.0, 0.0),
        twist: Twist::zero(),
    }
}

/// Returns mass properties of a body with an offset center of mass and rotated principal axes.
pub fn asymmetric() -> MassProperties {
    let axes = rotation_from_vector(&vector![0.4, -0.3, 0.8]);
    let moments = Matrix3::from_diagonal(&vector![0.01, 0.02, 0.025]);
    let inertia = axes * moments * axes.transpose();
    MassProperties {
        mass: 2.0,
        center_of_mass: vector![0.03, -0.01, 0.02],
        inertia: (inertia + inertia.transpose()) / 2.0,
    }
}

pub fn leapfrog(world: &World, time_step: f64) -> Rollout {
    world.rollout(&Plan::new(time_step, 0).unwrap())
}
