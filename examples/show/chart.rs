//! SVG charts of curves.

use super::Panel;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;
use std::path::Path;

/// Size of a panel in pixels.
const SIZE: (u32, u32) = (840, 240);
/// Width (pixels) for the names of the curves on the right.
const LEGEND: i32 = 130;
/// Colors that color-blind readers can distinguish [Okabe 2008].
const COLORS: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(40, 40, 40),
];
/// Margin around the curves, as a fraction of their range.
const ROOM: f64 = 0.05;

/// Draws panels below each other.
pub fn draw(path: &Path, panels: &[Panel]) -> Result<(), Box<dyn Error>> {
    let size = (SIZE.0, SIZE.1 * u32::try_from(panels.len())?);
    let area = SVGBackend::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    for (area, panel) in area.split_evenly((panels.len(), 1)).iter().zip(panels) {
        draw_panel(area, panel)?;
    }
    Ok(area.present()?)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn draw_panel(area: &Area, panel: &Panel) -> Result<(), Box<dyn Error>> {
    // A logarithmic axis is a linear axis of the logarithms.
    let height = |y: f64| if panel.is_log { y.log10() } else { y };
    let at = |&(x, y): &(f64, f64)| (x, height(y));
    let points = || panel.curves.iter().flat_map(|c| &c.points).map(at);
    let y_tick = |y: &f64| {
        if panel.is_log {
            format!("{:.0e}", 10_f64.powf(*y))
        } else {
            decimal(*y)
        }
    };
    let (x, y) = (span(points().map(|p| p.0)), span(points().map(|p| p.1)));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(LEGEND)
        .x_label_area_size(40)
        .y_label_area_size(72)
        .build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(panel.x_label)
        .x_label_formatter(&|x| decimal(*x))
        .y_desc(panel.y_label)
        .y_label_formatter(&y_tick);
    mesh.light_line_style(TRANSPARENT).draw()?;
    for (place, (curve, color)) in panel.curves.iter().zip(COLORS).enumerate() {
        let line = LineSeries::new(curve.points.iter().map(at), color.stroke_width(2));
        chart.draw_series(line)?;
        let (x, y) = (
            SIZE.0.cast_signed() - LEGEND + 12,
            24 + 20 * i32::try_from(place)?,
        );
        let dash = PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2));
        area.draw(&dash)?;
        area.draw(&Text::new(
            curve.name.clone(),
            (x + 22, y - 6),
            ("sans-serif", 13),
        ))?;
    }
    Ok(())
}

/// Returns the range of some values, with a margin.
fn span(values: impl Iterator<Item = f64> + Clone) -> Range<f64> {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    let room = (ROOM * (high - low)).max(f64::MIN_POSITIVE);
    low - room..high + room
}

/// Formats a number without the accumulated rounding error of the ticks and without trailing zeros.
fn decimal(number: f64) -> String {
    // Adding 0 turns −0 into 0.
    format!("{}", (number * 1e6).round() / 1e6 + 0.0)
}
