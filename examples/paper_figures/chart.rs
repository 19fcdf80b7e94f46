//! Line charts in a common style.

use super::style::{FAINT, letters, write};
use super::thinning::thinned;
use super::view::Pixel;
use super::{Answer, Area};
use nalgebra::Vector2;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::ops::Range;

pub type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Pixels above the plot, below and to the left of it for the axes, and at the left edge of the picture.
const ABOVE: u32 = 76;
const BELOW: u32 = 84;
const LEFT: u32 = 116;
const EDGE: u32 = 16;

/// Title, ranges and labels of a chart.
pub struct Axes<'a> {
    pub title: &'a str,
    pub x: (&'a str, Range<f64>),
    pub y: (&'a str, Range<f64>),
    /// Pixels to the right of the plot.
    pub right: u32,
}

/// Returns width and height of the plot in pixels.
pub fn plot_size(area: &Area, right: u32) -> [f64; 2] {
    let (across, up) = area.dim_in_pixel();
    [across - EDGE - LEFT - right, up - ABOVE - BELOW].map(f64::from)
}

/// Returns the upper left corner of the area to the right of a plot.
pub fn beside(area: &Area, right: u32) -> Answer<Pixel> {
    let across = area.dim_in_pixel().0;
    Ok((
        i32::try_from(across - right)? + 28,
        i32::try_from(ABOVE)? + 20,
    ))
}

/// Draws the axes.
pub fn on<'a, 'b>(area: &'a Area<'b>, axes: Axes) -> Answer<Chart<'a, 'b>> {
    let middle = (EDGE + LEFT + area.dim_in_pixel().0 - axes.right) / 2;
    let title = ((i32::try_from(middle)?, 38), HPos::Center);
    write(area, axes.title, &letters(30), title)?;
    let mut chart = ChartBuilder::on(area)
        .margin_top(ABOVE)
        .margin_left(EDGE)
        .margin_right(axes.right)
        .x_label_area_size(BELOW)
        .y_label_area_size(LEFT)
        .build_cartesian_2d(axes.x.1, axes.y.1)?;
    chart
        .configure_mesh()
        .x_desc(axes.x.0)
        .y_desc(axes.y.0)
        .x_label_formatter(&|x| number(*x))
        .y_label_formatter(&|y| number(*y))
        .label_style(letters(23))
        .axis_desc_style(letters(25))
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .draw()?;
    Ok(chart)
}

/// Formats a round number without the accumulated rounding error of the ticks.
fn number(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    // Adding 0 turns −0 into 0.
    format!("{}", rounded + 0.0)
}

/// Draws a curve.
pub fn line(chart: &mut Chart, style: ShapeStyle, points: &[(f64, f64)]) -> Answer {
    let (across, up) = chart.plotting_area().dim_in_pixel();
    let [x, y] = [chart.x_range(), chart.y_range()].map(|range| range.end - range.start);
    let pixels = Vector2::new(f64::from(across) / x, f64::from(up) / y);
    chart.draw_series(LineSeries::new(thinned(points, pixels), style))?;
    Ok(())
}
