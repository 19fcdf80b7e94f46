//! A contact surface, colored by pressure.

use super::color_bar::{self, LEVELS};
use super::solid::{Face, draw_edges, fill};
use super::style::INK;
use super::view::View;
use super::{Answer, Area};
use hydroelastic::contact::{ContactPolygon, ContactSurface};
use hydroelastic::geometry::AffineField;
use plotters::prelude::*;

/// Position of the color bar, pascals in a kilopascal, and kilopascals between marks.
const BAR: (i32, i32) = (1090, 360);
const KILO: f64 = 1e3;
const EVERY: f64 = 5.0;

/// Tolerance of clipping, relative to the highest pressure.
const NOTHING: f64 = 1e-12;

/// A bit outside the sides of a contact polygon, because the picture does not use sides.
const SIDE: u8 = 0b1000_0000;

/// Draws the polygons, shaded in levels, and the color bar.
pub fn draw(area: &Area, view: &View, contact: &ContactSurface) -> Answer {
    let highest = highest_pressure(contact);
    // Each level is drawn over the whole surface before the next, so that the previous level shows in the seams between polygons.
    for level in 0..LEVELS {
        let polygons = contact.polygons.iter();
        let parts = polygons.filter_map(|polygon| part_above(polygon, level, highest));
        fill(area, view, &parts.collect::<Vec<_>>())?;
    }
    let whole = contact.polygons.iter().map(|polygon| Face {
        corners: polygon.outline.corners().to_vec(),
        color: TRANSPARENT,
    });
    let edges = INK.mix(0.35).stroke_width(1);
    draw_edges(area, view, &whole.collect::<Vec<_>>(), edges)?;
    color_bar::draw(area, BAR, highest / KILO, EVERY)
}

/// Returns the part of a polygon where the pressure is above the start of a level. Returns `None` for levels wholly below the pressure of
/// the polygon, except the last two of them, which fill the seams.
fn part_above(polygon: &ContactPolygon, level: u32, highest: f64) -> Option<Face> {
    let start = |level: u32| color_bar::share(level) * highest;
    let corners = polygon.outline.corners().iter();
    let pressures = corners.map(|corner| polygon.pressure_at(corner));
    let lowest = pressures.fold(highest, f64::min);
    let at_origin = polygon.pressure - polygon.pressure_gradient.dot(&polygon.centroid);
    let excess = AffineField {
        gradient: polygon.pressure_gradient,
        offset: at_origin - start(level),
    };
    let part = polygon.outline.clipped(&excess, NOTHING * highest, SIDE);
    let is_seen = lowest < start(level + 3) && !part.is_empty();
    is_seen.then(|| Face {
        corners: part.corners().to_vec(),
        color: color_bar::color(level).into(),
    })
}

/// Returns the highest pressure (Pa) at a corner.
fn highest_pressure(contact: &ContactSurface) -> f64 {
    let at_corners = contact.polygons.iter().flat_map(|polygon| {
        let corners = polygon.outline.corners().iter();
        corners.map(|corner| polygon.pressure_at(corner))
    });
    at_corners.fold(0.0, f64::max)
}
