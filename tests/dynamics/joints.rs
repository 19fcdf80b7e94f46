//! Bodies on joints: closed forms, conservation and refusals.

use crate::scenes::at;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Accuracy, Body, Integrator, Joint, JointState, Mass, Material, Plan, RolloutError, State,
    Stops, World, WorldError,
};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::MassProperties;
use nalgebra::{DVector, Matrix3, Unit, Vector3, vector};
use std::f64::consts::PI;

/// Gravity (m/s²).
const GRAVITY: f64 = 9.81;

fn ball(name: &str, properties: MassProperties) -> Body {
    let shape = Shape::new(shapes::icosphere(0.02, 0).unwrap());
    Body::dynamic(
        name,
        shape,
        Material::elastic(1e5),
        Mass::Properties(properties),
    )
    .unwrap()
}

/// A point-like mass (kg) at a distance (m) below the joint, with a rotational inertia (kg m²) about it.
fn bob(mass: f64, distance: f64, inertia: f64) -> MassProperties {
    MassProperties {
        mass,
        center_of_mass: vector![0.0, 0.0, -distance],
        inertia: Matrix3::identity() * inertia,
    }
}

fn world(bodies: Vec<Body>) -> World {
    let world = World::new(bodies).unwrap();
    world.with_gravity(vector![0.0, 0.0, -GRAVITY]).unwrap()
}

/// Two links of 0.4 m on axes along y.
fn double_pendulum(positions: [f64; 2]) -> World {
    let [first, second] = positions;
    let shoulder = Joint::revolute("shoulder", Vector3::y_axis()).with_position(first);
    let elbow = Joint::revolute("elbow", Vector3::y_axis())
        .with_parent("upper")
        .with_origin(at(0.0, 0.0, -0.4))
        .with_position(second);
    world(vec![
        ball("upper", bob(1.2, 0.3, 0.02))
            .with_joint(shoulder)
            .unwrap(),
        ball("lower", bob(0.8, 0.25, 0.01))
            .with_joint(elbow)
            .unwrap(),
    ])
}

/// Accelerations of the double pendulum by Lagrange's equations.
fn accelerations([q1, q2, u1, u2]: [f64; 4]) -> [f64; 2] {
    let ([m1, c1, i1], [m2, c2, i2], l) = ([1.2, 0.3, 0.02], [0.8, 0.25, 0.01], 0.4);
    let coupling = m2 * l * c2;
    let m22 = i2 + m2 * c2 * c2;
    let m12 = m22 + coupling * q2.cos();
    let m11 = i1 + m1 * c1 * c1 + m2 * l * l + m22 + 2.0 * coupling * q2.cos();
    let gravity2 = m2 * GRAVITY * c2 * (q1 + q2).sin();
    let gravity1 = (m1 * c1 + m2 * l) * GRAVITY * q1.sin() + gravity2;
    let right1 = coupling * q2.sin() * (2.0 * u1 * u2 + u2 * u2) - gravity1;
    let right2 = -coupling * q2.sin() * u1 * u1 - gravity2;
    let determinant = m11 * m22 - m12 * m12;
    [
        (m22 * right1 - m12 * right2) / determinant,
        (m11 * right2 - m12 * right1) / determinant,
    ]
}

/// Motion of the double pendulum by the classical Runge–Kutta method with 20,000 steps.
fn reference(mut state: [f64; 4], duration: f64) -> [f64; 4] {
    const STEPS: usize = 20_000;
    let h = duration / STEPS as f64;
    let rate = |s: [f64; 4]| {
        let [a1, a2] = accelerations(s);
        [s[2], s[3], a1, a2]
    };
    let add = |s: [f64; 4], r: [f64; 4], h: f64| std::array::from_fn(|i| s[i] + h * r[i]);
    for _ in 0..STEPS {
        let k1 = rate(state);
        let k2 = rate(add(state, k1, h / 2.0));
        let k3 = rate(add(state, k2, h / 2.0));
        let k4 = rate(add(state, k3, h));
        state = std::array::from_fn(|i| {
            state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        });
    }
    state
}

fn implicit(time_step: f64, steps: usize) -> Plan {
    let plan = Plan::new(time_step, steps).unwrap();
    plan.with_integrator(Integrator::Sdirk3)
}

fn coordinates(state: &State) -> Vec<f64> {
    let joints = state.joints.iter();
    let positions = joints.clone().filter_map(JointState::position);
    positions
        .chain(joints.filter_map(JointState::velocity))
        .collect()
}

fn last(world: &World, plan: &Plan) -> State {
    world
        .rollout(plan)
        .run()
        .unwrap()
        .states()
        .last()
        .unwrap()
        .clone()
}

/// Largest error of the positions and velocities of a double pendulum after 0.25 s.
fn pendulum_error(steps: usize, plan: impl Fn(Plan) -> Plan) -> f64 {
    let plan = plan(Plan::new(0.25 / steps as f64, steps).unwrap());
    let exact = reference([1.0, 0.7, 0.0, 0.0], 0.25);
    let found = coordinates(&last(&double_pendulum([1.0, 0.7]), &plan));
    let differences = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn implicit_euler_steps_of_a_double_pendulum_converge_to_lagranges_equations() {
    let error = |steps| {
        pendulum_error(steps, |plan| {
            plan.with_integrator(Integrator::ImplicitEuler)
        })
    };
    let [coarse, fine] = [400, 800].map(error);
    assert!((1.9..2.1).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

#[test]
fn a_double_pendulum_has_the_accuracy_of_the_plan() {
    for tolerance in [1e-3, 1e-8] {
        let accuracy = Accuracy::new(tolerance, tolerance).unwrap();
        let error = pendulum_error(50, |plan| {
            plan.with_integrator(Integrator::Sdirk3)
                .with_accuracy(accuracy)
        });
        assert!(error < tolerance, "{tolerance:e}: {error:e}");
    }
}

#[test]
fn a_floating_tree_keeps_its_momenta() {
    let base = ball(
        "base",
        MassProperties {
            center_of_mass: Vector3::new(0.1, 0.0, 0.05),
            ..bob(2.0, 0.0, 0.03)
        },
    );
    let hinge = Joint::revolute("hinge", Vector3::x_axis())
        .with_parent("base")
        .with_origin(at(0.2, 0.1, 0.0))
        .with_velocity(3.0);
    let slide = Joint::prismatic("slide", Vector3::y_axis())
        .with_parent("arm")
        .with_origin(at(0.0, 0.2, 0.1))
        .with_velocity(-0.4);
    let socket = Joint::ball("socket")
        .with_parent("base")
        .with_origin(at(-0.2, 0.0, 0.1));
    let world = World::new(vec![
        base.with_pose(at(300.0, -200.0, 100.0))
            .with_velocity(vector![1.0, 2.0, 0.5])
            .with_angular_velocity(vector![2.0, -1.0, 3.0]),
        ball("arm", bob(0.7, 0.3, 0.01)).with_joint(hinge).unwrap(),
        ball("slider", bob(0.5, 0.1, 0.005))
            .with_joint(slide)
            .unwrap(),
        ball("pendulum", bob(0.4, 0.2, 0.004))
            .with_joint(socket)
            .unwrap(),
    ])
    .unwrap();
    let momentum = |state: &State| {
        let total = world.diagnostics(state).unwrap().momentum;
        (total.linear, total.angular)
    };
    let (linear, angular) = momentum(&world.initial_state());
    let trajectory = world.rollout(&implicit(5e-3, 400)).run().unwrap();
    for state in trajectory.states() {
        let (now_linear, now_angular) = momentum(state);
        assert!((now_linear - linear).norm() < 1e-12 * linear.norm());
        let change = (now_angular - angular).norm();
        assert!(change < 1e-12 * angular.norm(), "{change:e}");
    }
}

#[test]
fn a_fixed_joint_moves_as_one_body_of_the_summed_inertia() {
    let [first, second] = [bob(1.0, 0.1, 0.02), bob(0.5, 0.2, 0.01)];
    let offset = at(0.1, 0.2, 0.3);
    let centers = [
        first.center_of_mass,
        second.center_of_mass + offset.translation(),
    ];
    let mass = first.mass + second.mass;
    let center = (centers[0] * first.mass + centers[1] * second.mass) / mass;
    let about_center = |properties: &MassProperties, from: Vector3<f64>| {
        let arm = from - center;
        let tensor = Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
        properties.inertia + tensor * properties.mass
    };
    let inertia = about_center(&first, centers[0]) + about_center(&second, centers[1]);
    let sum = MassProperties {
        mass,
        center_of_mass: center,
        inertia,
    };
    let hinge = || {
        let hinge = Joint::revolute("hinge", Vector3::y_axis());
        hinge.with_position(0.7).with_velocity(2.0)
    };
    let weld = Joint::fixed("weld").with_parent("one").with_origin(offset);
    let welded = world(vec![
        ball("one", first).with_joint(hinge()).unwrap(),
        ball("two", second).with_joint(weld).unwrap(),
    ]);
    let whole = world(vec![ball("sum", sum).with_joint(hinge()).unwrap()]);
    let plan = Plan::new(5e-3, 100).unwrap();
    let plan = plan.with_integrator(Integrator::ImplicitEuler);
    let [welded, whole] = [&welded, &whole].map(|world| last(world, &plan));
    let [found, expected] = [&welded, &whole].map(coordinates);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    let carried = whole.bodies[0].pose.transformed_point(offset.translation());
    assert!((welded.bodies[1].pose.translation() - carried).norm() < 1e-12);
}

#[test]
fn a_wheel_counts_its_turns() {
    let wheel = ball("wheel", bob(1.0, 0.0, 0.1));
    let axle = Joint::revolute("axle", Vector3::x_axis()).with_velocity(20.0 * PI);
    let world = world(vec![wheel.with_joint(axle).unwrap()]);
    let end = last(&world, &implicit(1e-2, 100));
    assert!((end.joints[0].position().unwrap() - 20.0 * PI).abs() < 1e-10);
}

#[test]
fn joint_friction_creeps_at_the_speed_of_its_law() {
    // A slide holds 9.81 N with 20 N of friction: it creeps at s·r/√(1 − r²).
    let (friction, slip) = (20.0, 1e-3);
    let slide = Joint::prismatic("slide", Vector3::z_axis()).with_friction(friction, slip);
    let world = world(vec![
        ball("block", bob(1.0, 0.0, 0.1)).with_joint(slide).unwrap(),
    ]);
    let end = last(&world, &implicit(1e-2, 50));
    let ratio = GRAVITY / friction;
    let expected = -slip * ratio / (1.0 - ratio * ratio).sqrt();
    let found = end.joints[0].velocity().unwrap();
    assert!(
        (found - expected).abs() < 1e-6 * expected.abs(),
        "{found} {expected}"
    );
}

#[test]
fn a_stop_holds_a_joint_at_the_depth_of_its_stiffness() {
    let slide = Joint::prismatic("slide", Vector3::z_axis())
        .with_stops(Stops::new([-0.01, 0.01], 1e4, 1.0))
        .with_damping(30.0);
    let world = world(vec![
        ball("block", bob(1.0, 0.0, 0.1)).with_joint(slide).unwrap(),
    ]);
    let end = last(&world, &implicit(1e-2, 400));
    let expected = -0.01 - GRAVITY / 1e4;
    let position = end.joints[0].position().unwrap();
    assert!((position - expected).abs() < 1e-9, "{position} {expected}");
}

#[test]
fn a_rollout_from_a_later_state_continues_the_motion() {
    let world = double_pendulum([1.0, 0.7]);
    let halfway = last(&world, &implicit(5e-3, 20));
    let later = world.clone().with_initial_state(&halfway).unwrap();
    assert_eq!(coordinates(&later.initial_state()), coordinates(&halfway));
    let [whole, split] = [
        last(&world, &implicit(5e-3, 40)),
        last(&later, &implicit(5e-3, 20)),
    ];
    for (whole, split) in coordinates(&whole).iter().zip(coordinates(&split)) {
        assert!((whole - split).abs() < 1e-5, "{whole} {split}");
    }
}

#[test]
fn energy_with_armature_is_conserved() {
    let joint = Joint::revolute("joint", Vector3::y_axis())
        .with_armature(0.5)
        .with_position(1.0);
    let world = world(vec![
        ball("bob", bob(1.0, 0.5, 0.01)).with_joint(joint).unwrap(),
    ]);
    let energy = |state: &State| world.diagnostics(state).unwrap().total_energy();
    let accuracy = Accuracy::new(1e-8, 1e-8).unwrap();
    let end = last(&world, &implicit(1e-2, 50).with_accuracy(accuracy));
    let start = world.initial_state();
    assert!((end.joints[0].position().unwrap() - 1.0).abs() > 0.1);
    assert!((energy(&end) - energy(&start)).abs() < 1e-7);
}

#[test]
fn numbers_of_joints_out_of_range_are_refused() {
    let body = |joint: Joint| ball("body", bob(1.0, 0.1, 0.1)).with_joint(joint).unwrap();
    let error = |joint: Joint| World::new(vec![body(joint)]).unwrap_err().to_string();
    let hinge = || Joint::revolute("hinge", Vector3::y_axis());
    for (joint, quantity) in [
        (hinge().with_damping(-1.0), "damping"),
        (hinge().with_armature(f64::NAN), "armature"),
        (hinge().with_friction(1.0, 0.0), "slip tolerance"),
        (hinge().with_position(f64::INFINITY), "state"),
        (
            hinge().with_stops(Stops::new([1.0, 0.0], 1.0, 0.0)),
            "upper end of the range",
        ),
        (
            Joint::revolute("hinge", Unit::new_unchecked(Vector3::zeros())),
            "length of the axis",
        ),
    ] {
        assert!(error(joint).starts_with(&format!("the {quantity} of joint \"hinge\"")));
    }
    let socket = Joint::ball("socket").with_damping(1.0);
    assert_eq!(
        World::new(vec![body(socket)]).unwrap_err(),
        WorldError::BallJointForce("socket".into())
    );
}

#[test]
fn the_stability_limit_of_a_world_with_joints_is_refused() {
    let world = double_pendulum([1.0, 0.7]);
    assert_eq!(
        world
            .largest_stable_step(&world.initial_state())
            .unwrap_err(),
        WorldError::OnJoint {
            body: "upper".into(),
            quantity: "the stability limit",
        }
    );
}

/// A free body that carries a ball joint, a weld, a revolute joint and a mimicking joint, with the free body in the second place.
fn tree() -> World {
    let mut bodies = vec![ball("pendulum", bob(1.0, 0.2, 0.01))];
    bodies
        .extend(["base", "head", "cap", "arm", "hand"].map(|name| ball(name, bob(0.5, 0.1, 0.01))));
    let joints = [
        (0, Joint::prismatic("rail", Vector3::z_axis())),
        (2, Joint::ball("neck").with_parent("base")),
        (3, Joint::fixed("weld").with_parent("head")),
        (
            4,
            Joint::revolute("elbow", Vector3::x_axis()).with_parent("base"),
        ),
        (
            5,
            Joint::revolute("wrist", Vector3::y_axis())
                .with_parent("arm")
                .with_mimic("elbow", 2.0, 0.1),
        ),
    ];
    for (body, joint) in joints {
        bodies[body] = bodies[body].clone().with_joint(joint).unwrap();
    }
    world(bodies)
}

#[test]
fn tangent_coordinates_are_those_of_the_joints_in_the_order_of_their_bodies() {
    let world = tree();
    let columns = (0..6).map(|body| world.tangent_columns(body).unwrap());
    let expected = [0..2, 2..14, 14..20, 20..20, 20..22, 22..22];
    assert!(columns.eq(expected));
    assert_eq!(world.tangent_dimension(), 22);
    assert!(matches!(
        world.tangent_columns(6).unwrap_err(),
        WorldError::BodyIndex { index: 6, .. }
    ));
}

#[test]
fn a_change_of_joints_is_undone_and_moves_their_bodies() {
    let world = tree();
    let start = world.initial_state();
    let mut change: Vec<f64> = (0..22).map(|i| 0.3 * f64::sin(f64::from(i))).collect();
    change[20] = 30.0; // A revolute joint counts full turns.
    let moved = world.integrate(&start, &change).unwrap();
    let found = world.difference(&start, &moved).unwrap();
    assert!((found - DVector::from_vec(change)).amax() < 1e-14);
    let followed = world.clone().with_initial_state(&moved).unwrap();
    for (body, expected) in moved.bodies.iter().zip(followed.initial_state().bodies) {
        assert!((body.position() - expected.position()).amax() < 1e-14);
        assert!((body.twist.to_vector() - expected.twist.to_vector()).amax() < 1e-13);
    }
    let short = world.integrate(&start, &[0.0; 72]).unwrap_err();
    let expected = WorldError::ChangeSize {
        found: 72,
        expected: 22,
    };
    assert_eq!(short, expected);
}

#[test]
fn explicit_steps_refuse_joints() {
    let plan = Plan::new(1e-3, 1)
        .unwrap()
        .with_integrator(Integrator::Leapfrog);
    let failure = double_pendulum([0.1, 0.2])
        .rollout(&plan)
        .run()
        .unwrap_err();
    let expected = RolloutError::Joints {
        integrator: Integrator::Leapfrog,
        body: "upper".into(),
    };
    assert_eq!(failure.error, expected);
}

#[test]
fn a_parent_that_comes_later_is_refused() {
    let joint = Joint::revolute("joint", Vector3::x_axis()).with_parent("second");
    let bodies = vec![
        ball("first", bob(1.0, 0.1, 0.1)).with_joint(joint).unwrap(),
        ball("second", bob(1.0, 0.1, 0.1)),
    ];
    let expected = WorldError::JointParent {
        joint: "joint".into(),
        body: "first".into(),
        parent: "second".into(),
    };
    assert_eq!(World::new(bodies).unwrap_err(), expected);
}
