//! The paper's second simulation (§VI-A): a ball that is dropped on an incline, bounces and rolls.

use super::chart::{self, Axes};
use super::energies::Energies;
use super::incline::{GRAVITY, SLOPE, downhill, rolled_down};
use super::names::{self, Sample};
use super::style::{BLUE, RED, ground};
use super::{Answer, Area, incline_view};
use hydroelastic::dynamics::State;
use plotters::prelude::*;
use std::path::Path;

const SIZE: (u32, u32) = (1600, 1940);

/// Pixels for names on the right.
const NAMES: u32 = 360;

/// Relative tolerance of the last speed. In the textbook the bodies are rigid; here the skin resists rolling, the ball is a polyhedron, and
/// it still bounces a little. Without rolling, the speed would be 7/5 of the textbook's.
const TOLERANCE: f64 = 0.03;

/// Largest relative gain of energy. A step too long for the stiffness would add more.
const GAINED: f64 = 1e-3;

pub fn draw(path: &Path) -> Answer<String> {
    let (world, trajectory) = rolled_down()?;
    let states = trajectory.states();
    let last = &states[states.len() - 1];
    let (speed, textbook) = (speed(last), rolling_speed(last.time));
    assert!((speed / textbook - 1.0).abs() < TOLERANCE, "{speed}");
    let energies = Energies::of(&world, states.iter());
    let total = energies.total();
    let gained = |pair: &[f64]| pair[1] - pair[0] > GAINED * total[0];
    assert!(!total.windows(2).any(gained), "{total:?}");

    let area = ground(path, SIZE)?;
    let (side_view, curves) = area.split_vertically(900);
    incline_view::draw(&side_view, states)?;
    let curves = curves.split_evenly((2, 1));
    draw_speed(&curves[0], states)?;
    energies.draw(&curves[1], 0.0..last.time, NAMES)?;
    area.present()?;
    Ok(format!(
        "{speed:.2} m/s at the end, textbook {textbook:.2} m/s"
    ))
}

/// Returns the speed (m/s) of a rigid rolling ball at a time (s). Earlier bounces have no effect, because only gravity changes the mean
/// angular momentum about a point of the slope.
fn rolling_speed(time: f64) -> f64 {
    5.0 / 7.0 * GRAVITY * SLOPE.sin() * time
}

/// Returns the speed down the slope (m/s).
fn speed(state: &State) -> f64 {
    state.bodies[0].velocity().dot(&downhill())
}

/// Draws the speed over time, and the speed of the textbook.
fn draw_speed(area: &Area, states: &[State]) -> Answer {
    let last = &states[states.len() - 1];
    let axes = Axes {
        title: "Speed down the slope",
        x: ("time (s)", 0.0..last.time),
        y: ("speed (m/s)", 0.0..1.1 * speed(last)),
        right: NAMES,
    };
    let mut chart = chart::on(area, axes)?;
    let speeds: Vec<_> = states
        .iter()
        .map(|state| (state.time, speed(state)))
        .collect();
    let law = [0.0, last.time].map(|time| (time, rolling_speed(time)));
    chart::line(&mut chart, RED.stroke_width(3), &law)?;
    chart::line(&mut chart, BLUE.stroke_width(3), &speeds)?;
    let curves = [
        (Sample::Line(BLUE.stroke_width(3)), "this library"),
        (
            Sample::Line(RED.stroke_width(3)),
            "rolling: (5/7)·g·t·sin θ",
        ),
    ];
    names::draw(area, chart::beside(area, NAMES)?, &curves)
}
