//! Derivatives through implicit steps against differences of these steps.

use super::scenes::{IMPLICIT, ball, brick, grasp, ground, on_slope, stack, undivided};
use crate::support::worlds::{plan_of, rubbing, turned};
use hydroelastic::dynamics::{Integrator, Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalState, OutcomeJacobian, Parameter};
use nalgebra::{DVector, vector};
use std::fmt::Write;

/// Largest relative error of columns that count.
const OFF: f64 = 1e-6;

/// Compares each column with fourth-order differences of sixteen step sizes, relative to the column, and uses the best. Columns below a
/// thousandth of the largest (for typical changes) do not count. Differences have noise of about 4e-9 of the largest column, so for the
/// smallest columns that count, only one or two step sizes are accurate.
fn check((label, world, plan): (&str, &World, &Plan), body: &str, parameters: &[Parameter]) {
    let experiment = Experiment::new(world, &undivided(*plan));
    let outcome = FinalState::of_body(world, body).unwrap();
    let OutcomeJacobian { jacobian, value } = experiment.jacobian(parameters, &outcome).unwrap();
    let plain = DVector::from_vec(experiment.value(&outcome).unwrap());
    assert!((&plain - value).amax() < 1e-9, "values differ");
    let count = jacobian.ncols();
    let mut line = String::new();
    let names: Vec<_> = parameters
        .iter()
        .flat_map(|p| std::iter::repeat_n(p, p.dimension()))
        .collect();
    let scale = |column: usize| match names[column] {
        Parameter::Modulus(_) => 1e7,
        _ => 1.0,
    };
    let size = |column: usize| jacobian.column(column).rows(0, 3).norm() * scale(column);
    let largest = (0..count).map(size).fold(0.0, f64::max);
    for column in 0..count {
        let column_slope = jacobian.column(column).rows(0, 3).into_owned();
        let best = (4..20).map(|exponent| {
            let step = 10_f64.powf(-0.5 * f64::from(exponent)) * scale(column);
            let at = |sign: f64| {
                let mut changes = vec![0.0; count];
                changes[column] = sign * step;
                let outcome_value = experiment.value_perturbed(parameters, &changes, &outcome);
                outcome_value.map(|numbers| DVector::from_vec(numbers).rows(0, 3).into_owned())
            };
            let [Ok(far), Ok(more), Ok(less), Ok(back)] = [2.0, 1.0, -1.0, -2.0].map(at) else {
                return f64::INFINITY;
            };
            let difference = ((more - less) * 8.0 - (far - back)) / (12.0 * step);
            (difference - &column_slope).norm() / column_slope.norm()
        });
        let best = best.fold(f64::INFINITY, f64::min);
        let share = size(column) / largest;
        write!(line, " {:?}: {best:.0e} ({share:.0e})", names[column]).unwrap();
        if size(column) >= 1e-3 * largest {
            assert!(
                best < OFF,
                "{label}: column {column} ({:?}) {best:e} {line}",
                names[column]
            );
        }
    }
    println!("{label}:{line}");
}

fn thrown(modulus: f64, friction: f64, dissipation: f64) -> World {
    let skin = |modulus| {
        Material::elastic(modulus)
            .with_friction(friction)
            .with_dissipation(dissipation)
    };
    let ball = ball(0.1, 2, skin(modulus));
    let start = turned([0.3, 0.2, 0.1], [-0.31, 0.02, 0.15]);
    let ball = ball
        .with_pose(start)
        .with_velocity(vector![0.8, 0.13, -0.9])
        .with_angular_velocity(vector![1.0, 3.0, 0.5]);
    on_slope(vec![ball, ground([2.0, 2.0, 0.4], skin(1e7))], 0.0, 1e-3)
}

fn of_ball(name: &str) -> Vec<Parameter> {
    vec![
        Parameter::initial_velocity(name),
        Parameter::initial_angular_velocity(name),
        Parameter::modulus(name),
        Parameter::friction(name),
        Parameter::dissipation(name),
        Parameter::mass(name),
        Parameter::radius_of_gyration(name),
    ]
}

#[test]
fn of_a_throw() {
    for integrator in IMPLICIT {
        for time_step in [1e-3, 5e-3] {
            let steps = if time_step > 2e-3 { 50 } else { 250 };
            let plan = plan_of(integrator, time_step, steps).recording_every(steps);
            let world = thrown(1e7, 0.4, 0.3);
            check(
                (&format!("throw {integrator:?} {time_step}"), &world, &plan),
                "ball",
                &of_ball("ball"),
            );
            let world = thrown(1e7, 0.0, 0.0);
            let elastic = [
                Parameter::initial_velocity("ball"),
                Parameter::initial_angular_velocity("ball"),
                Parameter::modulus("ball"),
            ];
            check(
                (
                    &format!("elastic {integrator:?} {time_step}"),
                    &world,
                    &plan,
                ),
                "ball",
                &elastic,
            );
        }
    }
}

#[test]
fn of_a_brick_that_slides_to_a_stop_and_sticks() {
    let skin = |modulus| rubbing(modulus, 0.5, 0.2);
    let start = turned([0.0, 0.0, 0.3], [-0.3, 0.02, 0.04999]);
    let brick = brick("brick", [0.2, 0.2, 0.1], skin(1e7))
        .with_pose(start)
        .with_velocity(vector![0.5, 0.1, 0.0])
        .with_angular_velocity(vector![0.0, 0.0, 1.0]);
    let world = on_slope(vec![brick, ground([2.0, 2.0, 0.4], skin(1.7e7))], 0.0, 1e-4);
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 5e-3, 40).recording_every(40);
        check(
            (&format!("stop {integrator:?}"), &world, &plan),
            "brick",
            &of_ball("brick"),
        );
    }
}

#[test]
fn of_a_grasp() {
    let world = grasp(1e7, 1e-4);
    let plan = plan_of(Integrator::Sdirk3, 5e-3, 60).recording_every(60);
    check(("grasp", &world, &plan), "ball", &of_ball("ball"));
}

#[test]
fn of_a_stack() {
    let world = stack(2, 1e7, 1e-3);
    let plan = plan_of(Integrator::Sdirk3, 5e-3, 20).recording_every(20);
    check(("stack", &world, &plan), "1", &of_ball("1"));
}
