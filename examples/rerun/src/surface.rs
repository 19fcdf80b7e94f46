//! A contact surface as a mesh colored by pressure.

use crate::bodies::single;
use crate::palette;
use hydroelastic::contact::{ContactPolygon, ContactSurface};
use rerun::{Mesh3D, Rgba32};

/// Pressure (Pa) of the last color, which is about the largest pressure of the first bounce.
const HIGHEST: f64 = 1.6e4;

/// Returns the polygons of a surface (m, world frame), or an empty mesh without a surface.
pub fn mesh(surface: Option<&ContactSurface>) -> Mesh3D {
    let (mut corners, mut colors, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for polygon in surface.iter().flat_map(|surface| &surface.polygons) {
        triangles.extend(fan(corners.len(), polygon.outline.corners().len()));
        corners.extend(polygon.outline.corners().iter().map(single));
        colors.extend(corner_colors(polygon));
    }
    Mesh3D::new(corners)
        .with_vertex_colors(colors)
        .with_triangle_indices(triangles)
}

/// Returns the triangles from the first corner of a convex polygon to its other edges.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a surface has far fewer than 2³² corners"
)]
fn fan(first: usize, count: usize) -> impl Iterator<Item = [u32; 3]> {
    (first + 2..first + count).map(move |corner| [first, corner - 1, corner].map(|i| i as u32))
}

fn corner_colors(polygon: &ContactPolygon) -> impl Iterator<Item = Rgba32> {
    let corners = polygon.outline.corners().iter();
    corners.map(|corner| palette::pressure(polygon.pressure_at(corner) / HIGHEST))
}
