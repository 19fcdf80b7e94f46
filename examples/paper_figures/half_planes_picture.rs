//! Picture of the half-planes of Figure 4, their intersection by each algorithm, and a magnified view of the nearly common border.

use super::chart::{self, Axes};
use super::figure_4::{LOWER, UPPER};
use super::names::{self, Sample};
use super::style::{BLUE, GRAY, GREEN, ORANGE, RED, letters, write};
use super::view::{Pixel, whole};
use super::{Answer, Area};
use nalgebra::Vector2;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Pixels per meter, and the pixel of the origin in a panel.
const SCALE: f64 = 340.0;
const ORIGIN: Pixel = (400, 450);

/// Fraction of a triangle's edge by which its border extends beyond the triangle.
const BEYOND: f64 = 0.12;

/// Nanometers in a meter.
const NANO: f64 = 1e9;

/// Pixels for names on the right.
const NAMES: u32 = 440;

/// Result of one algorithm.
pub struct Panel<'a> {
    pub title: &'a str,
    pub outcome: String,
    pub found: &'a [Vector2<f64>],
}

pub fn draw_panel(area: &Area, panel: &Panel) -> Answer {
    for (triangle, color) in [(LOWER, BLUE), (UPPER, ORANGE)] {
        let corners = triangle.map(|corner| pixel(&Vector2::from(corner)));
        area.draw(&Polygon::new(corners.to_vec(), color.mix(0.15).filled()))?;
    }
    let found: Vec<_> = panel.found.iter().map(pixel).collect();
    if !found.is_empty() {
        area.draw(&Polygon::new(found.clone(), GREEN.mix(0.6).filled()))?;
    }
    for (ends, color) in borders() {
        area.draw(&PathElement::new(ends.to_vec(), color.stroke_width(4)))?;
    }
    for place in found {
        area.draw(&Circle::new(place, 11, GREEN.filled()))?;
    }
    let center = |y| ((ORIGIN.0, y), HPos::Center);
    write(area, panel.title, &letters(30), center(38))?;
    write(area, &panel.outcome, &letters(27), center(80))
}

/// Returns the borders of all half-planes. The two nearly equal borders are drawn as one.
fn borders() -> [([Pixel; 2], RGBColor); 5] {
    let sides = [
        (LOWER, 0, BLUE),
        (LOWER, 2, BLUE),
        (UPPER, 1, ORANGE),
        (UPPER, 2, ORANGE),
        (LOWER, 1, RED),
    ];
    sides.map(|(triangle, first, color)| {
        let [from, to] = [first, first + 1].map(|place| Vector2::from(triangle[place % 3]));
        let beyond = (to - from) * BEYOND;
        ([from - beyond, to + beyond].map(|end| pixel(&end)), color)
    })
}

fn pixel(point: &Vector2<f64>) -> Pixel {
    let [across, up] = [point.x, point.y].map(|length| whole(length * SCALE));
    (ORIGIN.0 + across, ORIGIN.1 - up)
}

/// Draws the height of the upper border above the lower border.
pub fn draw_gap(area: &Area, tolerance: f64) -> Answer {
    let axes = Axes {
        title: "The red border is two: heights above the lower triangle’s",
        x: ("x (m)", -0.95..0.85),
        y: ("height (nm)", -0.25..2.0),
        right: NAMES,
    };
    let mut chart = chart::on(area, axes)?;
    let gap = |corner: usize, of: usize| (UPPER[corner][1] - LOWER[of][1]) * NANO;
    let upper = [(UPPER[0][0], gap(0, 2)), (UPPER[1][0], gap(1, 1))];
    let level = |height: f64| [(LOWER[2][0], height), (LOWER[1][0], height)];
    let [orange, gray, blue] = [ORANGE, GRAY, BLUE].map(|color| color.stroke_width(4));
    chart::line(&mut chart, orange, &upper)?;
    chart.draw_series(DashedLineSeries::new(level(tolerance * NANO), 10, 7, gray))?;
    chart::line(&mut chart, blue, &level(0.0))?;
    let curves = [
        (Sample::Line(orange), "upper triangle’s border"),
        (Sample::Dashes(gray), "tolerance of the paper’s code"),
        (Sample::Line(blue), "lower triangle’s border"),
        (Sample::Dot(11, GREEN.filled()), "corner found (left: two)"),
    ];
    names::draw(area, chart::beside(area, NAMES)?, &curves)
}
