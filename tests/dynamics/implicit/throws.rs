//! Random throws: the solver converges in every step.

use super::scenes::{Numbers, ball, brick, ground, on_slope, rollout};
use crate::support::worlds::rubbing;
use hydroelastic::dynamics::{Integrator, Work};
use hydroelastic::spatial::Pose;
use nalgebra::vector;

fn check_throws(seed: u64, least: usize) {
    let mut numbers = Numbers(seed);
    let (mut work, mut step_count) = (Work::default(), 0);
    while step_count < least {
        let modulus = 10_f64.powf(numbers.between(5.0, 9.0));
        let slip_tolerance = 10_f64.powf(numbers.between(-5.0, -2.0));
        let time_step = 10_f64.powf(numbers.between(-3.0, -2.0));
        let dissipation = [0.0, 0.3, 3.0][step_count % 3];
        let friction = numbers.between(0.1, 1.0);
        let skin = |modulus| rubbing(modulus, dissipation, friction);
        let start = |x: f64, numbers: &mut Numbers| {
            Pose::from_rotation_vector(&numbers.vector(3.0), vector![x, 0.02, 0.3])
        };
        let thrown_ball = ball(0.1, 1, skin(modulus))
            .with_pose(start(-0.2, &mut numbers))
            .with_velocity(numbers.vector(2.0))
            .with_angular_velocity(numbers.vector(10.0));
        let thrown_brick = brick("brick", [0.2, 0.14, 0.1], skin(2.0 * modulus))
            .with_pose(start(0.1, &mut numbers))
            .with_velocity(numbers.vector(2.0))
            .with_angular_velocity(numbers.vector(10.0));
        let world = on_slope(
            vec![
                thrown_ball,
                thrown_brick,
                ground([6.0, 6.0, 0.4], skin(1.3 * modulus)),
            ],
            0.0,
            slip_tolerance,
        );
        let mut rollout = rollout(&world, Integrator::Sdirk3, time_step);
        while rollout.state().time < 1.0 {
            if let Err(error) = rollout.advance() {
                panic!(
                    "E {modulus:.1e} v_s {slip_tolerance:.1e} h {time_step:.1e} d {dissipation}: {error}"
                );
            }
            step_count += 1;
            work += rollout.step_report().unwrap().work;
        }
    }
    println!(
        "{step_count} steps, {:.2} evaluations each, {work:?}",
        work.evaluations as f64 / step_count as f64
    );
}

#[test]
fn all_steps_of_random_throws_are_solved() {
    check_throws(99, 3_000);
}

#[test]
#[ignore = "minutes: 100,000 steps"]
fn all_of_100_000_steps_of_random_throws_are_solved() {
    check_throws(77, 100_000);
}
