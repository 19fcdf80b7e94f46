//! Recordings, read back: what the file shows is what the states and contacts say.

use crate::support::glb::{Glb, Mesh, quaternion};
use gltf_json::animation::{Interpolation, Property};
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Index, Node};
use hydroelastic::contact::{ContactPolygon, Shape};
use hydroelastic::dynamics::{
    Body, BodyState, Contact, Mass, Material, Plan, State, Trajectory, World,
};
use hydroelastic::io::{FileError, Recording};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose, Twist};
use nalgebra::{Matrix3, Vector3, vector};
use std::f64::consts::SQRT_2;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Half a unit in the last place of single precision, relative: what each number in a file is off by.
const SINGLE: f64 = 6e-8;
/// Of a direction or a rotation matrix made from four rounded numbers: each entry sums four products of two.
const SINGLE_TURN: f64 = 8.0 * SINGLE;
/// Corners of a contact surface are moved to one nearby, in a grid of 1e-6 of the largest coordinate,
/// which is √3 of that away at most, and rounded to single precision.
const WELDED: f64 = 1.8e-6;
/// Numbers in names have four digits.
const NAMED: f64 = 5e-4;
/// Frames for each second of a recording.
const RATE: f64 = 60.0;
/// Contact surfaces in a recording.
const MOST_SURFACES: usize = 240;

const SLOWDOWN: f64 = 4.0;
const TIME_STEP: f64 = 5e-4;

const ELASTIC: Material = Material {
    modulus: 1e5,
    dissipation: 0.0,
    friction: 0.0,
};
const DOWN: Vector3<f64> = vector![0.0, 0.0, -9.81];

fn rubbing() -> Material {
    ELASTIC.with_dissipation(0.2).with_friction(0.5)
}

/// A floor, a block with its weight off centre that tumbles over it, a ball that hits the block, and one
/// of the same shape that flies past.
fn tumbling(skin: Material) -> World {
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.2]).unwrap());
    let block = Shape::new(shapes::cuboid([0.3, 0.2, 0.1]).unwrap());
    let off_center = Mass::Given(MassProperties {
        mass: 2.0,
        center_of_mass: vector![0.04, -0.02, 0.01],
        inertia: Matrix3::from_diagonal(&vector![0.01, 0.02, 0.025]),
    });
    let ball_shape = Arc::new(Shape::new(shapes::icosphere(0.08, 1).unwrap()));
    let ball = |name| Body::dynamic(name, Arc::clone(&ball_shape), skin, Mass::Total(0.5)).unwrap();
    let tilted = Pose::from_rotation_vector(&vector![0.4, 0.3, 2.0], vector![0.0, 0.0, 0.3]);
    World::new(vec![
        Body::fixed("floor", floor, skin).unwrap(),
        Body::dynamic("block", block, skin, off_center)
            .unwrap()
            .at(tilted)
            .with_velocity(vector![0.3, 0.1, -1.0])
            .with_spin(vector![12.0, -6.0, 9.0]),
        ball("ball")
            .at(Pose::from_translation(vector![0.03, 0.02, 0.5]))
            .with_velocity(vector![0.0, 0.0, -1.5]),
        ball("twin")
            .at(Pose::from_translation(vector![0.8, 0.0, 1.6]))
            .with_spin(vector![0.0, 20.0, 0.0]),
    ])
    .unwrap()
    .with_gravity(DOWN)
    .unwrap()
}

/// A second of a world's motion.
fn rollout(world: &World) -> Trajectory {
    let rollout = world.rollout(&Plan::new(TIME_STEP, 1000).unwrap());
    rollout.recorded().unwrap()
}

/// The initial state alone.
fn standing(world: &World) -> Trajectory {
    let rollout = world.rollout(&Plan::new(TIME_STEP, 0).unwrap());
    rollout.recorded().unwrap()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// A recording written and read back; its container and its JSON are found to be right.
fn read_back(name: &str, recording: &Recording) -> Glb {
    let path = file(&format!("{name}.glb"));
    recording.write(&path).unwrap();
    let glb = Glb::read(&fs::read(&path).unwrap());
    assert_eq!(glb.faults(), [""; 0]);
    glb
}

/// The state shown at a time of a recording.
fn state_at(trajectory: &Trajectory, time: f32, slowdown: f64) -> &State {
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

/// The times of all frames: those of the keys of a body that moves.
fn times(glb: &Glb, body: &str) -> Vec<f32> {
    let keys = glb.keys::<3>(glb.node(body), Property::Translation);
    keys.unwrap().times
}

fn assert_near(found: &Vector3<f64>, expected: &Vector3<f64>, tolerance: f64) {
    let error = (found - expected).amax();
    assert!(
        error <= tolerance,
        "{found} instead of {expected}: {error:e}"
    );
}

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
        // All the way round in 0.31 s: a quaternion comes back with the other sign.
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

/// Every state that comes at least a frame after the one shown before is shown, from the first; then the
/// last, instead of one less than a frame before it.
fn assert_times(trajectory: &Trajectory, times: &[f32], slowdown: f64) {
    let start = trajectory.states()[0].time;
    let mut expected: Vec<f64> = Vec::new();
    for state in trajectory.states() {
        let time = (state.time - start) * slowdown;
        // Rounded, so that states exactly a frame apart are both shown.
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
    let later = later.starting_from(whole.last().clone()).unwrap();
    let later = later.recorded().unwrap();
    for (name, trajectory, slowdown) in [
        ("real_time", &whole, 1.0),
        ("slow", &whole, SLOWDOWN),
        ("slower_than_the_states", &whole, 100.0),
        ("faster", &whole, 0.25),
        // Within a frame.
        ("in_a_moment", &whole, 0.01),
        ("from_0_5_s", &later, 1.0),
    ] {
        let glb = read_back(name, &Recording::new(&world, trajectory).slowed(slowdown));
        assert_times(trajectory, &times(&glb, "block"), slowdown);
    }
}

/// Where the last key of a body that moves has it.
fn last_position(glb: &Glb, body: &str) -> Vector3<f64> {
    let keys = glb.keys::<3>(glb.node(body), Property::Translation);
    crate::support::glb::vector(*keys.unwrap().values.last().unwrap())
}

#[test]
fn a_recording_ends_with_the_last_state() {
    let world = tumbling(rubbing());
    for steps in [1, 33, 34, 35, 77] {
        let rollout = world.rollout(&Plan::new(TIME_STEP, steps).unwrap());
        let trajectory = rollout.recorded().unwrap();
        let name = format!("{steps}_steps");
        let glb = read_back(&name, &Recording::new(&world, &trajectory));
        let end = trajectory.last().bodies[1].position();
        assert_near(&last_position(&glb, "block"), end, SINGLE * end.amax());
    }
}

/// Of the keys of all animations, if there are any.
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
    // 0.5 s become a time that single precision does not tell from 0.
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
    let mut saved = serde_json::to_value(rollout.recorded().unwrap()).unwrap();
    // Single precision has every quarter of a second there.
    let times = [0.0, 3e6, 3e6 + 0.05, 3e6 + 0.15, 3e6 + 0.25, 3e6 + 0.3];
    for (place, time) in times.into_iter().enumerate() {
        saved["states"][place]["time"] = time.into();
    }
    let trajectory: Trajectory = serde_json::from_value(saved).unwrap();
    let glb = read_back("long_time", &Recording::new(&world, &trajectory));
    assert_times_increase(&glb);
    let found = self::times(&glb, "block").into_iter().map(f64::from);
    assert_eq!(found.collect::<Vec<_>>(), [0.0, 3e6, 3e6 + 0.25]);
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
fn up_is_against_gravity() {
    for (name, gravity, up) in [
        ("minus_z", vector![0.0, 0.0, -9.81], Vector3::z()),
        ("plus_x", vector![1.6, 0.0, 0.0], -Vector3::x()),
        ("plus_y", vector![0.0, 9.81, 0.0], -Vector3::y()),
        ("minus_y", vector![0.0, -9.81, 0.0], Vector3::y()),
        (
            "slanted",
            vector![3.0, 2.0, -6.0],
            vector![-3.0, -2.0, 6.0] / 7.0,
        ),
        ("weightless", Vector3::zeros(), Vector3::z()),
    ] {
        let world = tumbling(ELASTIC).with_gravity(gravity).unwrap();
        let glb = read_back(name, &Recording::new(&world, &standing(&world)));
        let [top] = glb.root.scenes[0].nodes[..] else {
            panic!("one node holds all")
        };
        let shown = glb.placement(top, 0.0).rotation * up;
        assert_near(&shown, &Vector3::y(), SINGLE_TURN);
        let children = glb.root.get(top).unwrap().children.as_ref().unwrap();
        assert_eq!(children.len() + 1, glb.root.nodes.len());
    }
}

const SURFACE: &str = "contact surface";

/// The surface that is visible at a time, if there is one; there may not be two.
fn visible_surface(glb: &Glb, time: f32) -> Option<Index<Node>> {
    let mut visible = glb.nodes(SURFACE);
    visible.retain(|&node| glb.is_visible(node, time));
    assert!(visible.len() <= 1, "{} surfaces at {time} s", visible.len());
    visible.pop()
}

/// A number in a name, after some words and before a unit.
fn named(name: &str, words: &str, unit: &str) -> f64 {
    let (_, after) = name.split_once(words).unwrap();
    let (number, _) = after.split_once(unit).unwrap();
    number.trim().parse().unwrap()
}

fn polygons(contacts: &[Contact]) -> Vec<&ContactPolygon> {
    let surfaces = contacts.iter().map(|contact| &contact.surface);
    surfaces.flat_map(|surface| &surface.polygons).collect()
}

/// Corners of polygons with their pressures.
fn corners(contacts: &[Contact]) -> Vec<(Vector3<f64>, f64)> {
    let of_polygon = |polygon: &ContactPolygon| -> Vec<_> {
        let corners = polygon.outline.corners().iter();
        corners
            .map(|corner| (*corner, polygon.pressure_at(corner)))
            .collect()
    };
    polygons(contacts)
        .into_iter()
        .flat_map(of_polygon)
        .collect()
}

#[test]
fn a_contact_surface_shows_while_bodies_touch() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "surfaces",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let times = times(&glb, "block");
    let touch = |time: &f32| {
        !world
            .contacts(state_at(&trajectory, *time, SLOWDOWN))
            .unwrap()
            .is_empty()
    };
    let (touching, apart): (Vec<f32>, Vec<f32>) = times.iter().partition(|time| touch(time));
    assert!(touching.len() > 20 && apart.len() > 20);
    assert!(
        touching
            .iter()
            .all(|&time| visible_surface(&glb, time).is_some())
    );
    assert!(
        apart
            .iter()
            .all(|&time| visible_surface(&glb, time).is_none())
    );
    // No two frames have the same surface here, so each has its own.
    assert_eq!(glb.nodes(SURFACE).len(), touching.len());
}

#[test]
fn a_contact_surface_has_the_area_and_the_centroid_of_its_polygons() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "areas",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let mut largest_count = 0;
    for time in times(&glb, "block") {
        let Some(node) = visible_surface(&glb, time) else {
            continue;
        };
        let contacts = world
            .contacts(state_at(&trajectory, time, SLOWDOWN))
            .unwrap();
        largest_count = largest_count.max(contacts.len());
        let corners = corners(&contacts);
        let reach = corners
            .iter()
            .map(|(corner, _)| corner.amax())
            .fold(0.0, f64::max);
        let polygons = polygons(&contacts);
        let rims = polygons.iter().map(|polygon| {
            let corners = polygon.outline.corners();
            let next = corners.iter().cycle().skip(1);
            corners
                .iter()
                .zip(next)
                .map(|(a, b)| (a - b).norm())
                .sum::<f64>()
        });
        // A polygon whose corners are moved by so much changes its area by no more than its rim times that.
        let moved = WELDED * reach;
        let tolerance = moved * rims.sum::<f64>();

        let shown = glb.mesh(node);
        let area: f64 = polygons.iter().map(|polygon| polygon.area).sum();
        assert!(
            (shown.area() - area).abs() <= tolerance,
            "{} {area}",
            shown.area()
        );
        let weighted: Vector3<f64> = polygons.iter().map(|p| p.centroid * p.area).sum();
        let centroid = weighted / area;
        let extent = corners.iter().map(|(corner, _)| (corner - centroid).norm());
        let tolerance = moved * area + tolerance * extent.fold(0.0, f64::max);
        assert_near(
            &shown.first_moment_about(&centroid),
            &Vector3::zeros(),
            tolerance,
        );
    }
    assert!(largest_count > 1, "never two contacts at once");
}

/// How bright a linear colour is to the eye (CIE Y of sRGB primaries), from 0 to 255.
fn luminance(color: [u8; 4]) -> f64 {
    let [r, g, b, _] = color.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[test]
fn colors_brighten_with_pressure_up_to_the_peak() {
    /// Each part of a colour is rounded on the screen's scale, whose steps are up to 2.3 of the linear
    /// ones, and once more on that.
    const ROUNDED: f64 = 2.3 + 1.0;

    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "colors",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let mut colored: Vec<(f64, [u8; 4])> = Vec::new();
    for time in times(&glb, "block") {
        let Some(node) = visible_surface(&glb, time) else {
            continue;
        };
        let corners = corners(
            &world
                .contacts(state_at(&trajectory, time, SLOWDOWN))
                .unwrap(),
        );
        let shown = glb.mesh(node);
        for (point, color) in shown.points.iter().zip(&shown.colors) {
            let apart = |corner: &Vector3<f64>| (corner - point).norm();
            let nearest = corners
                .iter()
                .min_by(|a, b| apart(&a.0).total_cmp(&apart(&b.0)));
            colored.push((nearest.unwrap().1, *color));
        }
    }
    colored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut brightest, mut darkest) = (0.0_f64, f64::MAX);
    for (_, color) in &colored {
        assert_eq!(color[3], u8::MAX);
        let bright = luminance(*color);
        assert!(bright >= brightest - ROUNDED);
        (brightest, darkest) = (brightest.max(bright), darkest.min(bright));
    }
    let (peak, color) = colored[colored.len() - 1];
    assert!(luminance(color) >= brightest);
    assert!(darkest < 10.0 && brightest > 200.0, "{darkest} {brightest}");
    let name = glb.name(glb.nodes(SURFACE)[0]);
    let claimed = named(name, "brightest at", "Pa");
    assert!(
        (claimed / peak - 1.0).abs() <= NAMED,
        "{name}, but {peak} Pa"
    );
}

/// A ball that comes to rest on a floor.
fn resting() -> World {
    let floor = Shape::new(shapes::cuboid([1.0, 1.0, 0.2]).unwrap());
    resting_on(floor, 1)
}

/// A ball on something that reaches up to 0.1 m.
fn resting_on(floor: Shape, subdivisions: usize) -> World {
    let ball = Shape::new(shapes::icosphere(0.1, subdivisions).unwrap());
    let skin = ELASTIC.with_dissipation(1.0).with_friction(0.5);
    World::new(vec![
        Body::dynamic("ball", ball, skin, Mass::Total(1.0))
            .unwrap()
            .at(Pose::from_translation(vector![0.0, 0.0, 0.195])),
        Body::fixed("floor", floor, skin).unwrap(),
    ])
    .unwrap()
    .with_gravity(DOWN)
    .unwrap()
}

/// A hammer that touches a heavy block in every other frame.
fn hammering() -> World {
    let cube = || Shape::new(shapes::cuboid([0.1; 3]).unwrap());
    let path = |time: f64| {
        let is_up = (time * RATE).round() % 2.0 > 0.5;
        let height = if is_up { 0.12 } else { 0.09 };
        BodyState {
            pose: Pose::from_translation(vector![0.0, 0.0, height]),
            twist: Twist::zero(),
        }
    };
    World::new(vec![
        Body::dynamic("block", cube(), ELASTIC, Mass::Total(1e9)).unwrap(),
        Body::prescribed("hammer", cube(), ELASTIC, Arc::new(path)).unwrap(),
    ])
    .unwrap()
}

/// How many contact surfaces there are in a recording of many frames with contact, in which the given
/// body moves; each such frame shows one, no other does.
fn surfaces_of_a_long_recording(body: &str, world: &World, rollout: &Trajectory) -> usize {
    let glb = read_back(&format!("long_{body}"), &Recording::new(world, rollout));
    let mut touching = 0;
    for time in times(&glb, body) {
        let is_touching = !world
            .contacts(state_at(rollout, time, 1.0))
            .unwrap()
            .is_empty();
        touching += usize::from(is_touching);
        assert_eq!(visible_surface(&glb, time).is_some(), is_touching, "{time}");
    }
    assert!(touching > MOST_SURFACES);
    glb.nodes(SURFACE).len()
}

#[test]
fn a_long_contact_has_no_more_surfaces_than_a_recording_may() {
    let world = resting();
    let plan = Plan::new(1e-3, 7_000).unwrap().recording_every(10);
    let rollout = world.rollout(&plan).recorded().unwrap();
    let count = surfaces_of_a_long_recording("ball", &world, &rollout);
    assert!(
        (MOST_SURFACES / 2..=MOST_SURFACES).contains(&count),
        "{count}"
    );
}

#[test]
fn many_short_contacts_have_no_more_surfaces_than_a_recording_may() {
    let world = hammering();
    let rollout = world.rollout(&Plan::new(1.0 / RATE, 600).unwrap());
    let rollout = rollout.recorded().unwrap();
    let count = surfaces_of_a_long_recording("hammer", &world, &rollout);
    assert!(
        (MOST_SURFACES / 2..=MOST_SURFACES).contains(&count),
        "{count}"
    );
}

/// Bytes of what only the contact surfaces need, in the JSON and in the buffer.
fn bytes_of_surfaces(glb: &Glb) -> usize {
    let root = &glb.root;
    let surfaces = glb.nodes(SURFACE);
    let animation = &root.animations[0];
    let mut json = 0;
    let mut accessors = Vec::new();
    for &node in &surfaces {
        let node = root.get(node).unwrap();
        json += length(node) + length(root.get(node.mesh.unwrap()).unwrap());
        let primitive = &root.get(node.mesh.unwrap()).unwrap().primitives[0];
        accessors.extend(primitive.attributes.values().chain(&primitive.indices));
    }
    for channel in &animation.channels {
        if surfaces.contains(&channel.target.node) {
            let sampler = &animation.samplers[channel.sampler.value()];
            json += length(channel) + length(sampler);
            accessors.extend([sampler.input, sampler.output]);
        }
    }
    accessors.sort_unstable();
    accessors.dedup();
    let accessors: Vec<_> = accessors
        .into_iter()
        .map(|index| root.get(index).unwrap())
        .collect();
    json += accessors.iter().map(length).sum::<usize>();
    let numbers = accessors.into_iter().map(|accessor| {
        let size = accessor.component_type.unwrap().0.size();
        let together = accessor.type_.unwrap().multiplicity();
        let count = usize::try_from(accessor.count.0).unwrap();
        (size * together * count).next_multiple_of(4)
    });
    // A comma follows each piece of JSON: node, mesh, channel, sampler and about five accessors.
    json + 9 * surfaces.len() + numbers.sum::<usize>()
}

/// Bytes of its JSON.
fn length(part: &impl serde::Serialize) -> usize {
    serde_json::to_vec(part).unwrap().len()
}

#[test]
fn contact_surfaces_are_as_long_as_the_documentation_says() {
    let floor = |_| Shape::new(shapes::cuboid([1.0, 1.0, 0.2]).unwrap());
    let ball = |order| Shape::new(shapes::icosphere(0.1, order).unwrap());
    let on_floor = bytes_of_polygons_and_surfaces("floor", floor);
    let on_ball = bytes_of_polygons_and_surfaces("ball", ball);
    for [of_polygon, of_surface] in [on_floor, on_ball] {
        assert!((20.0..30.0).contains(&of_polygon), "{of_polygon}");
        assert!((800.0..900.0).contains(&of_surface), "{of_surface}");
    }
}

/// What each polygon needs, and each surface beside that: from recordings with few polygons and with many,
/// in as many surfaces, of a ball on something of some fineness.
fn bytes_of_polygons_and_surfaces(name: &str, below: impl Fn(usize) -> Shape) -> [f64; 2] {
    let sizes = [1, 3].map(|order| {
        let world = resting_on(below(order), order);
        let plan = Plan::new(1e-3, 1_000).unwrap().recording_every(20);
        let trajectory = world.rollout(&plan).recorded().unwrap();
        let recording = Recording::new(&world, &trajectory);
        let glb = read_back(&format!("sizes_on_{name}_{order}"), &recording);
        let states = trajectory.states().iter();
        let polygons: usize = states
            .map(|state| polygons(&world.contacts(state).unwrap()).len())
            .sum();
        let surfaces = glb.nodes(SURFACE).len();
        assert_eq!(surfaces, trajectory.states().len());
        [bytes_of_surfaces(&glb), polygons, surfaces].map(|number| number as f64)
    });
    let [[few_bytes, few, surfaces], [many_bytes, many, _]] = sizes;
    let of_polygon = (many_bytes - few_bytes) / (many - few);
    let of_surface = (few_bytes - of_polygon * few) / surfaces;
    println!("on a {name}: {of_polygon:.1} bytes a polygon, {of_surface:.0} a surface");
    [of_polygon, of_surface]
}

/// Two cubes whose corners overlap by a little (m).
fn barely_touching(depth: f64) -> World {
    let cube = || Shape::new(shapes::cuboid([0.1; 3]).unwrap());
    let axis = vector![1.0, -1.0, 0.0].normalize();
    let corner_down = axis * (1.0_f64 / 3.0).sqrt().acos();
    let height = 0.05 + 0.05 * 3.0_f64.sqrt() - depth;
    let tilted = Pose::from_rotation_vector(&corner_down, vector![0.0, 0.0, height]);
    World::new(vec![
        Body::dynamic("tilted", cube(), ELASTIC, Mass::Total(1.0))
            .unwrap()
            .at(tilted),
        Body::fixed("flat", cube(), ELASTIC).unwrap(),
    ])
    .unwrap()
}

#[test]
fn a_contact_smaller_than_single_precision_has_no_surface() {
    for (name, depth, count) in [("touch", 1e-9, 0), ("press", 1e-3, 1)] {
        let world = barely_touching(depth);
        assert_eq!(world.contacts(&world.initial_state()).unwrap().len(), 1);
        let glb = read_back(name, &Recording::new(&world, &standing(&world)));
        assert_eq!(glb.nodes(SURFACE).len(), count);
        let primitives = glb.root.meshes.iter().flat_map(|mesh| &mesh.primitives);
        for indices in primitives.filter_map(|primitive| primitive.indices) {
            assert!(glb.root.get(indices).unwrap().count.0 > 0);
        }
    }
}

/// A node of a force or a torque, with where it points (times its length, m) at a time.
fn arrow_at(glb: &Glb, node: Index<Node>, time: f32) -> (Vector3<f64>, Vector3<f64>) {
    let shown = glb.placement(node, time);
    let length = shown.scale.x;
    assert_eq!(shown.scale, Vector3::repeat(length));
    (shown.translation, shown.rotation * Vector3::z() * length)
}

/// Holds all arrows for one load, of frames with a time each, against the load: a point and a vector. The
/// longest vector of all loads is told.
fn assert_arrows(
    glb: &Glb,
    (beginning, unit): (&str, &str),
    loads: &[(f32, Option<[Vector3<f64>; 2]>)],
    largest: f64,
) {
    let node = glb.node(beginning);
    let name = glb.name(node);
    let length = named(name, ", ", " m for");
    assert!(
        (named(name, "m for", unit) / largest - 1.0).abs() <= NAMED,
        "{name}"
    );
    let mut longest: f64 = 0.0;
    for (time, load) in loads {
        let (point, arrow) = arrow_at(glb, node, *time);
        longest = longest.max(arrow.norm());
        let Some([at, vector]) = load else {
            assert!(arrow.norm() <= 0.0, "{name} at {time} s");
            continue;
        };
        assert_near(&point, at, SINGLE * at.amax());
        // The direction of an arrow is rounded, and the length in the name.
        let tolerance = SINGLE_TURN * vector.norm() + NAMED * vector.norm();
        assert_near(&(arrow * largest / length), vector, tolerance);
    }
    assert!(longest <= length * (1.0 + NAMED));
}

fn norms<'a>(loads: impl IntoIterator<Item = &'a Option<[Vector3<f64>; 2]>>) -> f64 {
    let vectors = loads.into_iter().flatten().map(|load| load[1].norm());
    vectors.fold(0.0, f64::max)
}

#[test]
fn an_arrow_is_the_force_on_the_first_body_that_moves() {
    let world = tumbling(rubbing());
    let trajectory = rollout(&world);
    let glb = read_back(
        "forces",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let times = times(&glb, "block");
    let force = |time: f32, bodies: [usize; 2]| {
        let contacts = world
            .contacts(state_at(&trajectory, time, SLOWDOWN))
            .unwrap();
        let contact = contacts
            .into_iter()
            .find(|contact| contact.bodies == bodies)?;
        // The floor is body 0, and does not move.
        let wrench = if bodies[0] == 0 {
            contact.wrench.on_b
        } else {
            contact.wrench.on_a
        };
        Some([contact.surface.center_of_pressure()?, wrench.force])
    };
    let loads = [[0, 1], [1, 2]].map(|bodies| -> Vec<_> {
        times
            .iter()
            .map(|&time| (time, force(time, bodies)))
            .collect()
    });
    let largest = norms(loads.iter().flatten().map(|(_, load)| load));
    let names = [
        "force between floor and block",
        "force between block and ball",
    ];
    for (name, loads) in names.into_iter().zip(&loads) {
        assert!(loads.iter().any(|(_, load)| load.is_some()));
        assert_arrows(&glb, (name, "N"), loads, largest);
    }
}

#[test]
fn an_arrow_is_the_torque_of_contacts_about_the_center_of_mass() {
    // Elastic, so that the torque is the sum over polygons of arm × pressure, whatever the wrench says.
    let world = tumbling(ELASTIC);
    let trajectory = rollout(&world);
    let glb = read_back(
        "torques",
        &Recording::new(&world, &trajectory).slowed(SLOWDOWN),
    );
    let center_of_mass = [vector![0.04, -0.02, 0.01], Vector3::zeros()];
    let torque = |time: f32, body: usize| {
        let state = state_at(&trajectory, time, SLOWDOWN);
        let center = state.bodies[body]
            .pose
            .transformed_point(&center_of_mass[body - 1]);
        let mut contacts = world.contacts(state).unwrap();
        contacts.retain(|contact| contact.bodies.contains(&body));
        let about_center = contacts.iter().flat_map(|contact| {
            let sign = if contact.bodies[0] == body { 1.0 } else { -1.0 };
            let torque = move |polygon: &ContactPolygon| {
                (polygon.center_of_pressure - center).cross(&polygon.force()) * sign
            };
            contact.surface.polygons.iter().map(torque)
        });
        (!contacts.is_empty()).then(|| [center, about_center.sum()])
    };
    let times = times(&glb, "block");
    let loads = [1, 2].map(|body| -> Vec<_> {
        times
            .iter()
            .map(|&time| (time, torque(time, body)))
            .collect()
    });
    let largest = norms(loads.iter().flatten().map(|(_, load)| load));
    for (name, loads) in ["block", "ball"].into_iter().zip(&loads) {
        let beginning = format!("contact torque on {name}");
        assert!(loads.iter().any(|(_, load)| load.is_some()));
        assert_arrows(&glb, (&beginning, "N m"), loads, largest);
    }
}

#[test]
fn an_arrow_is_a_closed_surface_of_length_one_along_z() {
    let world = tumbling(rubbing());
    let glb = read_back("arrows", &Recording::new(&world, &rollout(&world)));
    for beginning in ["force between floor and block", "contact torque on block"] {
        let arrow = glb.mesh(glb.node(beginning));
        let heights = arrow.points.iter().map(|point| point.z);
        let ends = [f64::min, f64::max].map(|extreme| heights.clone().reduce(extreme).unwrap());
        assert!(ends[0].abs() <= SINGLE && (ends[1] - 1.0).abs() <= SINGLE);
        assert!(arrow.points.iter().all(|point| point.xy().norm() < 0.1));
        let outwards: Vector3<f64> = arrow
            .corners()
            .map(|[a, b, c]| (b - a).cross(&(c - a)))
            .sum();
        assert!(
            outwards.norm() < SINGLE_TURN * arrow.area(),
            "it has a hole"
        );
        assert!(arrow.volume() > 0.0, "it is inside out");
    }
}

#[test]
fn a_central_blow_has_no_torque() {
    let world = resting();
    let glb = read_back("central", &Recording::new(&world, &standing(&world)));
    assert_eq!(glb.nodes("force between").len(), 1);
    assert_eq!(
        glb.nodes("contact torque").len(),
        0,
        "an arrow for round-off"
    );
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
fn bodies_of_one_shape_share_its_numbers() {
    let world = tumbling(ELASTIC);
    let glb = read_back("shared", &Recording::new(&world, &standing(&world)));
    let numbers = |body| {
        let primitives = glb.primitives(glb.node(body)).iter();
        let positions = |attributes: &std::collections::BTreeMap<_, _>| {
            attributes[&Checked::Valid(Semantic::Positions)]
        };
        let numbers = primitives.map(|p| (positions(&p.attributes), p.indices.unwrap()));
        numbers.collect::<Vec<_>>()
    };
    assert_eq!(numbers("ball"), numbers("twin"));
    assert_ne!(numbers("ball"), numbers("block"));
    let [skin, edges] = &numbers("block")[..] else {
        panic!("a block has a skin and edges")
    };
    assert_eq!(skin.0, edges.0);
    let block = glb.mesh(glb.node("block"));
    assert!((block.volume() / 6e-3 - 1.0).abs() < 1e-6);
    // Two indices for each of the twelve edges: no diagonal shows.
    assert_eq!(glb.root.get(edges.1).unwrap().count.0, 24);
}

#[test]
fn a_target_is_a_ball_around_its_point() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let point = vector![0.3, -1.7, 0.1];
    let recording = Recording::new(&world, &trajectory).with_target("bull's eye", point, 0.05);
    let glb = read_back("target", &recording);
    let node = glb.node("bull's eye");
    let shown = glb.placement(node, 0.0);
    assert_near(&shown.translation, &point, SINGLE * point.amax());
    let ball = glb.mesh(node);
    for p in &ball.points {
        assert!((p.norm() * shown.scale.x - 0.05).abs() < SINGLE);
    }
    assert!(ball.volume() > 0.8 * 4.0 / 3.0 * std::f64::consts::PI);
}

/// The mesh of a path through points.
fn tube(name: &str, points: &[Vector3<f64>]) -> Option<Mesh> {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let recording = Recording::new(&world, &trajectory);
    let glb = read_back(name, &recording.with_path("way", points.to_vec()));
    glb.nodes("way").first().map(|&node| glb.mesh(node))
}

#[test]
fn a_path_is_a_tube_around_its_line() {
    for (name, to) in [
        ("along_z", Vector3::z()),
        ("aslant", vector![0.6, 0.0, -0.8]),
    ] {
        let from = vector![0.1, 0.2, 0.3];
        let tube = tube(name, &[0.0, 0.5, 2.0].map(|along| from + to * along)).unwrap();
        let along: Vec<f64> = tube.points.iter().map(|p| (p - from).dot(&to)).collect();
        let ends = |extreme: fn(f64, f64) -> f64| along.iter().copied().reduce(extreme).unwrap();
        let tolerance = 4.0 * SINGLE;
        assert!(ends(f64::min).abs() < tolerance && (ends(f64::max) - 2.0).abs() < tolerance);
        let across = |p: &Vector3<f64>| (p - from).cross(&to).norm();
        let radius = across(&tube.points[0]);
        assert!(radius > 1e-3 && radius < 0.05, "{radius}");
        assert!(
            tube.points
                .iter()
                .all(|p| (across(p) - radius).abs() < tolerance)
        );
        // Square, so each side is √2 of the radius.
        let sides = 4.0 * SQRT_2 * radius * 2.0;
        assert!(
            (tube.area() / sides - 1.0).abs() < 1e-5,
            "{} {sides}",
            tube.area()
        );
    }
}

#[test]
fn a_path_that_stays_for_a_while_has_the_same_tube() {
    let [a, b, c] = [
        vector![0.0, 0.0, 1.0],
        vector![0.0, 0.0, 2.0],
        vector![0.5, 0.0, 2.0],
    ];
    let moving = tube("moving", &[a, b, c]).unwrap();
    let staying = tube("staying", &[a, a, b, b, b, c, c]).unwrap();
    assert_eq!(moving.points, staying.points);
    assert_eq!(moving.triangles, staying.triangles);
}

#[test]
fn a_path_that_turns_back_keeps_its_thickness() {
    let [a, b] = [vector![0.1, 0.0, 1.0], vector![1.1, 0.0, 1.0]];
    let there = tube("there", &[a, b]).unwrap();
    let back = tube("and_back", &[a, b, a]).unwrap();
    assert!((back.area() / there.area() - 2.0).abs() < 1e-5);
}

#[test]
fn a_path_of_one_place_is_not_shown() {
    let place = vector![0.1, 0.2, 0.3];
    for (name, points) in [
        ("none", &[][..]),
        ("one", &[place]),
        ("same", &[place, place]),
    ] {
        assert!(tube(name, points).is_none());
    }
}

#[test]
fn a_camera_looks_at_its_point_upright() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let point = vector![0.2, 0.1, 0.3];
    for (name, eye) in [
        ("from_the_side", vector![1.5, -2.0, 0.8]),
        ("from_above", point + Vector3::z() * 3.0),
        ("from_below", point - Vector3::z() * 3.0),
    ] {
        let recording = Recording::new(&world, &trajectory).seen_from(eye, point);
        let glb = read_back(name, &recording);
        let shown = glb.placement(glb.node("camera"), 0.0);
        assert_near(&shown.translation, &eye, SINGLE * eye.amax());
        let looks = shown.rotation * -Vector3::z();
        assert_near(&looks, &(point - eye).normalize(), SINGLE_TURN);
        let right = shown.rotation * Vector3::x();
        assert!(right.z.abs() < SINGLE_TURN, "it leans");
        assert!(
            (shown.rotation * Vector3::y()).z > -SINGLE_TURN,
            "it is upside down"
        );
    }
}

/// The error of a recording; nothing is written.
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
        assert!(matches!(error, FileError::CameraTooNear { .. }), "{error}");
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
        let FileError::TargetRadius { target, radius, .. } = error else {
            panic!("{error}")
        };
        assert_eq!((target.as_str(), radius.to_bits()), ("cup", bad.to_bits()));
    }
}

#[test]
fn a_state_that_is_not_finite_in_single_precision_is_refused() {
    let world = tumbling(ELASTIC);
    let mut lost = world.initial_state();
    lost.bodies[1].pose = Pose::from_translation(vector![1e300, 0.0, 1.0]);
    let rollout = world.rollout(&Plan::new(TIME_STEP, 0).unwrap());
    let trajectory = rollout.clone().starting_from(lost).unwrap().recorded();
    let error = refused("lost.glb", &Recording::new(&world, &trajectory.unwrap()));
    assert_not_finite(&error, "body \"block\"");
    // No trajectory has a time that is not finite: the state is refused.
    let mut timeless = world.initial_state();
    timeless.time = f64::NAN;
    assert!(rollout.starting_from(timeless).is_err());
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
        let FileError::Slowdown { found, .. } = error else {
            panic!("{error}")
        };
        assert_eq!(found.to_bits(), slowdown.to_bits());
    }
}

#[test]
fn an_empty_world_has_an_empty_scene() {
    let world = World::new(Vec::new()).unwrap();
    let glb = read_back("empty", &Recording::new(&world, &rollout(&world)));
    assert_eq!(glb.root.nodes.len(), 1);
    assert!(glb.root.animations.is_empty() && glb.binary.is_empty());
}

#[test]
fn a_world_where_nothing_moves_has_no_animation() {
    let stone = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
    let stone = Body::fixed("stone", stone, ELASTIC).unwrap();
    let world = World::new(vec![stone]).unwrap().with_gravity(DOWN).unwrap();
    let trajectory = rollout(&world);
    let way = [Vector3::zeros(), Vector3::x()];
    let recording = Recording::new(&world, &trajectory).with_path("way", way);
    let glb = read_back("still", &recording);
    assert!(glb.root.animations.is_empty());
    assert!(
        glb.mesh(glb.node("way")).area() > 1e-3,
        "a path without width"
    );
}

#[test]
fn a_recording_is_the_same_bytes_each_time() {
    let bytes = |name| {
        let world = tumbling(rubbing());
        let trajectory = rollout(&world);
        let recording = Recording::new(&world, &trajectory).slowed(SLOWDOWN);
        read_back(name, &recording);
        fs::read(file(&format!("{name}.glb"))).unwrap()
    };
    assert!(bytes("first") == bytes("second"));
}
