//! Derivatives of jointed bodies in contact: forward mode, reverse mode and differences.

use crate::reverse::{Mixed, SAME, compare};
use crate::support::worlds::{at, falling, fixed, icosphere, rigid_floor, rubbing, turned};
use hydroelastic::dynamics::{
    Body, Integrator, Joint, JointState, JointStateGradient, Mass, Plan, State, StateGradient,
    Stops, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, JointQuantity, Outcome, Parameter};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::MassProperties;
use nalgebra::{DVector, Matrix3, Vector3, vector};

/// Relative error of differences of rollouts.
const DIFFERENCES: f64 = 1e-6;

/// Positions and velocities of all joints.
pub struct Joints;

impl Outcome for Joints {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let joints = trajectory.last().joints.iter();
        joints
            .filter_map(|joint| Some(joint.position()? + joint.velocity()? * 0.1))
            .collect()
    }
}

/// Sum of [`Joints`].
pub struct JointSum;

impl Outcome for JointSum {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let numbers = Joints.of(trajectory);
        vec![
            numbers
                .into_iter()
                .fold(hydroelastic::scalar::lift(0.0), |sum, number| sum + number),
        ]
    }
}

fn link(name: &str, mass: f64, length: f64) -> Body {
    let properties = MassProperties {
        mass,
        center_of_mass: vector![0.0, 0.0, -length / 2.0],
        inertia: Matrix3::from_diagonal(&vector![1.0, 1.1, 0.4]) * (mass * length * length / 12.0),
    };
    let skin = rubbing(1e6, 0.5, 0.5);
    Body::dynamic(name, icosphere(0.05, 1), skin, Mass::Properties(properties)).unwrap()
}

/// An arm of three joints whose ball at the end rubs on the floor, and a free ball beside it.
pub fn arm() -> World {
    let shoulder = Joint::revolute("shoulder", Vector3::z_axis())
        .with_origin(at(0.0, 0.0, 0.685))
        .with_velocity(0.8)
        .with_torques(0.0125, vec![0.3, -0.2, 0.1])
        .with_damping(0.2)
        .with_armature(0.01);
    let elbow = Joint::revolute("elbow", Vector3::y_axis())
        .with_parent("upper")
        .with_position(0.4)
        .with_servo(40.0, 2.0)
        .with_target(0.5, 0.0)
        .with_friction(0.1, 0.05);
    let wrist = Joint::prismatic("wrist", Vector3::z_axis())
        .with_parent("lower")
        .with_origin(at(0.0, 0.0, -0.7))
        .with_servo(2e3, 20.0)
        .with_targets(0.03, vec![0.0, 0.002, -0.001])
        .with_torque(-6.0);
    falling(vec![
        rigid_floor(0.6),
        link("upper", 1.0, 0.2).with_joint(shoulder).unwrap(),
        link("lower", 0.8, 0.7).with_joint(elbow).unwrap(),
        link("hand", 0.3, 0.05).with_joint(wrist).unwrap(),
    ])
}

fn parameters() -> Vec<Parameter> {
    let mut all = vec![
        Parameter::Gravity,
        Parameter::modulus("hand"),
        Parameter::mass("lower"),
        Parameter::radius_of_gyration("lower"),
        Parameter::friction("hand"),
    ];
    for (joint, quantities) in [
        (
            "shoulder",
            vec![
                JointQuantity::InitialPosition,
                JointQuantity::InitialVelocity,
                JointQuantity::Damping,
                JointQuantity::Armature,
                JointQuantity::ScheduledTorque(0),
                JointQuantity::ScheduledTorque(1),
            ],
        ),
        (
            "elbow",
            vec![
                JointQuantity::InitialPosition,
                JointQuantity::InitialVelocity,
                JointQuantity::ServoStiffness,
                JointQuantity::ServoDamping,
                JointQuantity::TargetPosition,
                JointQuantity::TargetVelocity,
                JointQuantity::Friction,
            ],
        ),
        (
            "wrist",
            vec![
                JointQuantity::Torque,
                JointQuantity::InitialVelocity,
                JointQuantity::ScheduledTarget(0),
                JointQuantity::ScheduledTarget(1),
            ],
        ),
    ] {
        all.extend(
            quantities
                .into_iter()
                .map(|quantity| Parameter::joint(joint, quantity)),
        );
    }
    all
}

#[test]
fn the_hand_touches_the_floor() {
    let plan = Plan::new(5e-3, 20)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    let world = arm();
    let trajectory = world.rollout(&plan).run().unwrap();
    let touches = |state: &State| !world.contacts(state).unwrap().is_empty();
    assert!(trajectory.states().iter().any(touches));
}

#[test]
fn both_modes_agree_for_an_arm_that_rubs_on_the_floor() {
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        let plan = Plan::new(5e-3, 20).unwrap().with_integrator(integrator);
        compare(&arm(), &plan, &parameters(), &Mixed { every: 7 });
        compare(&arm(), &plan, &parameters(), &JointSum);
    }
}

/// A pendulum with a ball joint and a welded tip on a fixed post. The tip rubs on the floor.
pub fn pendulum() -> World {
    let socket = Joint::ball("socket")
        .with_parent("post")
        .with_origin(at(0.0, 0.0, 0.1));
    let hinge = Joint::revolute("hinge", Vector3::y_axis())
        .with_parent("rod")
        .with_origin(at(0.0, 0.0, -0.3))
        .with_position(0.1)
        .with_stops(Stops::new([-0.05, 0.05], 20.0, 0.1))
        .with_velocity(1.0);
    let weld = Joint::fixed("weld")
        .with_parent("shank")
        .with_origin(at(0.02, 0.0, -0.335));
    let post = fixed("post", icosphere(0.05, 0), rubbing(1e6, 0.5, 0.5));
    falling(vec![
        rigid_floor(0.6),
        post.with_pose(turned([0.1, 0.05, 0.2], [0.1, 0.2, 0.57])),
        link("rod", 0.5, 0.3).with_joint(socket).unwrap(),
        link("shank", 0.4, 0.3).with_joint(hinge).unwrap(),
        link("tip", 0.1, 0.02).with_joint(weld).unwrap(),
    ])
}

#[test]
fn both_modes_agree_for_a_pendulum_on_a_fixed_post() {
    let parameters = [
        Parameter::initial_position("post"),
        Parameter::initial_orientation("post"),
        Parameter::mass("tip"),
        Parameter::modulus("tip"),
        Parameter::joint("hinge", JointQuantity::InitialPosition),
        Parameter::joint("hinge", JointQuantity::InitialVelocity),
        Parameter::joint("socket", JointQuantity::InitialOrientation),
        Parameter::joint("socket", JointQuantity::InitialAngularVelocity),
    ];
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        let plan = Plan::new(5e-3, 20).unwrap().with_integrator(integrator);
        compare(&pendulum(), &plan, &parameters, &Mixed { every: 7 });
    }
}

#[test]
fn derivatives_of_an_arm_are_those_of_differences() {
    let plan = Plan::new(2e-3, 10)
        .unwrap()
        .with_integrator(Integrator::ImplicitEuler);
    let check = Experiment::new(arm(), &plan)
        .difference_check(&parameters(), &Joints)
        .unwrap();
    assert!(check.best() < DIFFERENCES);
}

/// Gripper with coupled fingers on a fixed palm. It holds a free ball.
pub fn gripper() -> World {
    let finger = |name: &str, joint: Joint| {
        let properties = MassProperties::solid_ball(0.1, 0.03);
        let pad = icosphere(0.03, 1);
        let body = Body::dynamic(
            name,
            pad,
            rubbing(1e5, 0.5, 0.8),
            Mass::Properties(properties),
        );
        body.unwrap().with_joint(joint).unwrap()
    };
    let palm = fixed("palm", icosphere(0.02, 0), rubbing(1e5, 0.5, 0.5));
    let left = Joint::prismatic("left", Vector3::x_axis())
        .with_parent("palm")
        .with_origin(at(-0.1, 0.0, -0.1))
        .with_position(0.028)
        .with_damping(1.0)
        .with_torque(8.0);
    let right = Joint::prismatic("right", Vector3::x_axis())
        .with_parent("palm")
        .with_origin(at(0.1, 0.0, -0.1))
        .with_mimic("left", -1.0, 0.0)
        .with_torques(0.01, vec![0.5, -0.3])
        .with_armature(0.02)
        .with_damping(2.0);
    let properties = MassProperties::solid_ball(0.2, 0.04);
    let ball = Body::dynamic(
        "ball",
        icosphere(0.04, 1),
        rubbing(1e5, 0.5, 0.8),
        Mass::Properties(properties),
    );
    falling(vec![
        palm.with_pose(at(0.0, 0.0, 0.5)),
        finger("left finger", left),
        finger("right finger", right),
        ball.unwrap()
            .with_pose(turned([0.3, 0.2, 0.1], [0.0, 0.002, 0.4])),
    ])
}

#[test]
fn both_modes_and_differences_agree_for_coupled_fingers() {
    let parameters = [
        Parameter::Gravity,
        Parameter::friction("ball"),
        Parameter::mass("right finger"),
        Parameter::initial_position("palm"),
        Parameter::joint("left", JointQuantity::InitialPosition),
        Parameter::joint("left", JointQuantity::InitialVelocity),
        Parameter::joint("left", JointQuantity::Torque),
        Parameter::joint("left", JointQuantity::Damping),
        Parameter::joint("right", JointQuantity::Torque),
        Parameter::joint("right", JointQuantity::Damping),
        Parameter::joint("right", JointQuantity::Armature),
        Parameter::joint("right", JointQuantity::ScheduledTorque(1)),
    ];
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        let plan = Plan::new(5e-3, 20).unwrap().with_integrator(integrator);
        compare(&gripper(), &plan, &parameters, &Mixed { every: 7 });
    }
    let plan = Plan::new(2e-3, 10).unwrap();
    let plan = plan.with_integrator(Integrator::ImplicitEuler);
    let check = Experiment::new(gripper(), &plan).difference_check(&parameters, &Joints);
    assert!(check.unwrap().best() < DIFFERENCES);
}

#[test]
fn the_initial_state_of_a_follower_is_refused_with_the_name_of_its_leader() {
    let by = [Parameter::joint("right", JointQuantity::InitialVelocity)];
    let error = gripper().values(&by).unwrap_err();
    let expected = "the initial velocity of joint \"right\" is not a parameter, because the joint mimics \"left\": \
        use the initial velocity of joint \"left\"";
    assert_eq!(error.to_string(), expected);
}

/// Joint states in the last state: positions and velocities, and rotation matrices and angular velocities of ball joints.
struct JointNumbers;

impl Outcome for JointNumbers {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let joints = trajectory.last().joints.iter();
        joints
            .flat_map(|joint| match joint {
                JointState::Scalar { position, velocity } => vec![*position, *velocity],
                JointState::Ball {
                    rotation,
                    angular_velocity,
                } => rotation.iter().chain(angular_velocity).copied().collect(),
                _ => Vec::new(),
            })
            .collect()
    }
}

#[test]
fn derivatives_with_respect_to_a_ball_joint_agree_with_differences() {
    let plan = Plan::new(2e-3, 10)
        .unwrap()
        .with_integrator(Integrator::ImplicitEuler);
    let parameters = [
        Parameter::joint("socket", JointQuantity::InitialOrientation),
        Parameter::joint("socket", JointQuantity::InitialAngularVelocity),
    ];
    let check = Experiment::new(pendulum(), &plan)
        .difference_check(&parameters, &JointNumbers)
        .unwrap();
    assert!(check.best() < DIFFERENCES, "{check}");
}

#[test]
fn values_of_a_ball_joint_are_set_and_read() {
    let parameters = [
        Parameter::joint("socket", JointQuantity::InitialOrientation),
        Parameter::joint("socket", JointQuantity::InitialAngularVelocity),
    ];
    let values = [0.1, -0.2, 0.3, 1.0, 2.0, 3.0];
    let world = pendulum().with_values(&parameters, &values).unwrap();
    let found = world.values(&parameters).unwrap();
    assert!((found - DVector::from_row_slice(&values)).amax() < 1e-15);
    let error = world.values(&[Parameter::joint("socket", JointQuantity::Torque)]);
    let expected = "no revolute or prismatic joint is named \"socket\": the names are [\"hinge\"]";
    assert_eq!(error.unwrap_err().to_string(), expected);
}

#[test]
fn a_pull_back_from_joint_states_is_a_product_with_the_jacobian() {
    let parameters = [
        Parameter::Gravity,
        Parameter::mass("tip"),
        Parameter::joint("hinge", JointQuantity::InitialVelocity),
        Parameter::joint("hinge", JointQuantity::Damping),
        Parameter::joint("socket", JointQuantity::InitialOrientation),
        Parameter::joint("socket", JointQuantity::InitialAngularVelocity),
    ];
    for integrator in [Integrator::Sdirk3, Integrator::ImplicitEuler] {
        let plan = Plan::new(5e-3, 20).unwrap().with_integrator(integrator);
        let experiment = Experiment::new(pendulum(), &plan);
        let vjp = experiment.vjp(&parameters).unwrap();
        let states = vjp.trajectory().states();
        let mut by_states: Vec<_> = states.iter().map(StateGradient::zero).collect();
        let by_numbers = DVector::from_fn(14, |i, _| ((i + 1) as f64 * 0.7).sin());
        let [JointState::Ball { rotation, .. }, _] = vjp.trajectory().last().joints[..] else {
            panic!("the first joint is a ball joint");
        };
        by_states[20].joints = vec![
            JointStateGradient::from_entries(
                &rotation,
                &Matrix3::from_column_slice(&by_numbers.as_slice()[..9]),
                by_numbers.fixed_rows::<3>(9).into_owned(),
            ),
            JointStateGradient::scalar(by_numbers[12], by_numbers[13]),
        ];
        let jacobian = experiment.jacobian(&parameters, &JointNumbers).unwrap();
        let expected = jacobian.jacobian.tr_mul(&by_numbers);
        let actual = vjp.pull_back(&by_states).unwrap();
        let error = (&actual - &expected).amax();
        assert!(error <= SAME * expected.amax(), "{error:e} {expected}");
    }
}
