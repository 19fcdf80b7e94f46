//! Growth with the number of steps of a rollout: a ball at rest on a box.

use super::panel::{Curve, Panel};
use super::picture::time_tick;
use super::scenes::{TIME_STEP, final_state, resting_ball};
use super::timing::{count, median_processor_seconds, time};
use hydroelastic::dynamics::{Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use std::hint::black_box;
use std::time::Duration;

const BUDGET: Duration = Duration::from_secs(1);

fn start() -> [Parameter; 4] {
    [
        Parameter::initial_position("ball 0"),
        Parameter::initial_orientation("ball 0"),
        Parameter::initial_velocity("ball 0"),
        Parameter::initial_angular_velocity("ball 0"),
    ]
}

fn jacobian_seconds(world: &World, steps: usize) -> f64 {
    let plan = Plan::new(TIME_STEP, steps)
        .unwrap()
        .without_stability_check();
    let experiment = Experiment::new(world, &plan.recording_every(steps));
    let (by, end) = (start(), FinalPosition::of_body(world, "ball 0").unwrap());
    median_processor_seconds(BUDGET, || {
        black_box(experiment.jacobian(black_box(&by), &end).unwrap());
    })
}

/// Prints a line for each number of steps.
pub fn measured(is_quick: bool) -> Panel {
    println!("\n| steps | rollout | a step | Jacobian by 12 |");
    println!("| --- | --- | --- | --- |");
    let world = resting_ball(Material::elastic(1e5));
    let mut rollouts = Curve::new("rollout", 0.0);
    let mut jacobians = Curve::new("Jacobian by 12", 0.0);
    let counts: &[usize] = if is_quick {
        &[100, 1_000]
    } else {
        &[100, 300, 1_000, 3_000, 10_000]
    };
    for &steps in counts {
        let seconds = median_processor_seconds(BUDGET, || {
            black_box(final_state(black_box(&world), steps));
        });
        let jacobian = jacobian_seconds(&world, steps);
        rollouts.push(steps as f64, seconds);
        jacobians.push(steps as f64, jacobian);
        println!(
            "| {} | {} | {} | {} |",
            count(steps),
            time(seconds),
            time(seconds / steps as f64),
            time(jacobian)
        );
    }
    Panel {
        title: "Steps",
        x_label: "steps of a ball on a box",
        y_label: "time of all steps",
        y_tick: time_tick,
        curves: vec![rollouts, jacobians],
    }
}
