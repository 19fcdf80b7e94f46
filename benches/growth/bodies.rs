//! Growth with the number of bodies in a world: a heap of balls on a box.

use super::panel::{Curve, Panel};
use super::picture::time_tick;
use super::scenes::{final_state, heap};
use super::timing::{count, median_processor_seconds, time};
use hydroelastic::dynamics::Material;
use std::hint::black_box;
use std::time::Duration;

const STEPS: usize = 5;
const BUDGET: Duration = Duration::from_secs(1);

/// Smallest number of bodies in the fit. In smaller heaps, most balls lie at the outside and have fewer neighbors.
const FITTED_FROM: f64 = 64.0;

/// Prints a line for each heap.
pub fn measured(is_quick: bool) -> Panel {
    println!("\n| balls | polygons | a step | of it a ball | a polygon |");
    println!("| --- | --- | --- | --- | --- |");
    let skin = Material::elastic(1e5)
        .with_dissipation(0.5)
        .with_friction(0.4);
    let mut curve = Curve::new("step", FITTED_FROM);
    let edges: &[usize] = if is_quick { &[2, 4, 8] } else { &[2, 4, 8, 16] };
    for &edge in edges {
        let (balls, world) = (edge.pow(3), heap([edge; 3], skin));
        let polygons = world
            .topology(&final_state(&world, STEPS))
            .unwrap()
            .polygon_count();
        let rollout = || {
            black_box(final_state(black_box(&world), STEPS));
        };
        let seconds = median_processor_seconds(BUDGET, rollout) / STEPS as f64;
        curve.push(balls as f64, seconds);
        println!(
            "| {} | {} | {} | {} | {:.0} ns |",
            count(balls),
            count(polygons),
            time(seconds),
            time(seconds / balls as f64),
            seconds / polygons as f64 * 1e9,
        );
    }
    Panel {
        title: "Bodies",
        x_label: "balls in a heap",
        y_label: "time of a step",
        y_tick: time_tick,
        curves: vec![curve],
    }
}
