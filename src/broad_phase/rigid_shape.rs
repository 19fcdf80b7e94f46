use super::RimTree;
use super::box_tree::BoxTree;
use crate::geometry::{Aabb, Tetrahedron};
use crate::mesh::{FieldTet, TriangleSurface};
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::fmt;

/// A closed surface that does not give way, with the tree over its triangles.
///
/// A shape has no pose; any number of bodies may share one.
#[derive(Clone)]
pub struct RigidShape {
    surface: TriangleSurface,
    cells: Vec<FieldTet>,
    rims: RimTree,
    /// One triangle of each connected part of the surface, by its centroid.
    parts: BoxTree<usize>,
}

/// The corners of a triangle's cell: these corners of the triangle, in an order that makes the cell positively oriented, then
/// its apex. So face 3 is the triangle itself.
const CORNERS: [usize; 3] = [0, 2, 1];

impl RigidShape {
    /// Builds the tree over the triangles.
    #[must_use]
    pub fn new(surface: TriangleSurface) -> Self {
        let triangles = 0..surface.triangles().len();
        let cells: Vec<_> = triangles.map(|triangle| cell(&surface, triangle)).collect();
        let parts = surface.component_starts().iter();
        let point_of = |triangle: usize| Aabb::around([&centroid(&surface, triangle)]);
        Self {
            rims: RimTree::of_cells(&cells),
            parts: BoxTree::new(parts.map(|&start| (start, point_of(start)))),
            surface,
            cells,
        }
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &TriangleSurface {
        &self.surface
    }

    /// The box around the surface, in the body frame.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.surface.aabb()
    }

    /// A tetrahedron behind each triangle, with the depth (m) below the triangle as extent: its other faces bound the triangle.
    pub(crate) fn cells(&self) -> &[FieldTet] {
        &self.cells
    }

    /// Its triangles.
    pub(crate) fn rims(&self) -> &RimTree {
        &self.rims
    }

    /// Visits one triangle of each connected part of the surface and its centroid (m, in B), if that may lie in the box
    /// `region` in A.
    pub(crate) fn visit_parts_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(usize, &Vector3<f64>),
    ) {
        self.parts.visit_near(region, pose_ab, margin, |triangle| {
            visit(triangle, &centroid(&self.surface, triangle));
        });
    }

    /// The cell of the triangle beyond a face of a cell; none beyond the triangle itself.
    pub(crate) fn neighbour(&self, cell: usize, face: usize) -> Option<usize> {
        let edge = CORNERS.get(face)?;
        Some(self.surface.neighbour(cell, *edge))
    }
}

fn centroid(surface: &TriangleSurface, triangle: usize) -> Vector3<f64> {
    surface.corners(triangle).iter().sum::<Vector3<f64>>() / 3.0
}

/// As deep as the triangle's longest edge is long, below its centroid.
fn cell(surface: &TriangleSurface, triangle: usize) -> FieldTet {
    let corners = surface.corners(triangle);
    let [a, b, c] = CORNERS.map(|corner| corners[corner]);
    let inward = (b - a).cross(&(c - a)).normalize();
    let edges = [b - a, c - b, a - c];
    let depth = edges.iter().map(Vector3::norm).fold(0.0, f64::max);
    let apex = (a + b + c) / 3.0 + inward * depth;
    let tetrahedron = Tetrahedron {
        corners: [a, b, c, apex],
    };
    FieldTet::new(triangle, tetrahedron, [0.0, 0.0, 0.0, depth])
}

impl fmt::Debug for RigidShape {
    /// The number of triangles stands for the surface, which would fill pages.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.cells.len();
        formatter
            .debug_struct("RigidShape")
            .field("triangles", &triangles)
            .finish_non_exhaustive()
    }
}
