//! Does the height after an impact depend smoothly on the speed before the impact, and does its derivative converge to that of the motion?
//!
//! `cargo run --release -p hydroelastic-examples --example sawtooth [-- --record FILE.glb --plot FILE.svg]`

mod show;

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Accuracy, Body, Integrator, Mass, Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use show::{Curve, Panel};
use std::error::Error;

type Answer<T> = Result<T, Box<dyn Error>>;

/// Time step (s) and number of steps. An impact takes about a twentieth of a step.
const TIME_STEP: f64 = 5e-3;
const STEPS: usize = 60;
/// Largest initial upward speed (m/s) of the ball. From zero to this speed, the time of the impact shifts by four steps.
const FASTEST: f64 = 0.2;
/// Number of initial speeds in the first panel and in the second.
const STARTS: usize = 160;
const COMPARED: usize = 8;
/// Logarithms to base 10 of the tolerances of slopes.
const POWERS: [f64; 9] = [1.0, 0.5, 0.0, -0.5, -1.0, -1.5, -2.0, -2.5, -3.0];
/// Bounds of the errors of slopes: at the default accuracy, and in undivided steps.
const SMALL: f64 = 0.02;
const LARGE: f64 = 1.0;

/// Returns the ball of the guide's chapter on time steps.
fn throw(speed: f64) -> Answer<World> {
    let skin = Material::elastic(1e9)
        .with_dissipation(0.3)
        .with_friction(0.4);
    let ball = Shape::new(shapes::icosphere(0.05, 2)?);
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.4])?);
    let start = Pose::from_translation(vector![0.013, 0.017, 0.25]);
    let world = World::new(vec![
        Body::dynamic("ball", ball, skin, Mass::Total(1.0))?
            .with_pose(start)
            .with_velocity(vector![0.3, 0.1, speed]),
        Body::fixed("floor", floor, skin)?
            .with_pose(Pose::from_translation(vector![0.0, 0.0, -0.2])),
    ])?;
    Ok(world.with_gravity(vector![0.0, 0.0, -9.81])?)
}

fn plan(accuracy: Accuracy) -> Answer<Plan> {
    let plan = Plan::new(TIME_STEP, STEPS)?.with_integrator(Integrator::Sdirk3);
    Ok(plan.with_accuracy(accuracy).recording_every(STEPS))
}

/// Returns initial speeds (m/s) and final heights (m).
fn heights(accuracy: Accuracy) -> Answer<Vec<(f64, f64)>> {
    let plan = plan(accuracy)?;
    let starts = (0..=STARTS).map(|start| FASTEST * start as f64 / STARTS as f64);
    let ends = starts.map(|speed| {
        let end = throw(speed)?.rollout(&plan).run()?;
        Ok((speed, end.last().bodies[0].position().z))
    });
    ends.collect()
}

/// Returns the derivatives (s) of the final height with respect to the initial speed.
fn slopes(accuracy: Accuracy) -> Answer<Vec<f64>> {
    let plan = plan(accuracy)?;
    let starts = (0..COMPARED).map(|start| FASTEST * start as f64 / COMPARED as f64);
    let slopes = starts.map(|speed| {
        let world = throw(speed)?;
        let end = FinalPosition::of_body(&world, "ball")?;
        let by = [Parameter::initial_velocity("ball")];
        let jacobian = Experiment::new(&world, &plan).jacobian(&by, &end)?.jacobian;
        Ok(jacobian[(2, 2)])
    });
    slopes.collect()
}

/// Returns the largest error of slopes at an accuracy, relative to the slopes of the motion.
fn largest_error(accuracy: Accuracy, motion: &[f64]) -> Answer<f64> {
    let errors = slopes(accuracy)?.into_iter().zip(motion);
    let errors = errors.map(|(slope, motion)| (slope / motion - 1.0).abs());
    Ok(errors.fold(0.0, f64::max))
}

fn main() -> Answer<()> {
    let (wanted, undivided) = (show::wanted()?, Accuracy::new(1e9, 1e9)?);
    let motion = slopes(Accuracy::new(1e-6, 3e-5)?.with_resting_speed(0.03)?)?;
    let without = largest_error(undivided, &motion)?;
    let with = largest_error(Accuracy::default(), &motion)?;
    println!("slopes of the motion: {motion:.3?} s");
    println!("largest error: {without:.0e} in undivided steps, {with:.0e} at the default accuracy");

    wanted.record(|| {
        let (world, plan) = (throw(0.0)?, plan(Accuracy::default())?.recording_every(1));
        let trajectory = world.rollout(&plan).run()?;
        Ok(Recording::new(&world, &trajectory).slowed(4.0))
    })?;
    if wanted.has_plot() {
        let panels = panels(undivided, &motion)?;
        wanted.plot(|| panels)?;
    }
    assert!(with < SMALL && without > LARGE);
    Ok(())
}

/// Plots the final heights over the initial speeds, and the error of slopes over the tolerance.
fn panels(undivided: Accuracy, motion: &[f64]) -> Answer<Vec<Panel>> {
    let ends = Panel {
        x_label: "speed at the start (m/s)",
        y_label: "height at the end (m)",
        is_log: false,
        curves: vec![
            Curve::new("undivided steps", heights(undivided)?),
            Curve::new("default accuracy", heights(Accuracy::default())?),
        ],
    };
    let mut by_tolerance = Vec::new();
    for power in POWERS {
        let tolerance = 10_f64.powf(power);
        let accuracy = Accuracy::new(tolerance / 2.0, tolerance)?;
        by_tolerance.push((power, largest_error(accuracy, motion)?));
    }
    let errors = Panel {
        x_label: "tolerance of slopes, its logarithm to base 10",
        y_label: "error of the slope",
        is_log: true,
        curves: vec![Curve::new("largest error", by_tolerance)],
    };
    Ok(vec![ends, errors])
}
