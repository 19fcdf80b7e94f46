//! Reverse-mode gradients with respect to ten to a hundred thousand parameters: the wrenches on eight balls on a box, up to one wrench per
//! ball and step, and the vertices and extents of all bodies.

use super::panel::Curve;
use super::scenes::heap;
use super::timing::{count, median_ratio};
use hydroelastic::dynamics::{Control, Material, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, Mode, Outcome, Parameter};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Wrench;
use std::hint::black_box;

/// Duration (s), the same as that of the rollouts of the Jacobians.
const DURATION: f64 = 0.02;
/// Number of steps: a wrench on each ball in each step makes 100,000 parameters.
const STEPS: usize = 2_084;
const BALLS: usize = 8;
const NUMBERS_A_WRENCH: usize = 6;
const ROUNDS: usize = 5;

/// Squared final distance (m²) of the first ball from the origin.
struct Miss;

impl Outcome for Miss {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[1].position();
        vec![position.dot(position)]
    }
}

/// Measures the cost of gradients, in rollouts, against the number of parameters: with respect to wrenches alone, and with respect to all
/// vertices and extents too. Prints a table row for each.
pub fn measured(is_quick: bool) -> [Curve; 2] {
    println!(
        "\n| numbers | gradient backwards, in rollouts ({STEPS} steps) | with shapes: numbers | in rollouts |"
    );
    println!("| --- | --- | --- | --- |");
    let mut by_wrenches = Curve::new("gradient backwards, by wrenches", 1.0);
    let mut by_all = Curve::new("by all vertices too", 1.0);
    // Number of balls with a control, and number of intervals of each control.
    let all = [(1, 2), (8, 2), (8, 21), (8, 209), (8, STEPS)];
    let some = if is_quick { &all[1..3] } else { &all[..] };
    for &(balls, intervals) in some {
        let plan = Plan::new(DURATION / STEPS as f64, STEPS).unwrap();
        let world = pushed(balls, intervals);
        let experiment = Experiment::new(&world, &plan.recording_every(STEPS));
        let parameters = wrenches(balls, intervals);
        let by_numbers = in_rollouts(&experiment, || {
            let gradient =
                experiment.gradient_with_mode(Mode::Reverse, black_box(&parameters), &Miss);
            drop(black_box(gradient.unwrap()));
        });
        let with_shapes = in_rollouts(&experiment, || {
            drop(black_box(
                black_box(&experiment).full_gradient(&Miss).unwrap(),
            ));
        });
        let numbers = NUMBERS_A_WRENCH * parameters.len();
        let all_numbers = numbers + shape_numbers(&world);
        by_wrenches.push(numbers as f64, by_numbers);
        by_all.push(all_numbers as f64, with_shapes);
        println!(
            "| {} | {by_numbers:.2} | {} | {with_shapes:.2} |",
            count(numbers),
            count(all_numbers)
        );
    }
    [by_wrenches, by_all]
}

fn name(ball: usize) -> String {
    format!("ball {ball}")
}

/// Returns the heap with controls of the first balls.
fn pushed(balls: usize, intervals: usize) -> World {
    let heap = heap([BALLS / 2, 2, 1], Material::elastic(1e5));
    let duration = DURATION / intervals as f64;
    (0..balls).fold(heap, |world, ball| {
        let zeros = vec![Wrench::zero(); intervals];
        let control = Control::new(&name(ball), duration, zeros).unwrap();
        world.with_control(control).unwrap()
    })
}

fn wrenches(balls: usize, intervals: usize) -> Vec<Parameter> {
    let of_ball = |ball: usize| {
        let body = name(ball);
        (0..intervals).map(move |interval| Parameter::Control(body.as_str().into(), interval))
    };
    (0..balls).flat_map(of_ball).collect()
}

/// Returns the number of shape parameters: three coordinates and an extent for each vertex of each body.
fn shape_numbers(world: &World) -> usize {
    let shapes = world.bodies().iter().map(|body| body.shape().compliant());
    let vertices = shapes
        .flatten()
        .map(|shape| shape.field().mesh().vertex_count());
    4 * vertices.sum::<usize>()
}

/// Returns the cost of the work in rollouts.
fn in_rollouts(experiment: &Experiment, work: impl FnMut()) -> f64 {
    median_ratio(ROUNDS, work, || {
        drop(black_box(experiment.value(&Miss).unwrap()));
    })
}
