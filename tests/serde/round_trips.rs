//! Saved numbers are loaded without change.

use crate::support::worlds::{EXPLICIT, cuboid, dynamic, fixed, plan_of, rubbing, turned};
use crate::text_and_bits::{
    TIME_STEP, pose_bits, refusal, reloaded, saved, state_bits, trajectory_bits, twist_bits,
};
use hydroelastic::dynamics::{
    Body, BodyState, ContactTopology, Integrator, Material, Plan, State, Trajectory, World,
};
use hydroelastic::gradient::{DifferenceCheck, Experiment, FinalPosition, Parameter};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix3, Vector3, vector};
use proptest::prelude::*;
use std::sync::Arc;

/// Orthonormality error of rotations in a rollout. Loading keeps the bits up to ten times this error.
const ORTHONORMAL: f64 = 1e-15;

/// Returns a spinning block on a tilted floor with friction, and a paddle on a path.
fn world() -> World {
    let skin = rubbing(1e5, 0.2, 0.4);
    let block = Arc::new(cuboid([0.2, 0.15, 0.1]));
    let slab = cuboid([1.0, 1.0, 0.2]);
    let path = |time: f64| BodyState {
        pose: turned([0.0, time, 0.0], [0.3, time, 0.5]),
        twist: Twist {
            angular: vector![0.0, 1.0, 0.0],
            linear: vector![0.0, 1.0, 0.0],
        },
    };
    let start = turned([0.3, 2.0, 0.1], [0.1, 0.0, 0.24]);
    let tilt = Pose::from_rotation_vector(&vector![0.1, 0.0, 0.0], Vector3::zeros());
    let world = World::new(vec![
        dynamic("block", Arc::clone(&block), skin, 1.0)
            .with_pose(start)
            .with_velocity(vector![1e-9, -0.1, 0.0])
            .with_angular_velocity(vector![1.0, 9.0, -3.0]),
        fixed("floor", slab, skin).with_pose(tilt),
        Body::kinematic("paddle", block, skin, Arc::new(path)).unwrap(),
    ]);
    let world = world.unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

fn trajectory(integrator: Integrator) -> Trajectory {
    let world = world();
    let plan = Plan::new(TIME_STEP, 600).unwrap();
    let rollout = world.rollout(&plan.with_integrator(integrator));
    rollout.run().unwrap()
}

#[test]
fn the_layout_is_rows_and_names() {
    let rotation = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let pose = Pose::new(rotation, vector![1.0, 2.5, -0.0]).unwrap();
    let pose_text =
        r#"{"rotation":[[0.0,-1.0,0.0],[1.0,0.0,0.0],[0.0,0.0,1.0]],"translation":[1.0,2.5,-0.0]}"#;
    assert_eq!(saved(&pose), pose_text);
    let twist = Twist {
        angular: vector![1.0, 2.0, 3.0],
        linear: vector![4.0, 5.0, 6.0],
    };
    let twist_text = r#"{"angular":[1.0,2.0,3.0],"linear":[4.0,5.0,6.0]}"#;
    assert_eq!(saved(&twist), twist_text);
    let state = State {
        joints: Vec::new(),
        time: 0.5,
        bodies: vec![BodyState { pose, twist }],
    };
    let state_text = format!(
        r#"{{"time":0.5,"bodies":[{{"pose":{pose_text},"twist":{twist_text}}}],"joints":[]}}"#
    );
    assert_eq!(saved(&state), state_text);
    let trajectory_text = format!(r#"{{"states":[{state_text},{state_text}]}}"#);
    let trajectory: Trajectory = serde_json::from_str(&trajectory_text).unwrap();
    assert_eq!(saved(&trajectory), trajectory_text);
    let skin = rubbing(1e5, 0.25, 0.5);
    assert_eq!(
        saved(&skin),
        r#"{"modulus":100000.0,"dissipation":0.25,"friction":0.5}"#
    );
}

#[test]
fn a_trajectory_comes_back_bit_for_bit() {
    for integrator in EXPLICIT {
        let trajectory = trajectory(integrator);
        let loaded = reloaded(&trajectory);
        assert_eq!(trajectory_bits(&loaded), trajectory_bits(&trajectory));
        assert_eq!(state_bits(loaded.last()), state_bits(trajectory.last()));
    }
}

#[test]
fn a_rollout_goes_on_from_a_loaded_state_with_the_same_bits() {
    let world = world();
    for integrator in EXPLICIT {
        let plan = plan_of(integrator, TIME_STEP, 600);
        let uninterrupted = trajectory_bits(&trajectory(integrator));
        for stop in [0, 1, 137, 400] {
            let first = world.rollout(&plan.with_steps(stop)).run().unwrap();
            let loaded = reloaded(first.last());
            let rest = world.rollout(&plan.with_steps(600 - stop));
            let rest = rest.with_state(loaded).unwrap();
            let rest = rest.run().unwrap();
            assert_eq!(trajectory_bits(&rest), uninterrupted[stop..]);
        }
    }
}

#[test]
fn rotations_of_a_rollout_are_a_tenth_of_what_loading_keeps() {
    let trajectory = trajectory(Integrator::Leapfrog);
    let bodies = trajectory.states().iter().flat_map(|state| &state.bodies);
    let deviations = bodies.map(|body| {
        let rotation = body.pose.rotation();
        (rotation.transpose() * rotation - Matrix3::identity()).amax()
    });
    let largest = deviations.fold(0.0, f64::max);
    assert!(largest > 0.0 && largest <= ORTHONORMAL, "{largest:e}");
}

#[test]
fn a_rotation_further_off_is_put_right_as_by_the_constructor() {
    let mut rotation = Matrix3::identity();
    rotation[(0, 1)] = 1e-10;
    let expected = Pose::new(rotation, Vector3::zeros()).unwrap();
    let text = r#"{"rotation":[[1,1e-10,0],[0,1,0],[0,0,1]],"translation":[0,0,0]}"#;
    let loaded: Pose = serde_json::from_str(text).unwrap();
    assert_eq!(pose_bits(&loaded), pose_bits(&expected));
    assert!((loaded.rotation()[(0, 1)] - 0.5e-10).abs() <= 1e-20);
}

proptest! {
    #[test]
    fn poses_twists_and_materials_come_back_bit_for_bit(
        numbers in prop::array::uniform9(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO),
        turn in prop::array::uniform3(-10.0..10.0),
    ) {
        let [x, y, z, a, b, c, d, e, f] = numbers;
        let pose = Pose::from_rotation_vector(&Vector3::from(turn), vector![x, y, z]);
        prop_assert_eq!(pose_bits(&reloaded(&pose)), pose_bits(&pose));
        let twist = Twist { angular: vector![a, b, c], linear: vector![d, e, f] };
        prop_assert_eq!(twist_bits(&reloaded(&twist)), twist_bits(&twist));
        let skin = Material { modulus: Some(a.abs().max(f64::MIN_POSITIVE)), dissipation: b.abs(), friction: Some(c.abs()) };
        let bits = |skin: &Material| [skin.modulus.unwrap(), skin.dissipation, skin.friction.unwrap()].map(f64::to_bits);
        prop_assert_eq!(bits(&reloaded(&skin)), bits(&skin));
    }
}

#[test]
fn surfaces_keep_their_bits_and_are_checked() {
    let field = shapes::icosphere(0.1, 1).unwrap();
    let surface = TriangleSurface::around(field.mesh()).unwrap();
    let text = saved(&surface);
    let again: TriangleSurface = serde_json::from_str(&text).unwrap();
    assert_eq!(saved(&again), text);
    assert_eq!(again.triangles(), surface.triangles());
    for (actual, expected) in again.vertices().iter().zip(surface.vertices()) {
        assert_eq!(actual.map(f64::to_bits), expected.map(f64::to_bits));
    }
    let open = r#"{"vertices":[],"triangles":[]}"#;
    let refused = serde_json::from_str::<TriangleSurface>(open).unwrap_err();
    assert!(
        refused.to_string().contains("at least 4 triangles"),
        "{refused}"
    );
}

#[test]
fn topologies_and_difference_checks_come_back() {
    let world = world();
    let plan = Plan::new(TIME_STEP, 40).unwrap();
    let fall = Plan::new(TIME_STEP, 2000).unwrap().recording_every(20);
    let fall = world.rollout(&fall).run().unwrap();
    let topologies = fall
        .states()
        .iter()
        .map(|state| world.topology(state).unwrap());
    let topology = topologies
        .max_by_key(ContactTopology::polygon_count)
        .unwrap();
    let reloaded_topology: ContactTopology = reloaded(&topology);
    assert_eq!(reloaded_topology, topology);
    assert!(topology.polygon_count() > 0);
    let outcome = FinalPosition::of_body(&world, "block").unwrap();
    let mut check = Experiment::new(world, &plan)
        .difference_check(&[Parameter::Gravity], &outcome)
        .unwrap();
    // For example, a derivative is infinite.
    check.errors[(2, 1)] = f64::INFINITY;
    let loaded: DifferenceCheck = reloaded(&check);
    assert_eq!(loaded.errors, check.errors);
    assert_eq!((loaded.steps, loaded.numbers), (check.steps, check.numbers));
}

#[test]
fn a_difference_check_of_another_size_is_refused() {
    let text = r#"{"steps":[1e-3],"numbers":["x","y"],"errors":[0.5]}"#;
    let refusal = refusal::<DifferenceCheck>(text);
    let expected = "a check of 1 steps and 2 numbers must have 2 errors, but has 1";
    assert!(refusal.starts_with(expected), "{refusal}");
}
