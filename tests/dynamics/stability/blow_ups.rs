//! The largest stable time step against rollouts that blow up just above it and not just below.

use super::scenes::{
    EDGE, REST, assert_close, bisected, cube, cube_on_slab, limit, slab, with_gravity,
};
use crate::scenes::{GRAVITY, at};
use crate::support::worlds::dynamic;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, BodyState, Material, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Rotation3, Vector3, vector};

/// Resolution of a limit determined by blow-ups. At 1.0005 of the limit, 4,000 steps multiply an elastic disturbance by
/// exp(4,000·√(8·0.0005)), and a disturbance dominated by damping by exp(4,000·0.001) = 55. At 0.9995 of the limit, they multiply an
/// elastic disturbance by up to 1/√(1 − 0.9995²) = 32. A factor of 50 distinguishes both cases.
const RESOLUTION: f64 = 1e-3;
const STEPS: usize = 4_000;
const GROWTH: f64 = 50.0;

/// Disturbance (m/s, and rad/s times the size of a body). It is far below the slip tolerance and the reciprocal of any dissipation here, so
/// the response is linear until it has grown.
const DISTURBANCE: f64 = 1e-8;

/// Returns the largest speed of a body (m/s, angular velocity times 0.1 m).
fn speed(state: &State) -> f64 {
    let of_body = |body: &BodyState| body.twist.linear.norm() + 0.1 * body.twist.angular.norm();
    state.bodies.iter().map(of_body).fold(0.0, f64::max)
}

/// Returns whether a slight disturbance of a state at rest has grown after many steps.
fn blows_up(world: &World, time_step: f64) -> bool {
    let mut state = world.initial_state();
    for (body, number) in world.bodies().iter().zip(&mut state.bodies) {
        if body.inertia().is_some() {
            number.twist.linear = vector![0.4, -0.5, 0.7] * DISTURBANCE;
            number.twist.angular = vector![0.6, 0.3, -0.5] * (DISTURBANCE / EDGE);
        }
    }
    let start = speed(&state);
    let plan = Plan::new(time_step, STEPS).unwrap();
    let rollout = world.rollout(&plan.without_stability_check());
    let mut states = rollout.with_state(state).unwrap().take(STEPS);
    states.any(|state| state.map_or(true, |state| speed(&state) > GROWTH * start))
}

fn assert_blows_up_at_the_limit(world: &World) {
    let found = limit(world);
    let range = [found / 2.0, found * 2.0];
    let blown = bisected(range, RESOLUTION / 10.0, |step| blows_up(world, step));
    println!("{found:e} {:e}", found / blown - 1.0);
    assert_close(found, blown, RESOLUTION);
}

/// Asserts that a rollout ends with an error above the stability limit, and not below it.
fn assert_checked_at_the_limit(world: &World) {
    let found = limit(world);
    for (part, is_stopped) in [(0.98, false), (1.02, true)] {
        let plan = Plan::new(part * found, STEPS).unwrap();
        let ended = world.rollout(&plan.recording_every(STEPS)).run();
        assert_eq!(ended.is_err(), is_stopped, "{part} of {found:e} s");
    }
}

#[test]
fn an_elastic_cube_blows_up_at_the_limit() {
    let world = cube_on_slab(Material::elastic(1e6), REST);
    assert_blows_up_at_the_limit(&world);
    assert_checked_at_the_limit(&world);
}

#[test]
fn a_cube_ruled_by_dissipation_blows_up_at_the_limit() {
    let world = cube_on_slab(Material::elastic(1e6).with_dissipation(1e3), REST);
    let elastic = cube_on_slab(Material::elastic(1e6), REST);
    assert!(limit(&world) < 0.1 * limit(&elastic));
    assert_blows_up_at_the_limit(&world);
    assert_checked_at_the_limit(&world);
}

#[test]
fn a_cube_ruled_by_friction_blows_up_at_the_limit() {
    let world = cube_on_slab(Material::elastic(1e6).with_friction(0.5), REST);
    let elastic = cube_on_slab(Material::elastic(1e6), REST);
    assert!(limit(&world) < 0.1 * limit(&elastic));
    assert_blows_up_at_the_limit(&world);
}

#[test]
fn a_cube_ruled_by_nothing_alone_blows_up_at_the_limit() {
    let skin = Material::elastic(1e6).with_dissipation(30.0);
    assert_blows_up_at_the_limit(&cube_on_slab(skin.with_friction(0.01), REST));
}

/// Number of steps until bodies with high dissipation come to rest to round-off. More steps are worse, because a stack without friction
/// slides apart, 34 times as fast every 5,000 steps.
const SETTLING: usize = 10_000;

/// Returns a world with bodies at rest.
fn at_rest(bodies: impl Fn(Material) -> Vec<Body>, skin: Material) -> World {
    let damped = Material::elastic(skin.modulus.unwrap()).with_dissipation(10.0);
    let world = with_gravity(World::new(bodies(damped)).unwrap());
    let plan = Plan::new(limit(&world) / 2.0, SETTLING + 1).unwrap();
    let rest = world.rollout(&plan).nth(SETTLING).unwrap().unwrap();
    assert!(speed(&rest) < 1e-3 * DISTURBANCE, "{:e}", speed(&rest));
    let bodies = bodies(skin).into_iter().zip(&rest.bodies);
    let placed = bodies.map(|(body, state)| body.with_pose(state.pose));
    with_gravity(World::new(placed.collect()).unwrap())
}

/// Returns a coarse ball that stands on a face, and a slab. The ball is so light that the face's stiffness keeps it upright.
fn ball_on_slab(skin: Material) -> Vec<Body> {
    let field = shapes::icosphere(EDGE / 2.0, 1).unwrap();
    // The face in the middle of an icosahedron's face: its normal passes through its centroid.
    let faces = field.mesh().surface_triangles().iter();
    let corners = faces.map(|face| face.map(|vertex| field.mesh().vertices()[vertex]));
    let (normal, distance) = corners
        .map(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a)).normalize();
            let off = (a + b + c).cross(&normal).norm();
            (off, normal, a.dot(&normal))
        })
        .min_by(|one, other| one.0.total_cmp(&other.0))
        .map(|(_, normal, distance)| (normal, distance))
        .unwrap();
    let turn = Rotation3::rotation_between(&normal, &-Vector3::z()).unwrap();
    let place = vector![0.03, 0.05, distance - 1e-5];
    let ball = dynamic("ball", Shape::new(field), skin, 0.2);
    vec![
        ball.with_pose(Pose::new(turn.into_inner(), place).unwrap()),
        slab(skin),
    ]
}

#[test]
fn a_ball_on_a_slab_blows_up_at_the_limit() {
    let elastic = Material::elastic(1e6);
    for skin in [
        elastic,
        elastic.with_dissipation(30.0),
        elastic.with_dissipation(30.0).with_friction(0.02),
        elastic.with_friction(0.5),
    ] {
        assert_blows_up_at_the_limit(&at_rest(ball_on_slab, skin));
    }
}

/// Returns a cube on a larger cube on a slab.
fn two_on_slab(skin: Material) -> Vec<Body> {
    let lower = cube("lower", EDGE, skin).with_pose(at(0.03, 0.05, EDGE / 2.0 - 1e-4));
    let above = EDGE + 0.08 - 2e-4;
    let upper = cube("upper", 0.16, skin).with_pose(at(0.03, 0.05, above));
    vec![lower, upper, slab(skin)]
}

#[test]
fn a_stack_of_two_blows_up_at_the_limit() {
    let elastic = Material::elastic(1e6);
    for skin in [
        elastic,
        elastic.with_dissipation(30.0),
        elastic.with_dissipation(30.0).with_friction(0.01),
        elastic.with_friction(0.5),
    ] {
        assert_blows_up_at_the_limit(&at_rest(two_on_slab, skin));
    }
}

#[test]
fn friction_beyond_its_limit_chatters_and_does_not_blow_up() {
    let world = cube_on_slab(Material::elastic(1e6).with_friction(0.5), REST);
    let time_step = 6.0 * limit(&world);
    let mut state = world.initial_state();
    state.bodies[0].twist.linear.x = DISTURBANCE;
    let plan = Plan::new(time_step, STEPS).unwrap();
    let rollout = world.rollout(&plan.without_stability_check());
    let states = rollout.with_state(state).unwrap().take(STEPS);
    let fastest = states
        .map(|state| speed(&state.unwrap()))
        .fold(0.0, f64::max);
    // Change of the velocity in a step by the largest friction.
    let kick = 0.5 * GRAVITY * time_step;
    println!("{} of a kick", fastest / kick);
    assert!(fastest > 0.1 * kick && fastest < 3.0 * kick);
}
