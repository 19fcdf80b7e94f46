//! The paper's Figure 2: icospheres of increasing resolution.

use super::solid::{draw_edges, fill, front_and_back, surface};
use super::style::{INK, between, ground, letters, write};
use super::view::View;
use super::{Answer, Area};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::f64::consts::PI;
use std::path::Path;

const SIZE: (u32, u32) = (1280, 1320);

/// Radius of a ball, and its position in its panel (pixels).
const RADIUS: f64 = 270.0;
const CENTER: (i32, i32) = (320, 300);

pub fn draw(path: &Path) -> Answer<String> {
    let area = ground(path, SIZE)?;
    let mut missing = Vec::new();
    for (order, panel) in area.split_evenly((2, 2)).iter().enumerate() {
        missing.push(draw_icosphere(panel, order)?);
    }
    area.present()?;
    // A subdivision halves the edges, and the missing volume is quadratic in the edge length.
    assert!(missing.windows(2).all(|pair| pair[1] < pair[0] / 3.0));
    let last = missing.last().ok_or("no panel")?;
    Ok(format!("order 3 misses {:.1} % of the ball", 100.0 * last))
}

/// Draws a ball, and returns the fraction of the exact ball's volume that is missing.
fn draw_icosphere(area: &Area, order: usize) -> Answer<f64> {
    let field = shapes::icosphere(1.0, order)?;
    let mesh = field.mesh();
    let view = View::from(vector![1.0, -2.2, 1.1], CENTER, RADIUS);
    let faces = surface(mesh, &Pose::identity(), WHITE.into());
    let [mut front, _] = front_and_back(faces, &view);
    for face in &mut front {
        face.color = lit(&face.normal()).into();
    }
    let edges = INK.mix(0.75).stroke_width(if order < 3 { 2 } else { 1 });
    fill(area, &view, &front)?;
    draw_edges(area, &view, &front, edges)?;

    let share = mesh.volume() / (4.0 / 3.0 * PI);
    let lines = [
        format!("order {order}: {} tetrahedra", count(mesh.tet_count())),
        format!("{:.1} % of the ball’s volume", 100.0 * share),
    ];
    for (line, y) in lines.iter().zip([600, 636]) {
        write(area, line, &letters(28), ((CENTER.0, y), HPos::Center))?;
    }
    Ok(1.0 - share)
}

/// Returns the color of a face, lit by a large lamp at the upper left.
fn lit(normal: &Vector3<f64>) -> RGBColor {
    let lamp = vector![-0.35, -1.0, 1.1].normalize();
    let light = 0.5 + 0.5 * normal.dot(&lamp);
    between(RGBColor(25, 60, 95), RGBColor(200, 228, 248), light)
}

/// Formats a number with a comma before its last three digits.
fn count(number: usize) -> String {
    match (number / 1_000, number % 1_000) {
        (0, last) => format!("{last}"),
        (thousands, last) => format!("{thousands},{last:03}"),
    }
}
