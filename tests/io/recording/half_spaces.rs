//! Half-spaces are drawn as polygons around the motion, cut at each other.

use super::recorded_worlds::{ELASTIC, SINGLE, assert_near, read_back, standing};
use crate::support::worlds::{at, cuboid, dynamic, fixed, turned};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{Body, Material, State, World, WorldError};
use hydroelastic::io::Recording;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Relative rounding error of areas in double precision.
const ROUNDING: f64 = 1e-8;

/// Returns a wall at a distance (m) from the z axis that faces the axis, and so has the normal (−cos, −sin) of an angle.
fn wall_pose(angle: f64, distance: f64) -> Pose {
    let (sine, cosine) = angle.sin_cos();
    let turn = [FRAC_PI_2 * sine, -FRAC_PI_2 * cosine, 0.0];
    turned(turn, [distance * cosine, distance * sine, 0.0])
}

fn half_space(name: &str, pose: Pose) -> Body {
    fixed(name, HalfSpace::rigid(), Material::rigid()).with_pose(pose)
}

/// Returns a block of 0.2 m × 0.2 m × 0.1 m, whose diagonal is 0.3 m.
fn block(pose: Pose) -> Body {
    dynamic("block", cuboid([0.2, 0.2, 0.1]), ELASTIC, 1.0).with_pose(pose)
}

/// Poses of a floor of 0.24 m × 0.3 m and four walls.
fn tray() -> [(&'static str, Pose); 5] {
    [
        ("floor", Pose::identity()),
        ("east", wall_pose(0.0, 0.12)),
        ("north", wall_pose(FRAC_PI_2, 0.15)),
        ("west", wall_pose(PI, 0.12)),
        ("south", wall_pose(-FRAC_PI_2, 0.15)),
    ]
}

/// Areas (m²) of the floor and the walls of the tray. The walls end 0.075 m above a block that ends at 0.15 m.
const TRAY_AREAS: [f64; 5] = [
    0.24 * 0.3,
    0.3 * 0.225,
    0.24 * 0.225,
    0.3 * 0.225,
    0.24 * 0.225,
];

/// Area (m²) of a polygon in the plane z = 0, positive if it is counter-clockwise.
fn area(corners: &[Vector3<f64>]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let doubled = corners.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x);
    doubled.sum::<f64>() / 2.0
}

/// Areas (m²) of the half-spaces of a world in states.
fn areas(world: &World, states: &[&State]) -> Vec<f64> {
    let outlines = world.half_space_outlines(states).unwrap();
    assert!(outlines.iter().flatten().all(|corner| corner.z == 0.0));
    outlines.iter().map(|corners| area(corners)).collect()
}

/// Returns a world of the block at a pose and half-spaces.
fn world_of(block_pose: Pose, half_spaces: &[(&str, Pose)]) -> World {
    let mut bodies = vec![block(block_pose)];
    bodies.extend(
        half_spaces
            .iter()
            .map(|(name, pose)| half_space(name, *pose)),
    );
    World::new(bodies).unwrap()
}

/// Areas (m²) of half-spaces around the block, which is 0.1 m above the origin.
fn areas_of(half_spaces: &[(&str, Pose)]) -> Vec<f64> {
    let world = world_of(at(0.0, 0.0, 0.1), half_spaces);
    areas(&world, &[&world.initial_state()])[1..].to_vec()
}

fn assert_areas(actual: &[f64], expected: &[f64]) {
    assert_eq!(actual.len(), expected.len());
    for (actual, expected) in actual.iter().zip(expected) {
        let error = (actual - expected).abs();
        assert!(error <= ROUNDING, "{actual} m² instead of {expected} m²");
    }
}

#[test]
fn half_spaces_are_drawn_at_the_moving_bodies_with_a_margin() {
    let away = fixed("away", cuboid([0.1; 3]), ELASTIC).with_pose(at(50.0, 0.0, 0.0));
    // The wall is the plane x = -1 and faces along x.
    let wall = turned([0.0, FRAC_PI_2, 0.0], [-1.0, 0.0, 7.0]);
    let bodies = vec![
        block(at(3.0, 2.0, 1.0)),
        away,
        half_space("ground", Pose::identity()),
        half_space("wall", wall),
    ];
    let world = World::new(bodies).unwrap();
    let glb = read_back("half_spaces", &Recording::new(&world, &standing(&world)));
    for (name, center, area) in [
        ("ground", vector![3.0, 2.0, 0.0], 0.35 * 0.35),
        ("wall", vector![-1.0, 2.0, 1.0], 0.35 * 0.25),
    ] {
        let (node, placement) = (glb.node(name), glb.placement(glb.node(name), 0.0));
        let mesh = glb.mesh(node);
        let middle = mesh.points.iter().sum::<Vector3<f64>>() / 4.0;
        let middle = placement.rotation * middle + placement.translation;
        assert_near(&middle, &center, 8.0 * SINGLE * 7.0);
        assert!((mesh.area() - area).abs() <= 8.0 * SINGLE * 7.0, "{name}");
    }
}

#[test]
fn a_floor_and_four_walls_are_drawn_as_a_tray() {
    let world = world_of(at(0.0, 0.0, 0.1), &tray());
    let glb = read_back("tray", &Recording::new(&world, &standing(&world)));
    for ((name, _), expected) in tray().iter().zip(TRAY_AREAS) {
        let area = glb.mesh(glb.node(name)).area();
        assert!((area - expected).abs() <= 8.0 * SINGLE, "{name}: {area}");
    }
    assert_areas(&areas_of(&tray()), &TRAY_AREAS);
}

#[test]
fn planes_that_move_relative_to_a_half_space_do_not_cut_it() {
    let world = world_of(at(0.0, 0.0, 0.1), &tray());
    let start = world.initial_state();
    let motion = turned([0.3, -1.0, 2.0], [0.4, 5.0, -1.0]);
    let mut moved = start.clone();
    for body in &mut moved.bodies {
        body.pose = motion * body.pose;
    }
    assert_areas(&areas(&world, &[&start, &moved])[1..], &TRAY_AREAS);

    // If the east wall moves alone, the floor and the walls beside it end at their margins, 0.175 m from the center. In the frame of the
    // east wall, the floor and the walls beside it do not move, but the block moves by 0.38 m.
    let mut apart = start.clone();
    apart.bodies[2].pose = wall_pose(0.0, 0.5);
    let (wide, height) = (0.12 + 0.175, 0.225);
    let east = 0.3 * (0.15 + 0.25 * vector![0.58, 0.2, 0.1].norm());
    let expected = [wide * 0.3, east, wide * height, 0.3 * height, wide * height];
    assert_areas(&areas(&world, &[&start, &apart])[1..], &expected);
}

#[test]
fn the_motion_of_all_states_is_inside_the_outlines() {
    let world = world_of(at(0.0, 0.0, 0.1), &[("floor", Pose::identity())]);
    let start = world.initial_state();
    let mut end = start.clone();
    end.bodies[0].pose = at(0.6, 0.0, 0.1);
    // The bounding box of both blocks is 0.8 m × 0.2 m × 0.1 m.
    let margin = 0.5 * vector![0.8, 0.2, 0.1].norm();
    let expected = (0.8 + margin) * (0.2 + margin);
    assert_areas(&areas(&world, &[&start, &end])[1..], &[expected]);
}

#[test]
fn outlines_end_at_slanted_hidden_and_many_half_spaces() {
    let floor = ("floor", Pose::identity());
    // The plane x + y = 0.25 cuts a triangle with legs of 0.1 m off the square of 0.35 m.
    let slanted = ("slanted", wall_pose(FRAC_PI_4, 0.125 * 2_f64.sqrt()));
    let cut = areas_of(&[floor, slanted])[0];
    assert_areas(&[cut], &[0.35 * 0.35 - 0.1 * 0.1 / 2.0]);

    let lower = ("lower", at(0.0, 0.0, -0.01));
    let same = ("same", Pose::identity());
    assert_areas(&areas_of(&[lower, floor, same]), &[0.0, 0.1225, 0.1225]);
    let world = world_of(at(0.0, 0.0, 0.1), &[lower, floor]);
    let glb = read_back("hidden", &Recording::new(&world, &standing(&world)));
    assert!(glb.root.get(glb.node("lower")).unwrap().mesh.is_none());

    // Walls around a regular polygon of 20 sides.
    let names: Vec<String> = (0..20).map(|side| format!("side {side}")).collect();
    let mut bowl = vec![floor];
    for (side, name) in names.iter().enumerate() {
        bowl.push((name, wall_pose(PI * side as f64 / 10.0, 0.1)));
    }
    let expected = 20.0 * 0.01 * (PI / 20.0).tan();
    assert_areas(&areas_of(&bowl)[..1], &[expected]);
}

#[test]
fn half_spaces_without_other_bodies_are_two_meters_wide_and_states_must_fit() {
    let alone = World::new(vec![half_space("floor", at(3.0, 0.0, 0.0))]).unwrap();
    assert_areas(&areas(&alone, &[&alone.initial_state()]), &[4.0]);
    assert_areas(&areas(&alone, &[]), &[4.0]);
    let other = world_of(Pose::identity(), &[]);
    let two = world_of(Pose::identity(), &tray());
    let refused = two.half_space_outlines(&[&other.initial_state()]);
    assert!(
        matches!(refused, Err(WorldError::StateSize { .. })),
        "{refused:?}"
    );
}
