use crate::broad_phase::TriangleBvh;
use crate::bvh::Bvh;
use crate::geometry::{Aabb, Tetrahedron};
use crate::mesh::{FieldTet, OUTSIDE, TriangleSurface};
use nalgebra::Vector3;
use std::fmt;

/// What a rigid body is made of for contact: a closed surface that does not give way, with trees over its triangles.
///
/// A shape has no pose; any number of bodies may share one. [`Partner::rigid`](crate::contact::Partner::rigid) gives it one.
#[derive(Clone)]
pub struct RigidShape {
    surface: TriangleSurface,
    bounds: Aabb,
    cells: Vec<FieldTet>,
    /// For each cell those behind the neighboring triangles. Beyond the triangle itself, face 3, there is none.
    neighbors: Vec<[u32; 4]>,
    triangle_bvh: TriangleBvh,
    /// One triangle of each connected component of the surface, by its centroid.
    components: Bvh<usize>,
}

/// Which corner of its triangle each of a cell's first three corners is: the order in which the cell, with the apex as fourth
/// corner, is positively oriented. Face 3 of the cell is the triangle itself.
const CORNERS: [usize; 3] = [0, 2, 1];

impl RigidShape {
    /// Builds the trees over the triangles: O(n log n), once per surface.
    #[must_use]
    pub fn new(surface: TriangleSurface) -> Self {
        let triangles = 0..surface.triangles().len();
        let cells: Vec<_> = triangles.map(|triangle| cell(&surface, triangle)).collect();
        let starts = surface.component_starts().iter();
        let point_of = |triangle: usize| [centroid(&surface, triangle)];
        Self {
            triangle_bvh: TriangleBvh::of_cells(&cells),
            components: Bvh::new(starts.map(|&start| (start, point_of(start)))),
            bounds: surface.aabb(),
            neighbors: surface.neighbors().iter().map(across_faces).collect(),
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
        self.bounds
    }

    /// A tetrahedron behind each triangle, with the depth (m) below the triangle as extent: its other faces bound the
    /// triangle. Cell k is that of triangle k.
    pub(crate) fn cells(&self) -> &[FieldTet] {
        &self.cells
    }

    /// The vertices at the first three corners of a cell.
    pub(crate) fn vertices_of(&self, cell: usize) -> [usize; 3] {
        CORNERS.map(|corner| self.surface.triangles()[cell][corner])
    }

    /// The tree over its triangles.
    pub(crate) fn triangle_bvh(&self) -> &TriangleBvh {
        &self.triangle_bvh
    }

    /// One triangle of each connected component of the surface, by its centroid.
    pub(crate) fn components(&self) -> &Bvh<usize> {
        &self.components
    }

    /// The centroid of a triangle (m).
    pub(crate) fn centroid(&self, triangle: usize) -> Vector3<f64> {
        centroid(&self.surface, triangle)
    }

    /// For each cell those beyond its faces, by the opposite corner, or [`OUTSIDE`].
    pub(crate) fn neighbors(&self) -> &[[u32; 4]] {
        &self.neighbors
    }
}

/// The cells across the faces of a cell, from the triangles across the edges of its own.
fn across_faces(across_edges: &[u32; 3]) -> [u32; 4] {
    let [a, b, c] = CORNERS.map(|corner| across_edges[corner]);
    [a, b, c, OUTSIDE]
}

fn centroid(surface: &TriangleSurface, triangle: usize) -> Vector3<f64> {
    surface.corners(triangle).iter().sum::<Vector3<f64>>() / 3.0
}

/// The cell behind a triangle. Its apex is as deep below the triangle's centroid as the longest edge is long.
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
