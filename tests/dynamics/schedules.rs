//! Schedules of joint torques and joint targets.

use hydroelastic::dynamics::{
    Body, BodyShape, Integrator, Joint, Mass, Material, Plan, State, World, WorldError,
};
use hydroelastic::spatial::MassProperties;
use nalgebra::Vector3;

/// Rounding error of 100 implicit steps.
const ROUND_OFF: f64 = 1e-12;

/// Wheel of 0.5 kg m² on an axle, without gravity.
fn wheel(joint: Joint) -> Result<World, WorldError> {
    let mass = MassProperties {
        mass: 1.0,
        inertia: nalgebra::Matrix3::identity() * 0.5,
        ..MassProperties::zero()
    };
    let wheel = Body::dynamic(
        "wheel",
        BodyShape::None,
        Material::rigid(),
        Mass::Properties(mass),
    )?;
    World::new(vec![wheel.with_joint(joint)?])
}

fn axle() -> Joint {
    Joint::revolute("axle", Vector3::z_axis())
}

/// Position and velocity of the wheel after steps of 10 ms.
fn motion(joint: Joint, steps: usize) -> [f64; 2] {
    let plan = Plan::new(0.01, steps)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    let trajectory = wheel(joint).unwrap().rollout(&plan).run().unwrap();
    let State { joints, .. } = trajectory.last();
    [joints[0].position().unwrap(), joints[0].velocity().unwrap()]
}

#[test]
fn a_scheduled_torque_acts_during_its_interval_in_addition_to_the_torque_of_the_actuator() {
    // 2 N m, then 1 N m, for 0.1 s each, in addition to a constant 0.5 N m.
    let joint = axle().with_torque(0.5).with_torques(0.1, vec![2.0, 1.0]);
    let [_, velocity] = motion(joint, 30);
    let impulse = 0.5 * 0.3 + 2.0 * 0.1 + 1.0 * 0.1;
    assert!((velocity - impulse / 0.5).abs() < ROUND_OFF);
}

#[test]
fn a_step_across_the_end_of_an_interval_has_the_mean_torque() {
    let joint = axle().with_torques(0.025, vec![2.0, -3.0]);
    let [_, velocity] = motion(joint, 10);
    assert!((velocity - (2.0 - 3.0) * 0.025 / 0.5).abs() < ROUND_OFF);
}

#[test]
fn a_wheel_that_starts_with_its_target_follows_it_without_error() {
    let servo = || axle().with_servo(300.0, 20.0).with_velocity(0.8);
    let [position, velocity] = motion(servo().with_target(0.0, 0.8), 50);
    assert!((position - 0.4).abs() < ROUND_OFF && (velocity - 0.8).abs() < ROUND_OFF);
    let scheduled = servo().with_targets(0.25, vec![0.0, 0.2, 0.4]);
    let [position, velocity] = motion(scheduled, 50);
    assert!((position - 0.4).abs() < ROUND_OFF && (velocity - 0.8).abs() < ROUND_OFF);
}

#[test]
fn a_target_rests_after_the_last_time() {
    let joint = axle()
        .with_servo(300.0, 40.0)
        .with_targets(0.1, vec![0.0, 0.3]);
    let [position, velocity] = motion(joint, 300);
    assert!((position - 0.3).abs() < 1e-6 && velocity.abs() < 1e-6);
}

#[test]
fn schedules_out_of_range_are_refused() {
    for (interval, values, quantity) in [
        (0.0, vec![1.0], "interval of a schedule"),
        (f64::NAN, vec![1.0], "interval of a schedule"),
        (0.1, vec![], "number of values of a schedule"),
        (0.1, vec![1.0, f64::INFINITY], "value of a schedule"),
    ] {
        let schedules = [
            axle().with_torques(interval, values.clone()),
            axle().with_targets(interval, values),
        ];
        for joint in schedules {
            let error = wheel(joint).unwrap_err();
            let WorldError::Joint {
                quantity: found, ..
            } = error
            else {
                panic!("{error}");
            };
            assert_eq!(found, quantity);
        }
    }
    let ball = Joint::ball("axle").with_torques(0.1, vec![1.0]);
    assert_eq!(
        wheel(ball).unwrap_err(),
        WorldError::BallJointForce("axle".into())
    );
}
