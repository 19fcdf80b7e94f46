//! The paper's Table I as a chart: the time of a contact against the order of the icospheres.

use super::log_axis::LogAxis;
use super::names::{self, Sample};
use super::style::{BLUE, FAINT, GRAY, GREEN, INK, ORANGE, PURPLE, RED, ground, letters, write};
use super::table_1_times::{ROWS, check_rows};
use super::{Answer, Area};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::path::Path;

const SIZE: (u32, u32) = (1600, 1060);

const TITLE: &str = "Time of one contact of two icospheres, by what is switched on";

/// Pixels for names on the right.
const NAMES: u32 = 430;

const COLORS: [RGBColor; 6] = [GRAY, BLUE, PURPLE, ORANGE, GREEN, RED];

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, LogAxis>>;

pub fn draw(path: &Path) -> Answer<String> {
    check_rows();
    let area = ground(path, SIZE)?;
    let mut chart = axes(&area)?;
    for (row, color) in ROWS.iter().zip(COLORS) {
        draw_row(&mut chart, row.paper, color, true)?;
        draw_row(&mut chart, row.ours, color, false)?;
    }
    draw_names(&area)?;
    area.present()?;
    let [slowest, fastest] = [0, 5].map(|row| ROWS[row].ours[3]);
    Ok(format!(
        "(f) {:.0} times as fast as (a) at order 4",
        slowest / fastest
    ))
}

fn axes<'a, 'b>(area: &'a Area<'b>) -> Answer<Chart<'a, 'b>> {
    let times = ROWS.iter().flat_map(|row| row.paper.iter().chain(row.ours));
    let mut chart = ChartBuilder::on(area)
        .margin_top(96)
        .margin_left(16)
        .margin_right(NAMES)
        .x_label_area_size(84)
        .y_label_area_size(130)
        .build_cartesian_2d(0.9..4.1, LogAxis::over(times.copied()))?;
    chart
        .configure_mesh()
        .x_labels(5)
        .x_label_formatter(&|order| format!("{order:.0}"))
        .y_label_formatter(&|time| round_time(*time))
        .x_desc("order of the icospheres (20·4ⁿ tetrahedra each)")
        .y_desc("time of one contact")
        .label_style(letters(23))
        .axis_desc_style(letters(25))
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .draw()?;
    Ok(chart)
}

/// Formats a round time (s) with its unit.
fn round_time(seconds: f64) -> String {
    match seconds {
        s if s < 9e-4 => format!("{:.0} µs", s * 1e6),
        s if s < 0.9 => format!("{:.0} ms", s * 1e3),
        s => format!("{s:.0} s"),
    }
}

fn draw_row(chart: &mut Chart, times: &[f64], color: RGBColor, is_paper: bool) -> Answer {
    let points = || (1..).map(f64::from).zip(times.iter().copied());
    let style = color.stroke_width(4);
    if is_paper {
        chart.draw_series(DashedLineSeries::new(points(), 10, 7, style))?;
        chart.draw_series(points().map(|point| Circle::new(point, 8, style)))?;
    } else {
        chart.draw_series(LineSeries::new(points(), style))?;
        chart.draw_series(points().map(|point| Circle::new(point, 8, color.filled())))?;
    }
    Ok(())
}

/// Draws the title and the names on the right.
fn draw_names(area: &Area) -> Answer {
    write(area, TITLE, &letters(30), ((660, 44), HPos::Center))?;
    let rows = ROWS.iter().zip(COLORS);
    let patch = |color: RGBColor| Sample::Dot(9, color.filled());
    let mut named: Vec<_> = rows.map(|(row, color)| (patch(color), row.name)).collect();
    let style = INK.stroke_width(4);
    named.push((Sample::Line(style), "this library (Rust)"));
    named.push((Sample::Dashes(style), "the paper (Julia)"));
    names::draw(area, (1200, 150), &named)
}
