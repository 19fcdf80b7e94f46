//! Previous and possible failures of implicit steps.

use super::scenes::{IMPLICIT, ball, brick, finger, ground, on_slope, rollout, run, undivided};
use crate::scenes::at;
use crate::support::worlds::{plan_of, rubbing, sliding_at};
use hydroelastic::dynamics::{
    BodyState, Force, ForceContext, Integrator, Material, Spring, World, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::scalar::{Scalar, lift, norm, real_part};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{DVector, vector};
use std::sync::Arc;

fn skin(modulus: f64) -> Material {
    rubbing(modulus, 0.3, 0.4)
}

/// Diverging solutions would satisfy a tolerance that is relative to them.
#[test]
fn fast_hits_by_long_steps_gain_no_speed() {
    for (index, turn) in (0..24).map(|index| (index, f64::from(index))) {
        let turned = vector![turn.sin(), (2.0 * turn).cos(), (3.0 * turn).sin()] * 2.0;
        let start = Pose::from_rotation_vector(&turned, vector![0.0, 0.0, 0.15]);
        let brick = brick(
            "brick",
            [0.1, 0.12, 0.09],
            skin(10_f64.powf(6.0 + turn / 12.0)),
        );
        let brick = brick
            .with_pose(start)
            .with_velocity(vector![0.1, 0.2, -10.0]);
        let world = on_slope(vec![brick, ground([2.0, 2.0, 0.4], skin(1e7))], 0.0, 1e-3);
        for integrator in IMPLICIT {
            let mut rollout = rollout(&world, integrator, 1e-2);
            for _ in 0..8 {
                rollout.advance().unwrap();
                let speed = rollout.state().bodies[0].velocity().norm();
                assert!(speed < 11.0, "{integrator:?} {index}: {speed} m/s");
            }
        }
    }
}

/// Relative error of differences.
const DIFFERENCE: f64 = 1e-6;

#[test]
fn derivatives_by_the_pose_of_a_fixed_body_agree_with_differences() {
    let turned = Pose::from_rotation_vector(&vector![0.3, 0.2, 0.1], vector![0.0, 0.0, 0.0985]);
    let ball = ball(0.1, 2, skin(1e6)).with_pose(turned);
    let ball = ball.with_velocity(vector![0.3, 0.0, 0.0]);
    let world = on_slope(vec![ball, ground([1.0, 1.0, 0.4], skin(1e7))], 0.0, 1e-3);
    let parameters = [Parameter::initial_position("ground")];
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 1e-3, 30);
        let experiment = Experiment::new(&world, &undivided(plan));
        let outcome = FinalState::of_body(&world, "ball").unwrap();
        let jacobian = experiment.jacobian(&parameters, &outcome).unwrap().jacobian;
        let at = |step: f64| {
            let value = experiment.value_perturbed(&parameters, &[0.0, 0.0, step], &outcome);
            DVector::from_vec(value.unwrap())
        };
        let difference = (at(1e-7) - at(-1e-7)) / 2e-7;
        let off = (difference - jacobian.column(2)).amax() / jacobian.column(2).amax();
        assert!(
            jacobian.column(2).amax() > 0.1 && off < DIFFERENCE,
            "{integrator:?}: {off}"
        );
    }
}

#[test]
fn a_spring_to_a_body_on_a_path_pulls_to_where_that_is() {
    let elastic = Material::elastic(1e6);
    let path = |time: f64| BodyState {
        pose: at(1.0 + 0.5 * (6.0 * time).sin(), 0.0, 0.0),
        twist: sliding_at(vector![3.0 * (6.0 * time).cos(), 0.0, 0.0]),
    };
    let spring = Spring {
        bodies: ["brick", "driven"].map(str::to_owned),
        points: [[0.0; 3]; 2],
        rest_length: 0.5.into(),
        stiffness: 200.0.into(),
        damping: 1.0.into(),
    };
    let bodies = vec![
        brick("brick", [0.1; 3], elastic),
        finger("driven", [0.1; 3], elastic, Arc::new(path)),
    ];
    let world = World::new(bodies).unwrap().with_forces(spring).unwrap();
    let end = |integrator, time_step| {
        let plan = plan_of(integrator, time_step, 0);
        let mut rollout = world.rollout(&plan);
        run(&mut rollout, time_step, 0.4);
        *rollout.state().bodies[0].position()
    };
    let expected = end(Integrator::Leapfrog, 1e-5);
    let off = [1e-2, 5e-3].map(|time_step| (end(Integrator::Sdirk3, time_step) - expected).norm());
    println!("a spring to a path: off by {off:?} m at 10 and 5 ms");
    assert!(off[0] < 2e-3 && off[1] < off[0] / 2.0);
}

/// Drag proportional to the square of the velocity, whose norm has no derivative at rest.
struct Air;

impl Force for Air {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let velocity = now.states[0].twist.linear;
        let drag = velocity * (norm(&velocity) * lift::<T>(-0.1));
        wrenches.apply_force_at_com(0, &drag);
    }
}

#[test]
fn forces_without_a_derivative_at_rest_can_be_stepped() {
    let world = World::new(vec![brick("brick", [0.1; 3], Material::elastic(1e6))])
        .and_then(|world| world.with_gravity(vector![0.0, 0.0, -9.81]))
        .and_then(|world| world.with_forces(Air))
        .unwrap();
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 5e-3, 200);
        let end = world.rollout(&plan).run().unwrap();
        // v = √(mg/c)·tanh(t √(gc/m)).
        let speed = -real_part(end.last().bodies[0].velocity().z);
        let expected = (9.81_f64 / 0.1).sqrt() * (9.81_f64 * 0.1).sqrt().tanh();
        assert!(
            (speed / expected - 1.0).abs() < 5e-3,
            "{integrator:?}: {speed}"
        );
    }
}

#[test]
fn a_grip_at_rest_without_gravity_takes_three_stages_a_step() {
    let held = brick("held", [0.1; 3], skin(1e7)).with_pose(at(0.0, 0.003, 0.002));
    let jaw = |name, x| {
        let still = move |_: f64| BodyState {
            pose: at(x, 0.0, 0.0),
            twist: Twist::zero(),
        };
        finger(name, [0.1, 0.3, 0.3], skin(1e7), Arc::new(still))
    };
    let bodies = vec![held, jaw("left", -0.0998), jaw("right", 0.0998)];
    let world = World::new(bodies).unwrap();
    let mut rollout = rollout(&world, Integrator::Sdirk3, 5e-3);
    run(&mut rollout, 5e-3, 0.5);
    let work = run(&mut rollout, 5e-3, 0.1);
    assert_eq!((work.solves, work.rejections), (60, 0));
}
