//! Derivatives of bodies that loop joints connect: forward mode, reverse mode and differences.

use crate::joints::{JointSum, Joints};
use crate::reverse::{Mixed, compare};
use crate::support::worlds::{at, fixed, icosphere, rigid_floor, rubbing, turned};
use hydroelastic::dynamics::{
    Body, BodyState, Integrator, Joint, JointKind, LoopJoint, Mass, Plan, World,
};
use hydroelastic::gradient::{Experiment, FinalState, JointQuantity, Parameter};
use hydroelastic::spatial::{MassProperties, Pose, Twist};
use nalgebra::{Matrix3, Unit, Vector3, vector};
use std::sync::Arc;

/// Relative error of differences of rollouts.
const DIFFERENCES: f64 = 1e-6;

/// Relative error of differences with respect to numbers whose effect is small. The round-off of a rollout is 1e-12.
const SMALL_DIFFERENCES: f64 = 1e-5;

/// Bar along x, with a ball at its origin.
fn bar(name: &str, mass: f64, length: f64) -> Body {
    let properties = MassProperties {
        mass,
        center_of_mass: vector![length / 2.0, 0.0, 0.0],
        inertia: Matrix3::from_diagonal(&vector![0.2, 1.1, 1.0]) * (mass * length * length / 12.0),
    };
    let skin = rubbing(1e6, 0.5, 0.5);
    Body::dynamic(name, icosphere(0.05, 1), skin, Mass::Properties(properties)).unwrap()
}

/// Parallelogram on a post with an inclined axis. Its lower bar carries a free ball on a loop joint, and rubs on the floor.
fn linkage() -> World {
    let hinge = |name: &str| Joint::revolute(name, Vector3::y_axis());
    let post = fixed("post", icosphere(0.02, 0), rubbing(1e5, 0.5, 0.5))
        .with_pose(turned([0.1, 0.05, 0.2], [0.0, 0.0, 0.42]));
    let left = hinge("left hinge")
        .with_parent("post")
        .with_position(1.2)
        .with_velocity(0.5)
        .with_torque(0.4);
    let right = hinge("right hinge")
        .with_parent("post")
        .with_origin(at(0.3, 0.0, 0.0))
        .with_position(1.2)
        .with_velocity(0.5)
        .with_damping(0.1);
    let lower = hinge("lower hinge")
        .with_parent("left")
        .with_origin(at(0.4, 0.0, 0.0))
        .with_position(-1.2)
        .with_velocity(-0.5);
    let bodies = [
        rigid_floor(0.6),
        post,
        bar("left", 0.8, 0.4).with_joint(left).unwrap(),
        bar("right", 0.7, 0.4).with_joint(right).unwrap(),
        bar("lower", 0.5, 0.3).with_joint(lower).unwrap(),
    ];
    let closed = World::new(bodies.to_vec()).unwrap().initial_state();
    let lower = closed.bodies[4].pose;
    let hanging = Body::dynamic(
        "hanging",
        icosphere(0.04, 1),
        rubbing(1e5, 0.5, 0.5),
        Mass::Properties(MassProperties::solid_ball(0.3, 0.04)),
    );
    World::builder()
        .bodies(bodies)
        .body(hanging.unwrap().with_pose(lower * at(0.15, 0.1, 0.0)))
        .loop_joint(LoopJoint::new(
            "pin",
            JointKind::Revolute(Vector3::y_axis()),
            ("lower", at(0.3, 0.0, 0.0)),
            ("right", at(0.4, 0.0, 0.0)),
        ))
        .loop_joint(LoopJoint::new(
            "hook",
            JointKind::Ball,
            ("hanging", at(0.0, -0.1, 0.0)),
            ("lower", at(0.15, 0.0, 0.0)),
        ))
        .gravity(vector![0.0, 0.0, -9.81])
        .build()
        .unwrap()
}

/// Bar that is welded to a disc on a path, and a ball that slides along an inclined axis of the bar. Both are on loop joints.
fn turning_slide() -> World {
    let path = |time: f64| BodyState {
        pose: turned([0.0, 3.0 * time, 0.0], [0.0, 0.0, 0.5]),
        twist: Twist {
            angular: vector![0.0, 3.0, 0.0],
            linear: Vector3::zeros(),
        },
    };
    let skin = rubbing(1e5, 0.5, 0.5);
    let disc = Body::kinematic("disc", icosphere(0.02, 0), skin, Arc::new(path)).unwrap();
    let axis = Unit::new_normalize(vector![1.0, 0.5, 0.2]);
    let center = vector![0.2, 0.0, 0.0];
    let spin = vector![0.0, 3.0, 0.0];
    let ball = Mass::Properties(MassProperties::solid_ball(0.3, 0.04));
    let ball = Body::dynamic("ball", icosphere(0.04, 1), skin, ball).unwrap();
    World::builder()
        .body(disc)
        .body(
            bar("bar", 0.6, 0.4)
                .with_pose(at(0.0, 0.0, 0.5))
                .with_angular_velocity(spin)
                .with_velocity(spin.cross(&center)),
        )
        .body(
            ball.with_pose(at(0.2, 0.0, 0.5))
                .with_angular_velocity(spin)
                .with_velocity(spin.cross(&center)),
        )
        .loop_joint(LoopJoint::new(
            "weld",
            JointKind::Fixed,
            ("bar", Pose::identity()),
            ("disc", Pose::identity()),
        ))
        .loop_joint(LoopJoint::new(
            "slide",
            JointKind::Prismatic(axis),
            ("ball", Pose::identity()),
            ("bar", at(0.2, 0.0, 0.0)),
        ))
        .gravity(vector![0.0, 0.0, -9.81])
        .build()
        .unwrap()
}

fn parameters() -> Vec<Parameter> {
    vec![
        Parameter::modulus("lower"),
        Parameter::mass("right"),
        Parameter::friction("lower"),
        Parameter::mass("hanging"),
        Parameter::initial_velocity("hanging"),
        Parameter::joint("left hinge", JointQuantity::InitialVelocity),
        Parameter::joint("left hinge", JointQuantity::Torque),
    ]
}

/// Parameters whose effect is small. Gravity has a small effect along the axes of the linkage.
fn small_parameters() -> Vec<Parameter> {
    vec![
        Parameter::Gravity,
        Parameter::initial_angular_velocity("hanging"),
        Parameter::joint("right hinge", JointQuantity::Damping),
    ]
}

#[test]
fn the_lower_bar_touches_the_floor() {
    let plan = Plan::new(5e-3, 20)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    let world = linkage();
    let trajectory = world.rollout(&plan).run().unwrap();
    let mut states = trajectory.states().iter();
    assert!(states.any(|state| !world.contacts(state).unwrap().is_empty()));
}

#[test]
fn both_modes_agree() {
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        let plan = Plan::new(5e-3, 20).unwrap().with_integrator(integrator);
        let mut all = parameters();
        all.extend(small_parameters());
        all.extend([
            Parameter::initial_position("post"),
            Parameter::initial_orientation("post"),
        ]);
        compare(&linkage(), &plan, &all, &Mixed { every: 7 });
        compare(&linkage(), &plan, &all, &JointSum);
    }
}

#[test]
fn both_modes_and_differences_agree_for_a_slide_on_a_path() {
    let world = turning_slide();
    // The mass of the ball has no effect, because the path determines all motions but the slide.
    let parameters = [Parameter::Gravity, Parameter::initial_velocity("ball")];
    let poses = [
        Parameter::initial_position("ball"),
        Parameter::initial_orientation("ball"),
    ];
    let all = [&parameters[..], &poses].concat();
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        let plan = Plan::new(5e-3, 20).unwrap().with_integrator(integrator);
        compare(&world, &plan, &all, &Mixed { every: 7 });
    }
    let plan = Plan::new(5e-3, 10)
        .unwrap()
        .with_integrator(Integrator::ImplicitEuler);
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let experiment = Experiment::new(&world, &plan);
    let check = experiment.difference_check(&parameters, &outcome).unwrap();
    assert!(check.best() < DIFFERENCES, "{:e}", check.best());
}

#[test]
fn derivatives_agree_with_differences() {
    let plan = Plan::new(2e-3, 10)
        .unwrap()
        .with_integrator(Integrator::ImplicitEuler)
        .with_solver_tolerance(1e-13)
        .unwrap();
    for (parameters, tolerance) in [
        (parameters(), DIFFERENCES),
        (small_parameters(), SMALL_DIFFERENCES),
    ] {
        let experiment = Experiment::new(linkage(), &plan);
        let check = experiment.difference_check(&parameters, &Joints).unwrap();
        assert!(check.best() < tolerance, "{:e}", check.best());
    }
}
