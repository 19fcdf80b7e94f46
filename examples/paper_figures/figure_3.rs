//! The paper's Figure 3: the force between two unit cubes against their offset.

use super::Answer;
use super::chart::{self, Axes};
use super::names::{self, Sample};
use super::style::{BLUE, INK, RED, ground};
use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use plotters::prelude::*;
use std::path::Path;

const SIZE: (u32, u32) = (1600, 900);

/// Modulus (Pa), because the paper's cubes have pressure ½ at their centers.
const MODULUS: f64 = 0.5;

/// Number of offsets from 0 to 1, and also to −1, and number of offsets between drawn points.
const STEPS: i32 = 200;
const DRAWN: usize = 10;

/// Largest deviation (N) of a force from the closed form.
const EXACT: f64 = 1e-12;

pub fn draw(path: &Path) -> Answer<String> {
    let cube = Shape::new(shapes::cuboid([1.0; 3])?);
    let (mut forces, mut worst) = (Vec::new(), 0.0_f64);
    for step in -STEPS..=STEPS {
        let offset = f64::from(step) / f64::from(STEPS);
        let force = force_between(&cube, offset)?;
        // Coincident cubes have zero force: a removable discontinuity of the curve.
        let expected = if step == 0 { 0.0 } else { closed_form(offset) };
        worst = worst.max((force - expected).abs());
        forces.push((offset, force));
    }
    assert!(worst <= EXACT, "{worst}");
    draw_chart(path, &forces)?;
    Ok(format!("{worst:.0e} N from the closed form at most"))
}

/// Returns the magnitude of the force (N) on a cube moved along y.
fn force_between(cube: &Shape, offset: f64) -> Answer<f64> {
    let moved = Pose::from_translation(vector![0.0, offset, 0.0]);
    let pair = ContactPair::new(
        ContactBody::new(cube, moved, MODULUS)?,
        ContactBody::new(cube, Pose::identity(), MODULUS)?,
    );
    Ok(pair.wrench().on_a.force.norm())
}

/// Returns (1 − |x|³)/6.
fn closed_form(offset: f64) -> f64 {
    (1.0 - offset.abs().powi(3)) / 6.0
}

fn draw_chart(path: &Path, forces: &[(f64, f64)]) -> Answer {
    let area = ground(path, SIZE)?;
    let axes = Axes {
        title: "Force between two unit cubes, centerd at (0, 0, 0) and (0, x, 0)",
        x: ("offset x (m)", -1.05..1.05),
        y: ("magnitude of the force (N)", -0.006..0.18),
        right: 40,
    };
    let mut chart = chart::on(&area, axes)?;
    let curve: Vec<_> = forces.iter().map(|(x, _)| (*x, closed_form(*x))).collect();
    chart::line(&mut chart, BLUE.stroke_width(3), &curve)?;
    // The curve has a hole at 0.
    let hole = (0.0, closed_form(0.0));
    let [ground, rim] = [WHITE.filled(), BLUE.stroke_width(3)];
    chart.draw_series([ground, rim].map(|style| Circle::new(hole, 9, style)))?;
    let drawn = forces.iter().step_by(DRAWN).filter(|(x, _)| *x != 0.0);
    chart.draw_series(drawn.map(|point| Circle::new(*point, 6, INK.filled())))?;
    chart.draw_series([Circle::new((0.0, 0.0), 10, RED.filled())])?;
    let curves = [
        (
            Sample::Line(BLUE.stroke_width(3)),
            "closed form (1 − |x|³)/6",
        ),
        (Sample::Dot(6, INK.filled()), "this library"),
        (
            Sample::Dot(10, RED.filled()),
            "this library at x = 0, where the cubes coincide",
        ),
    ];
    names::draw(&area, (560, 420), &curves)?;
    area.present()?;
    Ok(())
}
