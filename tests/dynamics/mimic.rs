//! Joints that mimic other joints.

use crate::scenes::at;
use hydroelastic::dynamics::{
    Body, BodyShape, Integrator, Joint, Mass, Material, Plan, World, WorldError,
};
use hydroelastic::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3, dvector, vector};

/// Rounding error of 100 implicit steps.
const ROUND_OFF: f64 = 1e-11;

/// Wheel on an axle along z.
fn wheel(name: &str, inertia: f64, joint: Joint) -> Body {
    let mass = MassProperties {
        mass: 1.0,
        inertia: Matrix3::identity() * inertia,
        ..MassProperties::zero()
    };
    Body::dynamic(name, BodyShape::None, Material::rigid(), Mass::Link(mass))
        .unwrap()
        .with_joint(joint)
        .unwrap()
}

fn axle(name: &str) -> Joint {
    Joint::revolute(name, Vector3::z_axis())
}

/// Angle and velocity of the first joint, and the pose of the last body, after 1 s.
fn after_one_second(world: &World) -> ([f64; 2], f64) {
    let plan = Plan::new(0.01, 100)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    let trajectory = world.rollout(&plan).run().unwrap();
    let last = trajectory.last();
    assert_eq!(last.joints.len(), 1);
    let joint = &last.joints[0];
    let spin = last.bodies.last().unwrap().twist.angular.z;
    ([joint.position().unwrap(), joint.velocity().unwrap()], spin)
}

#[test]
fn a_gear_reflects_the_inertia_of_the_driven_wheel() {
    let driven = axle("driven")
        .with_origin(at(0.5, 0.0, 0.0))
        .with_mimic("driver", -5.0, 0.3);
    let driver = axle("driver").with_torque(2.0);
    for order in [[0, 1], [1, 0]] {
        let wheels = [
            wheel("small", 0.3, driver.clone()),
            wheel("large", 0.02, driven.clone()),
        ];
        let world = World::new(order.map(|index| wheels[index].clone()).into()).unwrap();
        let ([angle, velocity], spin) = after_one_second(&world);
        // 0.3 + 25·0.02 kg m².
        assert!((velocity - 2.0 / 0.8).abs() < ROUND_OFF);
        assert!((angle - 1.0 / 0.8).abs() < ROUND_OFF);
        let expected = if order[1] == 1 {
            -5.0 * velocity
        } else {
            velocity
        };
        assert!((spin - expected).abs() < ROUND_OFF);
    }
}

#[test]
fn the_force_of_the_driven_joint_acts_on_the_driver() {
    let driven = axle("driven")
        .with_mimic("driver", -5.0, 0.0)
        .with_torque(-0.4);
    let world = World::new(vec![
        wheel("small", 0.3, axle("driver")),
        wheel("large", 0.02, driven),
    ]);
    let ([_, velocity], _) = after_one_second(&world.unwrap());
    assert!((velocity - 2.0 / 0.8).abs() < ROUND_OFF);
}

#[test]
fn a_leader_may_have_a_leader() {
    let second = axle("second").with_mimic("first", 2.0, 0.1);
    let third = axle("third").with_mimic("second", 3.0, 0.2);
    let world = World::new(vec![
        wheel("a", 0.1, axle("first").with_torque(1.0)),
        wheel("b", 0.01, second),
        wheel("c", 0.02, third),
    ])
    .unwrap();
    let angle = world.initial_state().bodies[2].pose.rotation()[(1, 0)].asin();
    assert!((angle - (3.0 * 0.1 + 0.2)).abs() < ROUND_OFF);
    let ([_, velocity], spin) = after_one_second(&world);
    assert!((velocity - 1.0 / (0.1 + 4.0 * 0.01 + 36.0 * 0.02)).abs() < ROUND_OFF);
    assert!((spin - 6.0 * velocity).abs() < ROUND_OFF);
}

#[test]
fn coupled_joints_of_a_floating_tree_keep_its_momenta() {
    let mass = MassProperties {
        mass: 2.0,
        center_of_mass: vector![0.1, 0.0, 0.0],
        inertia: Matrix3::from_diagonal(&vector![0.2, 0.3, 0.4]),
    };
    let base = Body::dynamic("base", BodyShape::None, Material::rigid(), Mass::Link(mass)).unwrap();
    let base = base.with_angular_velocity(vector![0.5, -0.3, 0.2]);
    let arm = |name: &str, joint: Joint| {
        let body = Body::dynamic(name, BodyShape::None, Material::rigid(), Mass::Link(mass));
        body.unwrap().with_joint(joint.with_parent("base")).unwrap()
    };
    let left = Joint::revolute("left", Vector3::y_axis()).with_origin(at(0.3, 0.0, 0.1));
    let right = Joint::prismatic("right", Vector3::x_axis()).with_origin(at(-0.3, 0.0, 0.0));
    let world = World::new(vec![
        base,
        arm("left arm", left.with_velocity(1.5)),
        arm("right arm", right.with_mimic("left", -0.2, 0.0)),
    ])
    .unwrap();
    let plan = Plan::new(0.01, 100)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    let trajectory = world.rollout(&plan).run().unwrap();
    let momentum = |state| world.diagnostics(state).unwrap().momentum;
    let [before, after] = [&trajectory.states()[0], trajectory.last()].map(momentum);
    assert!((before.linear - after.linear).norm() < ROUND_OFF);
    assert!((before.angular - after.angular).norm() < ROUND_OFF);
}

#[test]
fn missing_and_cyclic_leaders_and_ball_followers_are_refused() {
    let world =
        |joint: Joint| World::new(vec![wheel("a", 0.1, axle("first")), wheel("b", 0.1, joint)]);
    let error = |leader: &str| WorldError::Mimic {
        joint: "second".into(),
        leader: leader.into(),
    };
    for leader in ["nothing", "second"] {
        let joint = axle("second").with_mimic(leader, 1.0, 0.0);
        assert_eq!(world(joint).unwrap_err(), error(leader));
    }
    let ball = Joint::ball("second").with_mimic("first", 1.0, 0.0);
    assert_eq!(world(ball).unwrap_err(), error("first"));
    let infinite = axle("second").with_mimic("first", f64::INFINITY, 0.0);
    assert!(matches!(world(infinite), Err(WorldError::Joint { .. })));
}

#[test]
fn a_product_of_multipliers_that_is_zero_or_not_finite_is_refused() {
    for (multiplier, product) in [(0.0, 0.0), (1e-200, 0.0), (1e200, f64::INFINITY)] {
        let second = axle("second").with_mimic("first", multiplier, 0.0);
        let third = axle("third").with_mimic("second", multiplier, 0.0);
        let followers = [("b", second), ("c", third)].map(|(name, joint)| wheel(name, 0.1, joint));
        let bodies = [wheel("a", 0.1, axle("first"))]
            .into_iter()
            .chain(followers);
        let error = World::new(bodies.collect()).unwrap_err();
        let WorldError::MimicChain {
            joint,
            leader,
            multiplier: found,
            ..
        } = &error
        else {
            panic!("{error}")
        };
        let expected = if multiplier == 0.0 { "second" } else { "third" };
        assert_eq!((joint.as_str(), leader.as_str()), (expected, "first"));
        assert_eq!(found.to_bits(), product.to_bits());
    }
}

#[test]
fn the_armature_of_a_follower_counts_in_the_energy() {
    let driven = axle("driven")
        .with_mimic("driver", -5.0, 0.0)
        .with_armature(0.02);
    let world = World::new(vec![
        wheel("small", 0.3, axle("driver").with_velocity(2.0)),
        wheel("large", 0.0, driven),
    ])
    .unwrap();
    let energy = world
        .diagnostics(&world.initial_state())
        .unwrap()
        .total_energy();
    assert!((energy - 0.5 * (0.3 + 25.0 * 0.02) * 4.0).abs() < ROUND_OFF);
}

#[test]
fn forward_dynamics_couple_a_follower_to_its_leader() {
    let driven = axle("driven").with_mimic("driver", -5.0, 0.0);
    let world = World::new(vec![
        wheel("small", 0.3, axle("driver")),
        wheel("large", 0.02, driven),
    ])
    .unwrap();
    let kinetics = world.kinetics(&world.initial_state()).unwrap();
    let accelerations = kinetics.forward_dynamics(&dvector![2.0, 0.4]).unwrap();
    // The generalized force is 2 − 5·0.4 N m, and then 2 N m.
    assert!(accelerations.amax() < ROUND_OFF);
    let accelerations = kinetics.forward_dynamics(&dvector![2.0, 0.0]).unwrap();
    assert!((accelerations - dvector![1.0, -5.0] * (2.0 / 0.8)).amax() < ROUND_OFF);
}
