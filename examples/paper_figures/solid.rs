//! Faces in space, and their painting.

use super::trails::trails;
use super::view::{Pixel, View};
use super::{Answer, Area};
use hydroelastic::mesh::TetMesh;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use plotters::prelude::*;

/// A flat convex face, with corners (m) counter-clockwise seen from outside.
pub struct Face {
    pub corners: Vec<Vector3<f64>>,
    pub color: RGBAColor,
}

impl Face {
    /// Returns the outward unit normal.
    pub fn normal(&self) -> Vector3<f64> {
        let edge = |corner: usize| self.corners[corner] - self.corners[0];
        edge(1).cross(&edge(2)).normalize()
    }

    fn outline(&self, view: &View) -> Vec<Pixel> {
        let corners = self.corners.iter();
        corners.map(|corner| view.pixel(corner)).collect()
    }
}

/// Returns the surface of a posed mesh in one color.
pub fn surface(mesh: &TetMesh, pose: &Pose, color: RGBAColor) -> Vec<Face> {
    let corner = |vertex: usize| pose.transformed_point(&mesh.vertices()[vertex]);
    let triangles = mesh.surface_triangles().iter();
    let face = |triangle: &[usize; 3]| Face {
        corners: triangle.map(corner).to_vec(),
        color,
    };
    triangles.map(face).collect()
}

/// Returns the faces toward the viewer, and the faces away from the viewer.
pub fn front_and_back(faces: Vec<Face>, view: &View) -> [Vec<Face>; 2] {
    let (front, back) = faces
        .into_iter()
        .partition(|face| view.nearness(&face.normal()) > 0.0);
    [front, back]
}

/// Fills faces in their order.
pub fn fill(area: &Area, view: &View, faces: &[Face]) -> Answer {
    for face in faces {
        area.draw(&Polygon::new(face.outline(view), face.color.filled()))?;
    }
    Ok(())
}

/// Draws the edges of faces.
pub fn draw_edges(area: &Area, view: &View, faces: &[Face], style: ShapeStyle) -> Answer {
    let outlines: Vec<_> = faces.iter().map(|face| face.outline(view)).collect();
    for trail in trails(&outlines) {
        area.draw(&PathElement::new(trail, style))?;
    }
    Ok(())
}
