use crate::broad_phase::TriangleBvh;
use crate::bvh::Bvh;
use crate::geometry::{Aabb, Tetrahedron};
use crate::mesh::{FieldTet, OUTSIDE, TriangleSurface};
use nalgebra::Vector3;
use std::fmt;

/// The shape of a rigid body: a closed surface with bounding-volume hierarchies over its triangles.
///
/// A shape has no pose, so several bodies may share one. [`Partner::rigid`](crate::contact::Partner::rigid) adds a
/// pose.
#[derive(Clone)]
pub struct RigidShape {
    surface: TriangleSurface,
    bounds: Aabb,
    cells: Vec<FieldTet>,
    /// The cells behind the neighboring triangles of each cell. There is no neighbor across face 3, the triangle
    /// itself.
    neighbors: Vec<[u32; 4]>,
    triangle_bvh: TriangleBvh,
    /// One triangle of each connected component of the surface, located at its centroid.
    components: Bvh<usize>,
}

/// Tolerance of the test whether a vertical line crosses a triangle, relative to the area of the triangle. Because of the tolerance,
/// rounding leaves no gap between neighboring triangles.
const GAP: f64 = 1e-9;

/// Corners of the triangle in the order in which they are the first three corners of its cell. The cell, with the apex
/// as fourth corner, is then positively oriented. Face 3 of the cell is the triangle itself.
const CORNERS: [usize; 3] = [0, 2, 1];

impl RigidShape {
    /// Builds the bounding-volume hierarchies over the triangles in O(n log n) time.
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

    /// Returns the surface.
    #[must_use]
    pub fn surface(&self) -> &TriangleSurface {
        &self.surface
    }

    /// Returns the bounding box of the surface in the body frame (m).
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns whether a point of the body frame (m) is inside the surface.
    ///
    /// The point is inside if it is on the inner side of the nearest triangle above the point.
    pub(crate) fn contains(&self, point: &Vector3<f64>) -> bool {
        let mut above = Aabb::around([point]);
        above.upper.z = self.bounds.upper.z.max(point.z);
        let mut nearest = (f64::INFINITY, false);
        let bvh = self.triangle_bvh.bvh();
        bvh.visit_overlapping(&above, |face| {
            let [a, b, c] = face.corners(&self.cells).map(|corner| corner - point);
            let areas = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|area| area.z);
            let area: f64 = areas.iter().sum();
            let height = a.dot(&b.cross(&c)) / area;
            let is_above = areas.iter().all(|part| part / area >= -GAP) && height >= 0.0;
            if is_above && height < nearest.0 {
                nearest = (height, area > 0.0);
            }
        });
        nearest.1
    }

    /// Returns the cells: a tetrahedron behind each triangle, with the depth (m) below the triangle as its extent. The
    /// other faces of the tetrahedron pass through the edges of the triangle. Cell k belongs to triangle k.
    pub(crate) fn cells(&self) -> &[FieldTet] {
        &self.cells
    }

    /// Returns the vertices at the first three corners of a cell.
    pub(crate) fn vertices_of(&self, cell: usize) -> [usize; 3] {
        CORNERS.map(|corner| self.surface.triangles()[cell][corner])
    }

    /// Returns the bounding-volume hierarchy over the triangles.
    pub(crate) fn triangle_bvh(&self) -> &TriangleBvh {
        &self.triangle_bvh
    }

    /// Returns one triangle of each connected component of the surface, located at its centroid.
    pub(crate) fn components(&self) -> &Bvh<usize> {
        &self.components
    }

    /// Returns the centroid of a triangle (m).
    pub(crate) fn centroid(&self, triangle: usize) -> Vector3<f64> {
        centroid(&self.surface, triangle)
    }

    /// Returns the neighbors of each cell across its faces, by the opposite corner, or [`OUTSIDE`].
    pub(crate) fn neighbors(&self) -> &[[u32; 4]] {
        &self.neighbors
    }
}

/// Converts the neighbors of a triangle across its edges into neighbors of its cell across faces.
fn across_faces(across_edges: &[u32; 3]) -> [u32; 4] {
    let [a, b, c] = CORNERS.map(|corner| across_edges[corner]);
    [a, b, c, OUTSIDE]
}

fn centroid(surface: &TriangleSurface, triangle: usize) -> Vector3<f64> {
    surface.corners(triangle).iter().sum::<Vector3<f64>>() / 3.0
}

/// Builds the cell behind a triangle. The depth of its apex below the triangle's centroid is the length of the longest
/// edge.
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
    /// Prints the number of triangles in place of the long surface.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.cells.len();
        formatter
            .debug_struct("RigidShape")
            .field("triangles", &triangles)
            .finish_non_exhaustive()
    }
}
