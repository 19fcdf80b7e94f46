//! Poses and times of frames: bodies move as in the states, and frames have the correct times.

use super::recorded_worlds::{
    DOWN, ELASTIC, RATE, SINGLE, SINGLE_TURN, SLOWDOWN, SURFACE, TIME_STEP, assert_near, read_back,
    resting, rollout, rubbing, standing, state_at, times, tumbling,
};
use crate::support::glb::{Glb, quaternion};
use crate::support::worlds::{cuboid, fixed};
use gltf_json::animation::{Interpolation, Property};
use hydroelastic::dynamics::{Plan, Trajectory, World};
use hydroelastic::io::Recording;
use nalgebra::Vector3;

#[test]
fn bodies_are_where_the_states_have_them() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "poses",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    for time in times(&glb, "block") {
        let state = state_at(&trajectory, time, SLOWDOWN);
        for (body, now) in world.bodies().iter().zip(&state.bodies) {
            let shown = glb.placement(glb.node(body.name()), time);
            let tolerance = SINGLE * now.position().amax();
            assert_near(&shown.translation, now.position(), tolerance);
            let rotation = shown.rotation.to_rotation_matrix().into_inner();
            assert!((rotation - now.pose.rotation()).amax() <= SINGLE_TURN);
            assert_near(&shown.scale, &Vector3::repeat(1.0), 0.0);
        }
    }
}

#[test]
fn bodies_turn_the_short_way_from_key_to_key() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back("short_way", &Recording::new(&world, &trajectory));
    for body in ["block", "twin"] {
        let keys = glb.keys(glb.node(body), Property::Rotation).unwrap();
        assert_eq!(keys.interpolation, Interpolation::Linear);
        let turns: Vec<_> = keys.values.into_iter().map(quaternion).collect();
        assert!(turns.windows(2).all(|pair| pair[0].dot(&pair[1]) >= 0.0));
        assert!(
            turns
                .iter()
                .all(|turn| (turn.norm() - 1.0).abs() <= 2.0 * SINGLE)
        );
        // The block makes a full turn in 0.31 s, so a quaternion returns with the opposite sign.
        assert!(body == "block" || turns.iter().any(|turn| turn.dot(&turns[0]) < -0.9));
    }
}

#[test]
fn a_body_that_stays_has_no_animation() {
    let world = tumbling(rubbing());
    let glb = read_back("fixed_floor", &Recording::new(&world, &rollout(&world)));
    let animated = world
        .bodies()
        .iter()
        .map(|body| glb.is_animated(glb.node(body.name())));
    assert_eq!(animated.collect::<Vec<_>>(), [false, true, true, true]);
}

/// Asserts the shown states: the first state, and every state at least a frame after the previously shown state. The last state is also
/// shown, and replaces a state less than a frame before it.
fn assert_times(trajectory: &Trajectory, times: &[f32], slowdown: f64) {
    let start = trajectory.states()[0].time;
    let mut expected: Vec<f64> = Vec::new();
    for state in trajectory.states() {
        let time = (state.time - start) * slowdown;
        // Times are rounded, so that states exactly a frame apart are both shown.
        if expected
            .last()
            .is_none_or(|last| (time - last) * RATE > 1.0 - 1e-9)
        {
            expected.push(time);
        }
    }
    let end = (trajectory.last().time - start) * slowdown;
    if expected.len() > 1 {
        expected.pop_if(|last| (end - *last) * RATE <= 1.0 - 1e-9);
    }
    if expected.last() != Some(&end) {
        expected.push(end);
    }
    assert_eq!(times.len(), expected.len());
    for (time, expected) in times.iter().zip(expected) {
        assert!((f64::from(*time) - expected).abs() <= SINGLE * expected);
    }
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
}

#[test]
fn frames_are_as_many_as_60_in_a_second() {
    let world = tumbling(rubbing());
    let whole = rollout(&world);
    let later = world.rollout(&Plan::new(TIME_STEP, 300).unwrap());
    let later = later.with_state(whole.last().clone()).unwrap();
    let later = later.run().unwrap();
    for (name, trajectory, slowdown) in [
        ("real_time", &whole, 1.0),
        ("slow", &whole, SLOWDOWN),
        ("slower_than_the_states", &whole, 100.0),
        ("faster", &whole, 0.25),
        // The whole motion is within one frame.
        ("in_a_moment", &whole, 0.01),
        ("from_0_5_s", &later, 1.0),
    ] {
        let glb = read_back(name, &Recording::new(&world, trajectory).slowed(slowdown));
        assert_times(trajectory, &times(&glb, "block"), slowdown);
    }
}

/// Returns the position at the last key of a moving body.
fn last_position(glb: &Glb, body: &str) -> Vector3<f64> {
    let keys = glb.keys::<3>(glb.node(body), Property::Translation);
    crate::support::glb::vector(*keys.unwrap().values.last().unwrap())
}

#[test]
fn a_recording_ends_with_the_last_state() {
    let world = tumbling(rubbing());
    for steps in [1, 33, 34, 35, 77] {
        let rollout = world.rollout(&Plan::new(TIME_STEP, steps).unwrap());
        let trajectory = rollout.run().unwrap();
        let name = format!("{steps}_steps");
        let glb = read_back(&name, &Recording::new(&world, &trajectory));
        let end = trajectory.last().bodies[1].position();
        assert_near(&last_position(&glb, "block"), end, SINGLE * end.amax());
    }
}

/// Asserts that the times of the keys of all animations increase.
fn assert_times_increase(glb: &Glb) {
    for animation in &glb.root.animations {
        for sampler in &animation.samplers {
            let times = glb.floats::<1>(sampler.input);
            let increase = times.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            assert!(increase, "{times:?}");
        }
    }
}

#[test]
fn states_that_are_at_once_in_single_precision_have_one_frame() {
    let world = tumbling(rubbing());
    // 0.5 s become a time that single precision cannot distinguish from 0.
    let trajectory = rollout(&world);
    let recording = Recording::new(&world, &trajectory).slowed(1e-60);
    let glb = read_back("at_once", &recording);
    assert!(glb.root.animations.is_empty());
    assert_times_increase(&glb);
}

#[cfg(feature = "serde")]
#[test]
fn times_increase_in_single_precision_after_a_long_time() {
    let world = tumbling(rubbing());
    let rollout = world.rollout(&Plan::new(TIME_STEP, 5).unwrap());
    let mut saved = serde_json::to_value(rollout.run().unwrap()).unwrap();
    // At these times, the resolution of single precision is a quarter of a second.
    let times = [0.0, 3e6, 3e6 + 0.05, 3e6 + 0.15, 3e6 + 0.25, 3e6 + 0.3];
    for (index, time) in times.into_iter().enumerate() {
        saved["states"][index]["time"] = time.into();
    }
    let trajectory: Trajectory = serde_json::from_value(saved).unwrap();
    let glb = read_back("long_time", &Recording::new(&world, &trajectory));
    assert_times_increase(&glb);
    let key_times = self::times(&glb, "block").into_iter().map(f64::from);
    assert_eq!(key_times.collect::<Vec<_>>(), [0.0, 3e6, 3e6 + 0.25]);
}

#[test]
fn slow_motion_lasts_longer_and_has_more_frames() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let real = read_back("real", &Recording::new(&world, &trajectory));
    let slow = read_back(
        "slowed",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let [real, slow] = [real, slow].map(|glb| times(&glb, "block"));
    let lasts = |times: &[f32]| f64::from(times[times.len() - 1]);
    assert!((lasts(&real) - 0.5).abs() <= SINGLE * 0.5);
    assert!((lasts(&slow) - 2.0).abs() <= SINGLE * 2.0);
    assert!(slow.len() > 3 * real.len());
}

#[test]
fn the_first_frame_shows_without_animation() {
    let world = resting();
    let glb = read_back("first_frame", &Recording::new(&world, &standing(&world)));
    assert!(glb.root.animations.is_empty());
    for beginning in [SURFACE, "force between"] {
        assert!(glb.is_visible(glb.node(beginning), 0.0), "{beginning}");
    }
}

#[test]
fn a_world_where_nothing_moves_has_no_animation() {
    let stone = cuboid([1.0; 3]);
    let stone = fixed("stone", stone, ELASTIC);
    let world = World::new(vec![stone]).unwrap().with_gravity(DOWN).unwrap();
    let trajectory = rollout(&world);
    let points = [Vector3::zeros(), Vector3::x()];
    let recording = Recording::new(&world, &trajectory).with_path("way", points);
    let glb = read_back("still", &recording);
    assert!(glb.root.animations.is_empty());
    assert!(
        glb.mesh(glb.node("way")).area() > 1e-3,
        "the path has no width"
    );
}
