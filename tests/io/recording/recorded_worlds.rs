//! Worlds whose motion the tests record, and functions that read the recordings.

use crate::support::glb::Glb;
use crate::support::worlds::{at, cuboid, dynamic, fixed, icosphere, turned};
use gltf_json::animation::Property;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, Trajectory, World};
use hydroelastic::io::Recording;
use hydroelastic::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3, vector};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Relative rounding error of each number in a file: half a unit in the last place of single precision.
pub const SINGLE: f64 = 6e-8;
/// Rounding error of a direction or a rotation matrix made from four rounded numbers. Each entry sums four products of two numbers.
pub const SINGLE_TURN: f64 = 8.0 * SINGLE;
/// Rounding error of numbers in names, which have four digits.
pub const NAMED: f64 = 5e-4;
/// Frames per second of a recording.
pub const RATE: f64 = 60.0;

pub const SLOWDOWN: f64 = 4.0;
pub const TIME_STEP: f64 = 5e-4;

pub const ELASTIC: Material = Material {
    modulus: Some(1e5),
    dissipation: 0.0,
    friction: Some(0.0),
};
pub const DOWN: Vector3<f64> = vector![0.0, 0.0, -9.81];

pub fn rubbing() -> Material {
    ELASTIC.with_dissipation(0.2).with_friction(0.5)
}

/// Returns a floor, a block with its weight off center that tumbles over the floor, a ball that hits the block, and a ball of the same
/// shape that flies past.
pub fn tumbling(skin: Material) -> World {
    let floor = cuboid([2.0, 2.0, 0.2]);
    let block = cuboid([0.3, 0.2, 0.1]);
    let off_center = Mass::Properties(MassProperties {
        mass: 2.0,
        center_of_mass: vector![0.04, -0.02, 0.01],
        inertia: Matrix3::from_diagonal(&vector![0.01, 0.02, 0.025]),
    });
    let ball_shape = Arc::new(icosphere(0.08, 1));
    let ball = |name| dynamic(name, Arc::clone(&ball_shape), skin, 0.5);
    let tilted = turned([0.4, 0.3, 2.0], [0.0, 0.0, 0.3]);
    World::new(vec![
        fixed("floor", floor, skin),
        Body::dynamic("block", block, skin, off_center)
            .unwrap()
            .with_pose(tilted)
            .with_velocity(vector![0.3, 0.1, -1.0])
            .with_angular_velocity(vector![12.0, -6.0, 9.0]),
        ball("ball")
            .with_pose(at(0.03, 0.02, 0.5))
            .with_velocity(vector![0.0, 0.0, -1.5]),
        ball("twin")
            .with_pose(at(0.8, 0.0, 1.6))
            .with_angular_velocity(vector![0.0, 20.0, 0.0]),
    ])
    .unwrap()
    .with_gravity(DOWN)
    .unwrap()
}

/// Returns one second of a world's motion.
pub fn rollout(world: &World) -> Trajectory {
    let rollout = world.rollout(&Plan::new(TIME_STEP, 1000).unwrap());
    rollout.run().unwrap()
}

/// Returns the initial state only.
pub fn standing(world: &World) -> Trajectory {
    let rollout = world.rollout(&Plan::new(TIME_STEP, 0).unwrap());
    rollout.run().unwrap()
}

pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Writes and reads a recording, and checks its container and its JSON.
pub fn read_back(name: &str, recording: &Recording) -> Glb {
    let path = file(&format!("{name}.glb"));
    recording.write(&path).unwrap();
    let glb = Glb::read(&fs::read(&path).unwrap());
    assert_eq!(glb.faults(), [""; 0]);
    glb
}

/// Returns the state shown at a time of a recording.
pub fn state_at(trajectory: &Trajectory, time: f32, slowdown: f64) -> &State {
    let states = trajectory.states();
    let of_rollout = states[0].time + f64::from(time) / slowdown;
    let apart = |state: &State| (state.time - of_rollout).abs();
    let nearest = states.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    let nearest = nearest.unwrap();
    assert!(
        apart(nearest) <= SINGLE * f64::from(time),
        "no state at {time} s"
    );
    nearest
}

/// Returns the times of all frames, which are those of the keys of a moving body.
pub fn times(glb: &Glb, body: &str) -> Vec<f32> {
    let keys = glb.keys::<3>(glb.node(body), Property::Translation);
    keys.unwrap().times
}

pub fn assert_near(actual: &Vector3<f64>, expected: &Vector3<f64>, tolerance: f64) {
    let error = (actual - expected).amax();
    assert!(
        error <= tolerance,
        "{actual} instead of {expected}: {error:e}"
    );
}

pub const SURFACE: &str = "contact surface";

/// Returns the number in a name after some words and before a unit.
pub fn named(name: &str, words: &str, unit: &str) -> f64 {
    let (_, after) = name.split_once(words).unwrap();
    let (number, _) = after.split_once(unit).unwrap();
    number.trim().parse().unwrap()
}

/// Returns a ball that comes to rest on a floor.
pub fn resting() -> World {
    let floor = cuboid([1.0, 1.0, 0.2]);
    resting_on(floor, 1)
}

/// Returns a ball on a body whose top is at 0.1 m.
pub fn resting_on(floor: Shape, subdivisions: usize) -> World {
    let ball = icosphere(0.1, subdivisions);
    let skin = ELASTIC.with_dissipation(1.0).with_friction(0.5);
    World::new(vec![
        dynamic("ball", ball, skin, 1.0).with_pose(at(0.0, 0.0, 0.195)),
        fixed("floor", floor, skin),
    ])
    .unwrap()
    .with_gravity(DOWN)
    .unwrap()
}
