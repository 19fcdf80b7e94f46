//! Rebound heights of balls against short explicit steps.

use super::scenes::{Numbers, ball, ground, on_slope, rollout};
use crate::scenes::GRAVITY;
use crate::support::worlds::rubbing;
use hydroelastic::dynamics::{Integrator, Work, World};
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// A fall, and the type of its ground.
struct Fall {
    world: World,
    height: f64,
    label: String,
}

const RADIUS: f64 = 0.05;

/// Slip tolerance (m/s), for which explicit steps of 1e-5 s are stable.
const SLIP_TOLERANCE: f64 = 0.1;

fn random_fall(numbers: &mut Numbers) -> Fall {
    let modulus = 10_f64.powf(numbers.between(7.0, 9.0));
    let dissipation = *numbers.one_of(&[0.0, 0.1, 1.0, 10.0]);
    let order = *numbers.one_of(&[1, 2]);
    let height = numbers.between(0.1, 0.3);
    let skin = |modulus| rubbing(modulus, dissipation, 0.4);
    let turn = numbers.vector(2.0);
    let start = Pose::from_rotation_vector(&turn, vector![0.013, 0.017, RADIUS + height]);
    let ball = ball(RADIUS, order, skin(modulus));
    let ball = ball
        .with_pose(start)
        .with_angular_velocity(numbers.vector(10.0))
        .with_velocity(vector![numbers.between(-0.5, 0.5), 0.1, 0.0]);
    let bodies = vec![ball, ground([2.0, 2.0, 0.4], skin(1.3 * modulus))];
    Fall {
        world: on_slope(bodies, 0.0, SLIP_TOLERANCE),
        height,
        label: format!("E {modulus:.1e} d {dissipation} order {order} from {height:.2}"),
    }
}

/// Returns the height (m) of the apex after the first impact, computed from the velocity with which the ball leaves the ground.
fn rebound(fall: &Fall, integrator: Integrator, time_step: f64) -> (f64, Work, usize) {
    let mut rollout = rollout(&fall.world, integrator, time_step);
    let (mut work, mut steps_done, mut has_hit) = (Work::default(), 0, false);
    let mut top = 0.0_f64;
    while rollout.state().time < 0.45 {
        rollout.advance().unwrap();
        steps_done += 1;
        work += rollout
            .step_report()
            .map(|report| report.work)
            .unwrap_or_default();
        let ball = &rollout.state().bodies[0];
        let (height, speed) = (ball.position().z - RADIUS, ball.velocity().z);
        has_hit |= speed > 0.0;
        if has_hit {
            top = top.max(height + speed.max(0.0).powi(2) / (2.0 * GRAVITY));
            if speed > 0.0 && height > 0.004 || speed < 0.0 && height > 0.0 && top > 0.001 {
                break;
            }
        }
    }
    (top, work, steps_done)
}

/// Largest error, relative to the height of the fall.
const WORST: f64 = 0.03;
const MEAN: f64 = 0.003;

fn check_falls(seed: u64, count: usize) {
    let mut numbers = Numbers(seed);
    let (mut worst, mut sum, mut tries) = (0.0_f64, 0.0, 0);
    let mut all = (Work::default(), 0);
    for _ in 0..count {
        let fall = random_fall(&mut numbers);
        let (expected, _, _) = rebound(&fall, Integrator::Leapfrog, 1e-5);
        for time_step in [1e-3, 3e-3, 1e-2] {
            let (rebound_height, work, steps_done) = rebound(&fall, Integrator::Sdirk3, time_step);
            let off = (rebound_height - expected) / fall.height;
            if off.abs() > 0.01 {
                println!(
                    "{} h {time_step}: {rebound_height:.4} instead of {expected:.4}, {work:?}",
                    fall.label
                );
            }
            worst = worst.max(off.abs());
            sum += off.abs();
            tries += 1;
            all.0 += work;
            all.1 += steps_done;
        }
    }
    let mean = sum / f64::from(tries);
    println!(
        "{tries} falls: worst {worst:.4}, mean {mean:.5} of the fall; {:.2} evaluations per step, {:?}",
        all.0.evaluations as f64 / all.1 as f64,
        all.0
    );
    assert!(worst < WORST && mean < MEAN);
}

#[test]
fn balls_rebound_as_high_as_by_short_explicit_steps() {
    check_falls(0x5eed_0001, 12);
}

#[test]
#[ignore = "two minutes: 300 falls"]
fn many_balls_rebound_as_high_as_by_short_explicit_steps() {
    check_falls(0x5eed_0002, 100);
}
