//! Recordings that are rejected, each with its error and without a file.

use super::recorded_worlds::{ELASTIC, TIME_STEP, file, resting, rollout, standing, tumbling};
use crate::support::worlds::at;
use hydroelastic::dynamics::Plan;
use hydroelastic::io::{FileError, Recording};
use nalgebra::{Vector3, vector};

/// Returns the error of a recording, and checks that no file is written.
fn refused(name: &str, recording: &Recording) -> FileError {
    let path = file(name);
    let error = recording.write(&path).unwrap_err();
    assert!(!path.exists());
    error
}

#[test]
fn a_recording_goes_to_no_other_format() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    for (name, extension) in [("motion.gltf", "gltf"), ("motion", ""), ("glb", "")] {
        let error = refused(name, &Recording::new(&world, &trajectory));
        let FileError::UnknownExtension {
            found, expected, ..
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!((found.as_str(), expected), (extension, ["glb"].as_slice()));
    }
}

#[test]
fn a_trajectory_of_another_world_is_refused() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&resting());
    let error = refused("other_world.glb", &Recording::new(&world, &trajectory));
    let FileError::OtherWorld {
        found, expected, ..
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!([found, expected], [2, 4]);
}

#[test]
fn numbers_that_single_precision_does_not_have_are_refused() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let plain = || Recording::new(&world, &trajectory);
    let good = vector![0.1, 0.2, 0.3];
    for number in [f64::NAN, f64::INFINITY, -1e300] {
        let bad = vector![0.0, number, 0.0];
        for (recording, culprit) in [
            (plain().with_target("cup", bad, 0.1), "target \"cup\""),
            (plain().with_path("throw", [good, bad]), "path \"throw\""),
            (plain().with_path("throw", [bad, bad]), "path \"throw\""),
            (plain().with_path("throw", [bad]), "path \"throw\""),
            (plain().seen_from(bad, good), "the camera"),
            (plain().seen_from(good, bad), "the camera"),
        ] {
            assert_not_finite(&refused("not_finite.glb", &recording), culprit);
        }
    }
}

fn assert_not_finite(error: &FileError, culprit: &str) {
    let FileError::NotFinite { part, .. } = error else {
        panic!("{error}")
    };
    assert_eq!(part, culprit);
}

#[test]
fn a_camera_that_is_where_it_looks_is_refused() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    for distance in [0.0, 1e-200, 1e-44, 1e-37] {
        let eye = Vector3::x() * distance;
        let recording = Recording::new(&world, &trajectory).seen_from(eye, Vector3::zeros());
        let error = refused("no_direction.glb", &recording);
        let name = "distance (m) from the camera to its point";
        assert_option(&error, name, eye.norm());
    }
}

#[test]
fn a_target_whose_radius_is_no_positive_number_is_refused() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    for bad in [0.0, -0.1, 1e-60, 1e60, f64::NAN, f64::INFINITY] {
        let recording = Recording::new(&world, &trajectory);
        let recording = recording.with_target("cup", Vector3::zeros(), bad);
        let error = refused("radius.glb", &recording);
        assert_option(&error, "radius (m) of the target \"cup\"", bad);
    }
}

/// Checks that the error is about a number of this name.
fn assert_option(error: &FileError, expected: &str, number: f64) {
    let FileError::Option { name, found, .. } = error else {
        panic!("{error}")
    };
    assert_eq!((&name[..], found.to_bits()), (expected, number.to_bits()));
}

#[test]
fn a_state_that_is_not_finite_in_single_precision_is_refused() {
    let world = tumbling(ELASTIC);
    let mut lost = world.initial_state();
    lost.bodies[1].pose = at(1e300, 0.0, 1.0);
    let rollout = world.rollout(&Plan::new(TIME_STEP, 0).unwrap());
    let trajectory = rollout.clone().with_state(lost).unwrap().run();
    let error = refused("lost.glb", &Recording::new(&world, &trajectory.unwrap()));
    assert_not_finite(&error, "body \"block\"");
    // No trajectory accepts a time that is not finite: the state is rejected.
    let mut timeless = world.initial_state();
    timeless.time = f64::NAN;
    assert!(rollout.with_state(timeless).is_err());
}

#[test]
fn times_that_single_precision_does_not_have_are_refused() {
    let world = tumbling(ELASTIC);
    let trajectory = rollout(&world);
    let recording = Recording::new(&world, &trajectory).slowed(1e300);
    assert_not_finite(&refused("endless.glb", &recording), "the times");
}

#[test]
fn a_slowdown_that_is_no_positive_number_is_refused() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    for slowdown in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let recording = Recording::new(&world, &trajectory).slowed(slowdown);
        let error = refused("slowdown.glb", &recording);
        assert_option(&error, "slowdown", slowdown);
    }
}
