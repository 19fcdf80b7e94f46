//! Log-log figure with one panel for each kind of growth.

use super::log_axis::LogAxis;
use super::panel::{Curve, Panel};
use super::timing::count;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

/// Width and height in pixels.
const SIZE: (u32, u32) = (960, 720);

const COLORS: [RGBColor; 3] = [
    RGBColor(0, 90, 181),
    RGBColor(220, 80, 20),
    RGBColor(0, 140, 100),
];
const GRAY: RGBColor = RGBColor(130, 130, 130);
const FAINT: RGBColor = RGBColor(225, 225, 225);

type Answer = Result<(), Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
/// Radius in pixels and style.
type Mark = (i32, ShapeStyle);
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogAxis, LogAxis>>;

/// Draws the panels in two columns.
pub fn draw(path: &Path, panels: &[Panel]) -> Answer {
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let panel_areas = area.split_evenly((panels.len().div_ceil(2), 2));
    for (panel, panel_area) in panels.iter().zip(&panel_areas) {
        draw_panel(panel_area, panel)?;
    }
    area.present()?;
    Ok(())
}

fn draw_panel(area: &Area, panel: &Panel) -> Answer {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let mut chart = ChartBuilder::on(area)
        .caption(title(panel), ("sans-serif", 18))
        .margin(10)
        .margin_right(22)
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d(
            LogAxis::over(points().map(|point| point.0)),
            LogAxis::over(points().map(|point| point.1)),
        )?;
    chart
        .configure_mesh()
        .x_desc(panel.x_label)
        .y_desc(panel.y_label)
        .x_label_formatter(&|x| number_tick(*x))
        .y_label_formatter(&|y| (panel.y_tick)(*y))
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .draw()?;
    // The second curve has rings as markers, so dots below remain visible.
    let marks = [
        (4, COLORS[0].filled()),
        (6, COLORS[1].stroke_width(2)),
        (4, COLORS[2].filled()),
        (0, GRAY.stroke_width(1)),
    ];
    for (curve, mark) in panel.curves.iter().zip(marks) {
        draw_curve(&mut chart, curve, mark)?;
    }
    if panel.curves.len() > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .label_font(("sans-serif", 13))
            .legend_area_size(22)
            .background_style(TRANSPARENT)
            .border_style(TRANSPARENT)
            .draw()?;
    }
    Ok(())
}

/// Draws the points and the fitted line. A known law is drawn as a line only.
fn draw_curve(chart: &mut Chart, curve: &Curve, (radius, style): Mark) -> Answer {
    if !curve.is_measured {
        let line = LineSeries::new(curve.points.iter().copied(), GRAY.stroke_width(1));
        let drawn = chart.draw_series(line)?.label(&curve.name);
        drawn.legend(|(x, y)| PathElement::new([(x, y), (x + 14, y)], GRAY));
        return Ok(());
    }
    let ends = [curve.fitted().first(), curve.fitted().last()];
    let fit = ends
        .into_iter()
        .flatten()
        .map(|(x, _)| (*x, curve.fit_at(*x)));
    chart.draw_series(LineSeries::new(fit, style.stroke_width(1)))?;
    let points = curve.points.iter().copied();
    let dots = points.map(|point| Circle::new(point, radius, style));
    let drawn = chart.draw_series(dots)?.label(&curve.name);
    drawn.legend(move |(x, y)| Circle::new((x + 7, y), radius, style));
    Ok(())
}

fn title(panel: &Panel) -> String {
    let measured = panel.curves.iter().filter(|curve| curve.is_measured);
    let exponents: Vec<_> = measured.map(Curve::exponent_text).collect();
    let plural = if exponents.len() > 1 { "s" } else { "" };
    format!("{}: exponent{plural} {}", panel.title, exponents.join(", "))
}

/// Formats a whole number.
pub fn number_tick(number: f64) -> String {
    count(number)
}

/// Formats a round time (s) with its unit.
pub fn time_tick(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s => format!("{s:.0} s"),
    }
}
