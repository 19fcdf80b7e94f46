//! Derivatives of motions at the default accuracy, in steps of 5 ms, against the exact motion: closed forms, and differences of outcomes at
//! tight tolerances over changes wider than their noise.

use crate::support::impacts::rebound;
use crate::support::worlds::{dynamic, fixed, icosphere, plan_of, rubbing, sliding_at};
use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{Accuracy, Body, BodyState, Integrator, Mass, Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{DMatrix, DVector, Vector3, vector};
use std::sync::Arc;

/// Longest step (s), which is many times as long as an impact.
pub const TIME_STEP: f64 = 5e-3;

/// Largest error of a derivative, relative to the largest entry of its column.
const OFF: f64 = 0.02;

/// Returns the tolerances of the motions with which derivatives are compared.
pub fn tight() -> Accuracy {
    let accuracy = Accuracy::new(1e-6, 3e-5).unwrap();
    accuracy.with_resting_speed(0.03).unwrap()
}

pub fn plan(steps: usize) -> Plan {
    plan_of(Integrator::Sdirk3, TIME_STEP, steps).recording_every(steps)
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

pub fn rigid_floor(friction: f64) -> Body {
    let skin = Material::rigid().with_friction(friction);
    fixed("floor", HalfSpace::rigid(), skin)
}

pub fn ball(radius: f64, skin: Material) -> Body {
    let shape = icosphere(radius, 2);
    dynamic("body", shape, skin, 1.0)
}

pub fn cuboid(edges: [f64; 3], skin: Material) -> Body {
    let shape = Shape::new(shapes::cuboid(edges).unwrap());
    dynamic("body", shape, skin, 1.0)
}

pub fn falling(bodies: Vec<Body>) -> World {
    let world = World::new(bodies).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

/// Returns the Jacobian of the body's final state with respect to parameters, the position first.
fn jacobian(world: &World, plan: &Plan, by: &[Parameter]) -> DMatrix<f64> {
    let outcome = FinalState::of_body(world, "body").unwrap();
    let experiment = Experiment::new(world, plan);
    experiment.jacobian(by, &outcome).unwrap().jacobian
}

/// Compares the derivatives of the final position with respect to each component of a parameter with differences over a change to either
/// side. A change of 1e-3 is wide enough, because outcomes at tight tolerances have noise of up to 1e-6.
fn check((label, world, plan): (&str, &World, &Plan), by: &Parameter, change: f64) {
    let by = std::slice::from_ref(by);
    let found = jacobian(world, plan, by).rows(0, 3).into_owned();
    let outcome = FinalState::of_body(world, "body").unwrap();
    let motion = Experiment::new(world, &plan.with_accuracy(tight()));
    let column = |place: usize| {
        let end = |times: f64| {
            let mut changes = vec![0.0; found.ncols()];
            changes[place] = times * change;
            let end = motion.value_perturbed(by, &changes, &outcome).unwrap();
            DVector::from_vec(end).rows(0, 3).into_owned()
        };
        // This difference is of fourth order.
        ((end(1.0) - end(-1.0)) * 8.0 - (end(2.0) - end(-2.0))) / (12.0 * change)
    };
    for place in 0..found.ncols() {
        let expected = column(place);
        let off = (found.column(place) - &expected).amax() / expected.amax();
        println!(
            "{label}, {:?} {place}: off by {off:.1e} of {:.3}",
            by[0],
            expected.amax()
        );
        assert!(off < OFF, "{label}, {:?} {place}: off by {off}", by[0]);
    }
}

/// Returns the ball of the guide: E 1e9 Pa, friction and dissipation, thrown from 0.25 m plus a rise (m).
pub fn throw(rise: f64) -> World {
    let skin = rubbing(1e9, 0.3, 0.4);
    let body = ball(0.05, skin)
        .with_pose(at(0.013, 0.017, 0.25 + rise))
        .with_velocity(vector![0.3, 0.1, 0.0]);
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.4]).unwrap());
    let floor = fixed("floor", floor, skin).with_pose(at(0.0, 0.0, -0.2));
    falling(vec![body, floor])
}

/// Returns two elastic balls of radius 0.1 m, of which "left" moves at 1 m/s towards "body". Their centers are `distance` (m) apart.
pub fn head_on(distance: f64) -> World {
    let skin = Material::elastic(1e9);
    let [left, right] = ["left", "body"].map(|name| dynamic(name, icosphere(0.1, 1), skin, 1.0));
    World::new(vec![
        left.with_velocity(vector![1.0, 0.0, 0.0]),
        right.with_pose(at(distance, 0.0, 0.0)),
    ])
    .unwrap()
}

#[test]
fn a_thrown_ball_has_the_derivatives_of_its_motion() {
    for rise in [0.0, 0.002, 0.004, 0.006] {
        let world = throw(rise);
        let label = format!("throw from {rise}");
        check(
            (&label, &world, &plan(60)),
            &Parameter::initial_velocity("body"),
            1e-3,
        );
    }
}

/// Facets of the ball touch one after the other. For an exact sphere, the derivative is −1.
#[test]
fn an_elastic_bounce_has_the_derivative_minus_one() {
    for phase in 0..8 {
        let rise = 5.0 * TIME_STEP * f64::from(phase) / 8.0;
        let body = ball(0.1, Material::elastic(1e9))
            .with_pose(at(0.0, 0.0, 0.4 + rise))
            .with_velocity(vector![0.0, 0.0, -5.0]);
        let world = World::new(vec![body, rigid_floor(0.0)]).unwrap();
        let found = jacobian(&world, &plan(40), &[Parameter::initial_position("body")]);
        assert!((found[(2, 2)] + 1.0).abs() < 0.04, "{}", found[(2, 2)]);
        check(
            (&format!("bounce {phase}"), &world, &plan(40)),
            &Parameter::initial_position("body"),
            1e-3,
        );
    }
}

/// The stiffness jumps when a whole face touches.
#[test]
fn a_flat_fall_has_the_derivatives_of_the_closed_form() {
    for rise in [0.0, 0.002, 0.004, 0.006] {
        let body = cuboid([0.1; 3], Material::elastic(1e9)).with_pose(at(0.0, 0.0, 0.15 + rise));
        let world = falling(vec![body, rigid_floor(0.0)]);
        let by = [Parameter::initial_position("body")];
        let found = jacobian(&world, &plan(60), &by)[(2, 2)];
        // A fall from h takes √(2h/g). The contact takes half a period of the linear spring, which does not depend on h. Then z = v t − g
        // t²/2, with v = √(2gh) and t the time left after fall and contact.
        let (gravity, height) = (9.81_f64, 0.1 + rise);
        let (fall, speed) = (
            (2.0 * height / gravity).sqrt(),
            (2.0 * gravity * height).sqrt(),
        );
        let stiffness = 0.1 * 0.1 * 1e9 / 0.05;
        let left = 0.3 - fall - std::f64::consts::PI / f64::sqrt(stiffness);
        let [by_fall, by_speed] = [1.0 / speed, gravity / speed];
        let expected = by_speed * left - (speed - gravity * left) * by_fall;
        println!("flat from {rise}: {found} instead of {expected}");
        assert!(
            (found / expected - 1.0).abs() < OFF,
            "{found} for {expected}"
        );
    }
}

#[test]
fn two_balls_exchange_their_velocities() {
    let world = head_on(0.52);
    let by = [
        Parameter::initial_position("left"),
        Parameter::initial_position("body"),
        Parameter::initial_velocity("left"),
        Parameter::initial_velocity("body"),
    ];
    let found = jacobian(&world, &plan(200), &by);
    // Bodies of equal mass exchange their velocities.
    for (place, expected) in [1.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
        let found = found[(0, 3 * place)];
        println!("exchange {place}: {found}");
        assert!((found - expected).abs() < OFF, "{place}: {found}");
    }
}

/// The derivative of the speed after an impact with respect to the speed before it is that of G(−v′) = G(v), with G of [`rebound`].
#[test]
fn an_impact_with_dissipation_has_the_derivative_of_the_closed_form() {
    let (speed, dissipation) = (1.0_f64, 1.0_f64);
    let after = rebound(speed, dissipation);
    let slope = speed / (1.0 + dissipation * speed) * (1.0 - dissipation * after) / after;
    let skin = Material::elastic(1e9).with_dissipation(dissipation);
    for phase in 0..5 {
        let body = ball(0.1, skin)
            .with_pose(at(0.0, 0.0, 0.12 + TIME_STEP * f64::from(phase) / 5.0))
            .with_velocity(vector![0.0, 0.0, -speed]);
        let world = World::new(vec![body, rigid_floor(0.0)]).unwrap();
        let by = [Parameter::initial_velocity("body")];
        let outcome = FinalState::of_body(&world, "body").unwrap();
        let found = Experiment::new(&world, &plan(30))
            .jacobian(&by, &outcome)
            .unwrap();
        let (rows, value) = (found.jacobian, found.value);
        let velocity = 14; // along z, after position and rotation
        println!(
            "Hunt and Crossley {phase}: {} instead of {after}, {} instead of {slope}",
            value[velocity],
            -rows[(velocity, 2)]
        );
        assert!((value[velocity] / after - 1.0).abs() < 1e-3);
        assert!((-rows[(velocity, 2)] / slope - 1.0).abs() < 5e-3);
    }
}

/// The stopping distance is v²/(2μg).
#[test]
fn a_slide_to_a_stop_has_the_derivatives_of_the_textbook() {
    let skin = rubbing(1e9, 0.5, 0.5);
    let depth = 9.81 * 0.05 / (0.2 * 0.2 * 1e9);
    let body = cuboid([0.2, 0.2, 0.1], skin)
        .with_pose(at(0.0, 0.0, 0.05 - depth))
        .with_velocity(vector![1.0, 0.0, 0.0]);
    let world = falling(vec![body, rigid_floor(0.5)]);
    let by = [
        Parameter::initial_velocity("body"),
        Parameter::friction("body"),
    ];
    let found = jacobian(&world, &plan(100), &by);
    let by_speed = 1.0 / (0.5 * 9.81);
    // The coefficient of the pair depends on those of both bodies. If these are equal, its derivative with respect to one of them is 1/2.
    let by_friction = -0.5 / (2.0 * 0.25 * 9.81);
    println!(
        "slide: {} {}",
        found[(0, 0)] / by_speed,
        found[(0, 3)] / by_friction
    );
    assert!((found[(0, 0)] / by_speed - 1.0).abs() < OFF);
    assert!((found[(0, 3)] / by_friction - 1.0).abs() < OFF);
}

/// A small, fast ball passes neither through a thin plate nor through a half-space.
#[test]
fn fast_balls_do_not_pass_through_thin_bodies() {
    let small = |modulus| {
        let shape = icosphere(0.01, 2);
        let mass = Mass::Density(1000.0);
        Body::dynamic("body", shape, Material::elastic(modulus), mass).unwrap()
    };
    let plate = shapes::cuboid([1.0, 1.0, 0.01]).unwrap();
    let plate = RigidShape::new(TriangleSurface::around(plate.mesh()).unwrap());
    let plate = || fixed("plate", plate.clone(), Material::rigid());
    let thrown = |modulus: f64, speed: f64, height: f64| {
        let body = small(modulus).with_pose(at(0.013, 0.017, height));
        body.with_velocity(vector![0.0, 0.0, -speed])
    };
    for phase in 0..20 {
        let start = |speed: f64| 0.06 + speed * TIME_STEP * f64::from(phase) / 20.0;
        for (speed, bodies) in [
            (5.0, vec![thrown(1e7, 5.0, start(5.0)), plate()]),
            (10.0, vec![thrown(1e9, 10.0, start(10.0)), rigid_floor(0.0)]),
        ] {
            let world = World::new(bodies).unwrap();
            let plan = plan(20);
            let end = world.rollout(&plan).run().unwrap();
            let velocity: Vector3<f64> = *end.last().bodies[0].velocity();
            assert!(
                (velocity.norm() / speed - 1.0).abs() < 2e-3 && velocity.z > 0.9 * speed,
                "{phase}: {velocity:?}"
            );
        }
    }
}

/// A ball that falls on the floor of a moving train bounces as on a floor at rest.
#[test]
fn a_bounce_on_a_train_has_the_derivatives_of_one_at_rest() {
    let skin = Material::elastic(1e7);
    let found = [0.0, 10.0, 30.0, 100.0].map(|speed| {
        let body = ball(0.05, skin)
            .with_pose(at(0.013, 0.017, 0.153))
            .with_velocity(vector![speed, 0.0, 0.0]);
        let floor = Shape::new(shapes::cuboid([1.0, 1.0, 0.4]).unwrap());
        let ride = move |time: f64| BodyState {
            pose: at(speed * time, 0.0, -0.2),
            twist: sliding_at(vector![speed, 0.0, 0.0]),
        };
        let floor = Body::kinematic("floor", floor, skin, Arc::new(ride)).unwrap();
        let world = falling(vec![body, floor]);
        let by = [Parameter::initial_velocity("body")];
        let outcome = FinalState::of_body(&world, "body").unwrap();
        let found = Experiment::new(&world, &plan(50))
            .jacobian(&by, &outcome)
            .unwrap();
        [found.value[2], found.jacobian[(2, 2)]]
    });
    println!("on a train: {found:?}");
    let [[height, slope], ..] = found;
    for [other_height, other_slope] in found {
        assert!((other_height - height).abs() < 1e-3 * height);
        assert!(
            (other_slope - slope).abs() < 0.01 * slope.abs(),
            "{found:?}"
        );
    }
}
