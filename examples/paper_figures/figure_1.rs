//! The paper's Figure 1: two bodies, their contact surface and the force.

use super::names::{self, Sample};
use super::solid::{draw_edges, fill, front_and_back, surface};
use super::style::{BLUE, GREEN, INK, RED, ground, letters, write};
use super::view::View;
use super::{Answer, Area, arrow, pressure_picture};
use hydroelastic::contact::{ContactBody, ContactPair, ContactPolygon, ContactSurface, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::path::Path;

const SIZE: (u32, u32) = (1400, 1000);

/// Hydroelastic modulus (Pa) of ball and block.
const MODULUS: f64 = 1e5;

/// Length of the force arrow (m) per newton.
const ARROW: f64 = 4e-4;

/// Relative tolerance of the sum of the polygons' forces, because the order of summation changes rounding errors.
const SAME: f64 = 1e-12;

pub fn draw(path: &Path) -> Answer<String> {
    let ball = Shape::new(shapes::icosphere(0.1, 2)?);
    let block = Shape::new(shapes::cuboid([0.2, 0.26, 0.16])?);
    let pose_a = Pose::from_translation(vector![0.03, 0.02, 0.13]);
    let pose_b = Pose::from_rotation_vector(&vector![0.0, 0.12, 0.0], Vector3::zeros());
    let pair = ContactPair::new(
        ContactBody::new(&ball, pose_a, MODULUS)?,
        ContactBody::new(&block, pose_b, MODULUS)?,
    );
    let (force, contact) = (pair.wrench().on_a.force, pair.surface());
    let sum: Vector3<f64> = contact.polygons.iter().map(ContactPolygon::force).sum();
    assert!((force - sum).norm() <= SAME * force.norm(), "{force} {sum}");

    let area = ground(path, SIZE)?;
    let mut view = View::from(vector![0.55, -1.0, 0.62], (530, 470), 2350.0);
    view.target = vector![0.01, 0.0, 0.07];
    draw_bodies(&area, &view, &pair, &contact)?;
    draw_force(&area, &view, &contact, &force)?;
    draw_names(&area)?;
    area.present()?;
    let polygons = contact.polygons.len();
    Ok(format!("{polygons} polygons, force {:.0} N", force.norm()))
}

/// Draws the contact surface between the far and the near sides of both bodies.
fn draw_bodies(area: &Area, view: &View, pair: &ContactPair, contact: &ContactSurface) -> Answer {
    let sides = [
        (pair.a(), RED, 0.10),
        (&pair.b().body().unwrap(), BLUE, 0.13),
    ]
    .map(|(body, color, opacity)| {
        let mesh = body.shape().field().mesh();
        let faces = surface(mesh, body.pose(), color.mix(opacity));
        (front_and_back(faces, view), color)
    });
    for ([_, back], color) in &sides {
        fill(area, view, back)?;
        draw_edges(area, view, back, color.mix(0.15).stroke_width(1))?;
    }
    pressure_picture::draw(area, view, contact)?;
    for ([front, _], color) in &sides {
        fill(area, view, front)?;
        draw_edges(area, view, front, color.mix(0.5).stroke_width(2))?;
    }
    Ok(())
}

/// Draws the force on the ball at the center of pressure.
fn draw_force(area: &Area, view: &View, contact: &ContactSurface, force: &Vector3<f64>) -> Answer {
    let center = contact.center_of_pressure().ok_or("nothing presses")?;
    let ends = [center, center + force * ARROW].map(|point| view.pixel(&point));
    arrow::draw(area, ends, INK, 6)?;
    area.draw(&Circle::new(ends[0], 8, INK.filled()))?;
    let place = ((ends[1].0 + 26, ends[1].1 + 14), HPos::Left);
    write(area, &format!("{:.0} N", force.norm()), &letters(30), place)
}

/// Draws the labels.
fn draw_names(area: &Area) -> Answer {
    let ball = Sample::Patch(RED.mix(0.3).filled());
    let block = Sample::Patch(BLUE.mix(0.3).filled());
    let surface = Sample::Patch(GREEN.filled());
    let force = Sample::Line(INK.stroke_width(6));
    let named = [
        (ball, "ball"),
        (block, "block"),
        (surface, "contact surface"),
        (force, "force on the ball"),
    ];
    names::draw(area, (1050, 90), &named)
}
