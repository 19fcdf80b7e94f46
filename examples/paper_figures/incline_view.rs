//! A ball that bounces down the incline, from the side.

use super::chart::{self, Axes};
use super::incline::{RADIUS, SLOPE};
use super::strobe::{self, Flash};
use super::style::GRAY;
use super::{Answer, Area};
use hydroelastic::dynamics::State;
use plotters::prelude::*;
use std::ops::Range;

/// Recorded states between drawn balls.
const FLASH: usize = 60;

/// Visible range of x, and the highest visible z (m).
const ACROSS: Range<f64> = -0.2..3.4;
const TOP: f64 = 0.75;

/// Pixels on the right.
const EDGE: u32 = 40;

/// Draws the ball at many times, to scale.
pub fn draw(area: &Area, states: &[State]) -> Answer {
    let [width, height] = chart::plot_size(area, EDGE);
    let scale = width / (ACROSS.end - ACROSS.start);
    let bottom = TOP - height / scale;
    let axes = Axes {
        title: "A ball dropped on an incline, seen every 0.06 s",
        x: ("x (m)", ACROSS),
        y: ("z (m)", bottom..TOP),
        right: EDGE,
    };
    let mut chart = chart::on(area, axes)?;
    let ends = [ACROSS.start, ACROSS.end];
    let [upper, lower] = ends.map(|x| (x, -x * SLOPE.tan()));
    let slope = [upper, lower, (ACROSS.end, bottom), (ACROSS.start, bottom)];
    chart.draw_series([Polygon::new(slope.to_vec(), GRAY.mix(0.5).filled())])?;
    let flashes: Vec<_> = states.iter().step_by(FLASH).map(flash).collect();
    strobe::draw(&mut chart, &flashes, RADIUS * scale)
}

fn flash(state: &State) -> Flash {
    let pose = &state.bodies[0].pose;
    let (center, up) = (pose.translation(), pose.rotation().column(2));
    Flash {
        center: (center.x, center.z),
        turn: up[0].atan2(up[2]),
    }
}
