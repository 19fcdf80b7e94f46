//! Growth with the parameters of a derivative. The scene is eight balls on a box that touch their neighbors; the parameters are their
//! initial positions and velocities. Reverse-mode gradients have many more parameters.

use super::backwards;
use super::panel::{Curve, Panel};
use super::picture::number_tick;
use super::scenes::{TIME_STEP, final_state, heap};
use super::timing::median_ratio;
use hydroelastic::dynamics::{Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use std::hint::black_box;

const BALLS: [&str; 8] = [
    "ball 0", "ball 1", "ball 2", "ball 3", "ball 4", "ball 5", "ball 6", "ball 7",
];
const STEPS: usize = 100;
const ROUNDS: usize = 9;

/// Smallest number of parameters in the fit. Fewer parameters use narrower dual numbers.
const FITTED_FROM: f64 = 12.0;

/// Returns `count` parameters of the initial state, twelve per ball. A single parameter is a mass, which is not part of the initial state.
fn parameters(count: usize) -> Vec<Parameter> {
    if count == 1 {
        return vec![Parameter::Mass(BALLS[0].into())];
    }
    let start = |ball: &str| {
        [
            Parameter::initial_position(ball),
            Parameter::initial_orientation(ball),
            Parameter::initial_velocity(ball),
            Parameter::initial_angular_velocity(ball),
        ]
    };
    let all = BALLS.into_iter().flat_map(start);
    all.take(count / 3).collect()
}

/// Returns the cost of a Jacobian in rollouts.
fn jacobian(world: &World, count: usize) -> f64 {
    let plan = Plan::new(TIME_STEP, STEPS)
        .unwrap()
        .without_stability_check();
    let experiment = Experiment::new(world, &plan.recording_every(STEPS));
    let (by, end) = (
        parameters(count),
        FinalPosition::of_body(world, BALLS[0]).unwrap(),
    );
    let jacobian = || {
        black_box(experiment.jacobian(black_box(&by), &end).unwrap());
    };
    median_ratio(ROUNDS, jacobian, || {
        black_box(final_state(black_box(world), STEPS));
    })
}

/// Prints a line for each number of parameters.
pub fn measured(is_quick: bool) -> Panel {
    let world = heap([4, 2, 1], Material::elastic(1e5));
    println!("\n| parameters | Jacobian, in rollouts ({STEPS} steps) |");
    println!("| --- | --- |");
    let mut curve = Curve::new("Jacobian forwards", FITTED_FROM);
    let mut differences = Curve {
        is_measured: false,
        ..Curve::new("central differences", 1.0)
    };
    let counts: &[usize] = if is_quick {
        &[1, 12, 48, 96]
    } else {
        &[1, 3, 6, 12, 24, 48, 96]
    };
    for &count in counts {
        let rollouts = jacobian(&world, count);
        curve.push(count as f64, rollouts);
        differences.push(count as f64, 2.0 * count as f64);
        println!("| {count} | {rollouts:.2} |");
    }
    let fitted = curve.fitted();
    let ((first, least), (last, most)) = (fitted[0], fitted[fitted.len() - 1]);
    let further = (most - least) / (last - first) * 12.0;
    println!("\na further twelve parameters take {further:.1} rollouts");
    let [by_wrenches, by_all] = backwards::measured(is_quick);
    for &(count, _) in &by_wrenches.points {
        differences.push(count, 2.0 * count);
    }
    Panel {
        title: "Parameters",
        x_label: "parameters",
        y_label: "time (rollouts without derivatives)",
        y_tick: number_tick,
        curves: vec![curve, by_wrenches, by_all, differences],
    }
}
