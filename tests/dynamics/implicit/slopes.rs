//! Friction at rest, sliding, and rolling.

use super::scenes::{IMPLICIT, ball, brick, ground, on_slope, per_solve, rollout, run};
use crate::scenes::{GRAVITY, at};
use crate::support::worlds::{plan_of, rubbing};
use hydroelastic::dynamics::{Body, Integrator, RolloutError, Work, World};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Returns a brick on a slope of 20°, pressed into the ground by its weight.
fn brick_at_rest(modulus: f64, slip_tolerance: f64) -> World {
    let angle = 20_f64.to_radians();
    let skin = |modulus| rubbing(modulus, 0.5, 0.5);
    let stiffness = modulus / 0.05 / (1.0 + 0.25 / 1.7) * 0.04;
    let depth = GRAVITY * angle.cos() / stiffness;
    let turned =
        Pose::from_rotation_vector(&(Vector3::z() * 0.3), vector![-0.513, 0.021, 0.05 - depth]);
    let bodies = vec![
        brick("brick", [0.2, 0.2, 0.1], skin(modulus)).with_pose(turned),
        ground([2.0, 2.0, 0.4], skin(1.7 * modulus)),
    ];
    on_slope(bodies, angle, slip_tolerance)
}

/// Returns the ratio of creep to slip tolerance. With r = tan α/μ, friction μ·v/√(v² + v_s²) balances gravity at v = v_s·r/√(1 − r²).
fn creep_over_slip_tolerance() -> f64 {
    let ratio = 20_f64.to_radians().tan() / 0.5;
    ratio / (1.0 - ratio * ratio).sqrt()
}

/// Relative tolerance of the creep. The brick is pressed into the ground, so its sides have contact too, and after half a second it is not
/// quite at rest.
const CREEP: f64 = 1e-4;

const EVALUATIONS_AT_REST: f64 = 1.5;

#[test]
fn a_brick_on_a_slope_creeps_at_the_speed_of_the_law() {
    let expected = creep_over_slip_tolerance();
    for integrator in IMPLICIT {
        let (mut all, mut at_rest) = (Work::default(), Work::default());
        for (modulus, slip_tolerance) in [(1e7, 1e-4), (1e7, 1e-5), (1e9, 1e-4), (1e9, 1e-5)] {
            for time_step in [1e-3, 5e-3, 1e-2] {
                let world = brick_at_rest(modulus, slip_tolerance);
                let mut rollout = rollout(&world, integrator, time_step);
                let mut work = run(&mut rollout, time_step, 0.5);
                let position = rollout.state().bodies[0].position().x;
                let late = run(&mut rollout, time_step, 0.5);
                work += late;
                all += work;
                let creep =
                    (rollout.state().bodies[0].position().x - position) / 0.5 / slip_tolerance;
                println!(
                    "{integrator:?} E {modulus:.0e} v_s {slip_tolerance:.0e} h {time_step}: creep off by {:.1e}, evaluations per solve {:.2}, late {:.2}",
                    creep / expected - 1.0,
                    per_solve(&work),
                    per_solve(&late)
                );
                assert!((creep / expected - 1.0).abs() < CREEP);
                at_rest += late;
            }
        }
        println!(
            "{integrator:?}: {:.2} evaluations per solve late, {all:?}",
            per_solve(&at_rest)
        );
        assert!(per_solve(&at_rest) < EVALUATIONS_AT_REST);
    }
}

/// A brick that is put down rattles according to the contact law. Short steps resolve the rattling, and long steps damp it.
#[test]
fn a_brick_that_is_put_down_rattles_in_short_steps_and_rests_in_long_ones() {
    let (angle, slip_tolerance) = (20_f64.to_radians(), 1e-3);
    let skin = rubbing(1e7, 0.5, 0.5);
    let creep = |integrator, steps_in_a_second: usize| {
        let time_step = 1.0 / steps_in_a_second as f64;
        let bodies = vec![
            brick("brick", [0.2, 0.2, 0.1], skin).with_pose(at(0.0, 0.0, 0.05)),
            ground([2.0, 2.0, 0.4], skin),
        ];
        let world = on_slope(bodies, angle, slip_tolerance);
        let plan = plan_of(integrator, time_step, 2 * steps_in_a_second)
            .recording_every(steps_in_a_second);
        let trajectory = world.rollout(&plan).run().unwrap();
        let [_, middle, end] = trajectory.states() else {
            panic!("three states are recorded")
        };
        let distance = end.bodies[0].position().x - middle.bodies[0].position().x;
        let creep = distance / slip_tolerance / creep_over_slip_tolerance();
        println!("{integrator:?}, {time_step} s: {creep:.3} times the law");
        creep
    };
    let explicit = creep(Integrator::Leapfrog, 20_000);
    let short = creep(Integrator::Sdirk3, 2_000);
    assert!((short / explicit - 1.0).abs() < 0.1, "{short} {explicit}");
    assert!(short > 5.0, "{short}");
    for (integrator, steps_in_a_second) in [
        (Integrator::Sdirk3, 500),
        (Integrator::Sdirk3, 200),
        (Integrator::ImplicitEuler, 1_000),
    ] {
        let rests = creep(integrator, steps_in_a_second);
        assert!((rests - 1.0).abs() < 0.01, "{rests}");
    }
}

#[test]
fn implicit_steps_refuse_slip_tolerances_that_are_too_small() {
    for integrator in IMPLICIT {
        let world = brick_at_rest(1e7, 9e-7);
        let plan = plan_of(integrator, 5e-3, 1);
        let interrupted = world.rollout(&plan).run().unwrap_err();
        let refused = RolloutError::SlipTolerance {
            found: 9e-7,
            least: 1e-6,
        };
        assert_eq!(interrupted.error, refused);
        assert_eq!(interrupted.trajectory.states().len(), 1);
        let world = brick_at_rest(1e7, 1e-6);
        assert!(world.rollout(&plan).run().is_ok());
    }
}

#[test]
fn a_brick_slides_to_a_stop_where_the_textbook_says() {
    let friction = 0.2;
    let skin = |modulus| rubbing(modulus, 0.5, friction);
    for modulus in [1e7, 1e9] {
        for (integrator, tolerance) in [
            (Integrator::Sdirk3, 1e-4),
            (Integrator::ImplicitEuler, 2e-2),
        ] {
            for time_step in [1e-3, 5e-3] {
                let depth = GRAVITY / (modulus / 0.05 / (1.0 + 0.25 / 1.7) * 0.04);
                let brick = brick("brick", [0.2, 0.2, 0.1], skin(modulus));
                let brick = brick
                    .with_pose(at(-0.3, 0.02, 0.05 - depth))
                    .with_velocity(vector![0.69, 0.0, 0.0]);
                let bodies = vec![brick, ground([2.0, 2.0, 0.4], skin(1.7 * modulus))];
                let world = on_slope(bodies, 0.0, 1e-5);
                let mut rollout = rollout(&world, integrator, time_step);
                let work = run(&mut rollout, time_step, 0.6);
                let distance = rollout.state().bodies[0].position().x + 0.3;
                let textbook = 0.69 * 0.69 / (2.0 * friction * GRAVITY);
                println!(
                    "{integrator:?} E {modulus:.0e} h {time_step}: slid {distance:.6}, textbook {textbook:.6}, off by {:.1e}, evaluations per solve {:.2}",
                    distance / textbook - 1.0,
                    per_solve(&work)
                );
                assert!((distance / textbook - 1.0).abs() < tolerance);
            }
        }
    }
}

#[test]
fn a_ball_rolls_as_it_does_by_short_explicit_steps() {
    let skin = rubbing(1e6, 0.3, 0.5);
    let start = |body: Body| body.with_pose(at(-0.5, 0.013, 0.0985));
    let bodies = vec![start(ball(0.1, 2, skin)), ground([4.0, 2.0, 0.4], skin)];
    let world = on_slope(bodies, 10_f64.to_radians(), 1e-3);
    let rolled = |integrator, time_step| {
        let mut rollout = rollout(&world, integrator, time_step);
        run(&mut rollout, time_step, 0.5);
        rollout.state().bodies[0].position().x + 0.5
    };
    let expected = rolled(Integrator::Leapfrog, 5e-5);
    for (integrator, tolerance) in [
        (Integrator::Sdirk3, 5e-3),
        (Integrator::ImplicitEuler, 2e-2),
    ] {
        for time_step in [1e-3, 5e-3] {
            let actual = rolled(integrator, time_step);
            println!("{integrator:?} h {time_step}: rolled {actual:.6}, explicitly {expected:.6}");
            assert!((actual / expected - 1.0).abs() < tolerance);
        }
    }
}
