//! Derivatives of robots in contact, in steps of 5 ms: a hand that carries a ball, and motions with impacts.

use crate::converged::{TIME_STEP, tight};
use crate::support::robots::{arm, closing_joints, hand, pads, quadruped};
use crate::support::worlds::plan_of;
use hydroelastic::dynamics::{Integrator, JointState, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, JointQuantity, Mode, Outcome, Parameter};
use hydroelastic::scalar::Scalar;
use nalgebra::DVector;

/// Relative error of a central difference of the same steps.
const DIFFERENCES: f64 = 1e-5;

/// Error of derivatives at the default accuracy, relative to the largest entry of a column.
const OFF: f64 = 0.01;

/// Relative difference of both modes, by round-off.
const MODES: f64 = 1e-9;

fn plan(steps: usize) -> Plan {
    plan_of(Integrator::Sdirk3, TIME_STEP, steps).recording_ends()
}

/// Final height (m) of the ball of the hand, as a function of the squeeze.
fn check_hand(steps: usize) {
    struct Height;
    impl Outcome for Height {
        fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
            vec![trajectory.last().bodies[0].position().z]
        }
    }
    let targets = closing_joints()
        .into_iter()
        .map(|joint| Parameter::joint(joint, JointQuantity::ScheduledTarget(1)));
    let targets: Vec<_> = targets.collect();
    let experiment = Experiment::new(hand(0.1), &plan(steps));
    let slopes = [Mode::Forward, Mode::Reverse].map(|mode| {
        let (_, gradient) = experiment
            .gradient_with_mode(mode, &targets, &Height)
            .unwrap();
        gradient.sum()
    });
    let end = |squeeze: f64| {
        let changes = vec![squeeze; targets.len()];
        experiment
            .value_perturbed(&targets, &changes, &Height)
            .unwrap()[0]
    };
    let difference = (end(1e-7) - end(-1e-7)) / 2e-7;
    println!("{steps} steps: {slopes:?} m/rad, differences {difference} m/rad");
    assert!((slopes[1] / slopes[0] - 1.0).abs() < MODES, "{slopes:?}");
    assert!(
        (slopes[0] / difference - 1.0).abs() < DIFFERENCES,
        "{slopes:?}, {difference}"
    );
}

#[test]
fn the_height_of_a_lifted_ball_has_the_slope_of_differences_over_the_squeeze() {
    check_hand(60);
}

#[test]
#[ignore = "minutes"]
fn the_height_of_a_carried_ball_has_the_slope_of_differences_over_the_squeeze() {
    check_hand(130);
}

/// Joint positions and positions of the first body.
struct Positions;

impl Outcome for Positions {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let end = trajectory.last();
        let joints = end.joints.iter().filter_map(JointState::position);
        joints
            .chain(end.bodies[0].position().iter().copied())
            .collect()
    }
}

/// Compares derivatives at the default accuracy with differences of tight motions over a change that is wider than their noise.
fn check(label: &str, world: &World, steps: usize, parameters: &[Parameter], change: f64) {
    let experiment = Experiment::new(world, &plan(steps));
    let found = experiment
        .jacobian(parameters, &Positions)
        .unwrap()
        .jacobian;
    let motion = Experiment::new(world, &plan(steps).with_accuracy(tight()));
    for column in 0..found.ncols() {
        let end = |times: f64| {
            let mut changes = vec![0.0; found.ncols()];
            changes[column] = times * change;
            let end = motion.value_perturbed(parameters, &changes, &Positions);
            DVector::from_vec(end.unwrap())
        };
        // This difference is of fourth order.
        let expected = ((end(1.0) - end(-1.0)) * 8.0 - (end(2.0) - end(-2.0))) / (12.0 * change);
        let off = (found.column(column) - &expected).amax() / expected.amax();
        println!(
            "{label}, {column}: off by {off:.1e} of {:.3}",
            expected.amax()
        );
        assert!(off < OFF, "{label}, {column}: off by {off}");
    }
}

#[test]
fn an_arm_that_drops_its_tip_on_a_table_has_the_derivatives_of_its_motion() {
    let parameters = [
        Parameter::joint("joint 2", JointQuantity::InitialVelocity),
        Parameter::joint("joint 4", JointQuantity::InitialPosition),
    ];
    check("arm", &arm(1e9), 50, &parameters, 1e-3);
}

#[test]
#[ignore = "40 s of processor time"]
fn a_quadruped_that_lands_has_the_derivatives_of_its_motion() {
    let knee = Parameter::joint("shank 0", JointQuantity::TargetPosition);
    check("quadruped", &quadruped(1e6), 30, &[knee], 1e-3);
}

#[test]
#[ignore = "minutes"]
fn a_stiff_quadruped_that_lands_has_the_derivatives_of_its_motion() {
    let velocity = Parameter::initial_velocity("trunk");
    check("stiff quadruped", &quadruped(1e7), 30, &[velocity], 1e-3);
}

#[test]
fn pads_that_close_on_a_box_have_the_derivatives_of_their_motion() {
    let parameters = [
        Parameter::joint("left", JointQuantity::InitialPosition),
        Parameter::friction("box"),
    ];
    check("pads", &pads(20.0, 1.0), 40, &parameters, 1e-5);
}
