//! The paper's first simulation (§VI-A): a ball dropped on a block.

use super::bounce::{RADIUS, drop_with};
use super::chart::{self, Axes};
use super::energies::Energies;
use super::names::{self, Sample};
use super::strobe::{self, Flash};
use super::style::{BLUE, GRAY, RED, ground};
use super::{Answer, Area};
use hydroelastic::dynamics::Trajectory;
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

const SIZE: (u32, u32) = (1600, 1360);

/// Steps between points of a curve, and between drawn balls.
const CURVE: usize = 10;
const FLASH: usize = 600;

/// Dissipation (s/m) of the lossy ball and block.
const DISSIPATION: f64 = 0.1;
const LOSSY_NAME: &str = "dissipation 0.1 s/m";

/// Drawn times (s), and pixels for names on the right.
const TIMES: Range<f64> = -0.12..1.92;
const NAMES: u32 = 360;

/// Relative change of the total energy. During contact, the error of a leapfrog step is the square of the time step divided by the contact
/// time, which is 168 steps.
const SAME_ENERGY: f64 = 1e-3;

pub fn draw(path: &Path) -> Answer<String> {
    let (world, lossless) = drop_with(0.0)?;
    let energies = Energies::of(&world, lossless.thinned(CURVE).states().iter());
    let total = energies.total();
    let changes = total.iter().map(|energy| (energy / total[0] - 1.0).abs());
    let change = changes.fold(0.0, f64::max);
    assert!(change < SAME_ENERGY, "{change}");

    let area = ground(path, SIZE)?;
    let (above, below) = area.split_vertically(780);
    draw_side_view(&above, &lossless, &drop_with(DISSIPATION)?.1)?;
    energies.draw(&below, TIMES, NAMES)?;
    area.present()?;
    Ok(format!("energy changes by {change:.0e} of it at most"))
}

/// Draws the ball at many times, from left to right.
fn draw_side_view(area: &Area, lossless: &Trajectory, lossy: &Trajectory) -> Answer {
    let heights = -0.04..0.48;
    let scale = chart::plot_size(area, NAMES)[1] / (heights.end - heights.start);
    let axes = Axes {
        title: "A ball dropped on a block, seen every 0.06 s",
        x: ("time (s)", TIMES),
        y: ("height of the center (m)", heights.clone()),
        right: NAMES,
    };
    let mut chart = chart::on(area, axes)?;
    let block = [(TIMES.start, heights.start), (TIMES.end, 0.0)];
    chart.draw_series([Rectangle::new(block, GRAY.mix(0.5).filled())])?;
    let flash = |center| Flash { center, turn: 0.0 };
    let flashes: Vec<_> = places(lossless, FLASH).into_iter().map(flash).collect();
    strobe::draw(&mut chart, &flashes, RADIUS * scale)?;
    chart::line(&mut chart, RED.stroke_width(3), &places(lossy, CURVE))?;
    let curves = [
        (
            Sample::Dot(12, BLUE.mix(0.3).filled()),
            "without dissipation",
        ),
        (Sample::Line(RED.stroke_width(3)), LOSSY_NAME),
        (Sample::Patch(GRAY.mix(0.5).filled()), "block"),
    ];
    names::draw(area, chart::beside(area, NAMES)?, &curves)
}

/// Returns time (s) and height (m) of the ball at every `every`-th step.
fn places(trajectory: &Trajectory, every: usize) -> Vec<(f64, f64)> {
    let states = trajectory.states().iter().step_by(every);
    states
        .map(|state| (state.time, state.bodies[0].position().z))
        .collect()
}
