//! The fit of the boundary to curved surfaces. The vertices of stuffed tetrahedra lie on the surface. Triangles between vertices on a
//! convex surface lie below it, so that the volume is too small. Vertices therefore move outwards until the mean gap between the surface and
//! the triangles around each vertex is zero. On a concave surface they move inwards.

use super::boundary::{Boundary, BoundaryVertex, Follows, Gap};
use super::error::SolidError;
use super::region::{Crossing, InsideTriangles};
use super::resolution::power_below;
use super::stuffing::Stuffing;
use crate::geometry::{FACES, Triangle};
use crate::mesh::TetMesh;
use crate::parallel;
use nalgebra::Vector3;

/// Mean distance between a triangle and a surface with quadratic heights that passes through its corners, over the distance at its
/// middle.
const MEAN_OVER_MIDDLE: f64 = 0.75;

/// The surface above a triangle of the boundary is smooth if its normal there and the normals at the triangle's corners have cosines above
/// this limit. The boundary is not fitted to sharp edges, because the faces beside them would bulge.
const SMOOTH: f64 = 0.9;

/// Largest move of a vertex over the smallest height of the tetrahedra around it. The limit keeps tetrahedra from being inverted.
const LARGEST_MOVE: f64 = 0.2;

/// Distance from the surface up to which a triangle is on it, over the length of an edge.
const TOUCHING: f64 = 1e-9;

/// Cosine of the angle between an edge and a triangle's normal below which the place of a cut is not differentiable in practice.
const GRAZING: f64 = 1e-6;

/// Difference of two ratios below which a small change of the boundary changes the fit.
const TIE: f64 = 1e-6;

/// The triangles that a solid fills.
pub(super) struct Input<'a> {
    /// Vertices of the triangles (m).
    vertices: &'a [Vector3<f64>],
    triangles: &'a [[usize; 3]],
    pub region: InsideTriangles,
}

impl<'a> Input<'a> {
    /// Prepares the queries in O(n log n) time. There must be a triangle with an area.
    pub fn new(vertices: &'a [Vector3<f64>], triangles: &'a [[usize; 3]]) -> Self {
        let corners = triangles
            .iter()
            .map(|triangle| triangle.map(|vertex| vertices[vertex]));
        Self {
            vertices,
            triangles,
            region: InsideTriangles::new(corners),
        }
    }

    /// Returns how a vertex at the crossing of an edge (m) follows the triangle there, if there is one.
    fn follows(&self, crossing: &Crossing, edge: &Vector3<f64>) -> Option<Follows> {
        let (triangle, shares) = crossing.triangle?;
        let normal = self.region.normal(triangle);
        let along = normal.dot(edge);
        (along.abs() > GRAZING * edge.norm()).then(|| Follows {
            corners: self.triangles[triangle],
            crossing: shares,
            below: shares,
            normal: normal / along,
            height_by_gap: 0.0,
        })
    }

    /// Returns a mesh that fits the triangles, with its boundary.
    pub fn fitted(&self, stuffing: Stuffing) -> Result<(TetMesh, Boundary), SolidError> {
        let mut boundary = Boundary::of(&stuffing.cuts);
        boundary.input_count = self.vertices.len();
        for (vertex, cut) in boundary.vertices.iter_mut().zip(&stuffing.cuts) {
            vertex.follows = self.follows(&cut.crossing, &cut.edge);
            if vertex.follows.is_none() {
                boundary.ambiguous.push(vertex.vertex);
            }
        }
        let mesh = TetMesh::new(stuffing.vertices, stuffing.tets)?;
        let vertices = self.fit(&mesh, &mut boundary);
        boundary.ambiguous.sort_unstable();
        boundary.ambiguous.dedup();
        Ok((mesh.with_vertices(vertices)?, boundary))
    }

    /// Returns the vertices of a mesh that fits the triangles. The boundary of the mesh notes how it follows them.
    fn fit(&self, mesh: &TetMesh, boundary: &mut Boundary) -> Vec<Vector3<f64>> {
        let count = mesh.vertex_count();
        let mut triangle_counts = vec![0.0_f64; count];
        for &vertex in mesh.surface_triangles().as_flattened() {
            triangle_counts[vertex] += 1.0;
        }
        let mut is_at_tie = vec![false; count];
        boundary
            .ambiguous
            .iter()
            .for_each(|&vertex| is_at_tie[vertex] = true);
        let gaps = self.gaps(mesh, &boundary.vertices, &is_at_tie);
        for gap in gaps.iter().filter(|gap| gap.is_at_tie) {
            gap.vertices
                .iter()
                .for_each(|&vertex| is_at_tie[vertex] = true);
        }
        boundary.gaps = gaps.into_iter().filter(|gap| gap.is_smooth).collect();
        let mut sums = vec![0.0; count];
        for gap in &boundary.gaps {
            gap.vertices
                .iter()
                .for_each(|&vertex| sums[vertex] += gap.length);
        }
        let heights = least_heights(mesh);
        let mut vertices = mesh.vertices().to_vec();
        for BoundaryVertex {
            vertex,
            edge,
            follows,
        } in &mut boundary.vertices
        {
            let Some(follows) = follows else { continue };
            // A vertex in a slit narrower than a spacing has no triangles around it.
            let height_by_gap = MEAN_OVER_MIDDLE / triangle_counts[*vertex].max(1.0);
            let share = height_by_gap * sums[*vertex] * follows.over_slope();
            // The limit is rounded down to a power of two, so that small changes of the boundary do not change the limit.
            let limit = power_below(LARGEST_MOVE * heights[*vertex] / edge.norm(), [2.0, 0.5]);
            is_at_tie[*vertex] |= (share.abs() / limit - 1.0).abs() < TIE;
            vertices[*vertex] += *edge * share.clamp(-limit, limit);
            if share.abs() < limit {
                let corners = follows.corners.map(|corner| self.vertices[corner]);
                follows.below = Triangle::new(corners).shares_of(&vertices[*vertex]);
                follows.height_by_gap = height_by_gap;
            }
        }
        boundary
            .ambiguous
            .extend((0..count).filter(|&vertex| is_at_tie[vertex]));
        vertices
    }

    /// Returns the gaps of the triangles. A gap is also at a tie if one of its vertices is, because the normal at that vertex may jump.
    fn gaps(&self, mesh: &TetMesh, boundary: &[BoundaryVertex], is_at_tie: &[bool]) -> Vec<Gap> {
        // Outer normals of the triangles that the vertices follow, or 0.
        let mut normals = vec![Vector3::zeros(); mesh.vertex_count()];
        for vertex in boundary {
            let normal = vertex
                .follows
                .as_ref()
                .map(|follows| follows.normal.normalize());
            normals[vertex.vertex] = normal.unwrap_or_default();
        }
        parallel::map(mesh.surface_triangles(), |&vertices| {
            let corners = vertices.map(|vertex| mesh.vertices()[vertex]);
            let mut gap = self.gap(vertices, corners, vertices.map(|vertex| normals[vertex]));
            gap.is_at_tie |= vertices.iter().any(|&vertex| is_at_tie[vertex]);
            gap
        })
    }

    fn gap(
        &self,
        vertices: [usize; 3],
        [a, b, c]: [Vector3<f64>; 3],
        normals: [Vector3<f64>; 3],
    ) -> Gap {
        let middle = (a + b + c) / 3.0;
        let (index, distance, foot) = self.region.nearest(&middle);
        let is_touching = distance <= TOUCHING * (b - a).norm();
        let direction = if is_touching {
            *self.region.normal(index)
        } else {
            foot.direction
        };
        let sign = direction.dot(&(b - a).cross(&(c - a))).signum();
        let direction = direction * sign;
        let cosines = normals.map(|normal| normal.dot(&direction));
        Gap {
            vertices,
            corners: self.triangles[index],
            shares: foot.shares,
            direction,
            length: if is_touching { 0.0 } else { -distance * sign },
            is_smooth: cosines.iter().all(|&cosine| cosine > SMOOTH),
            is_at_tie: cosines.iter().any(|cosine| (cosine - SMOOTH).abs() < TIE),
        }
    }
}

/// Returns the least height of each vertex above the opposite face of a tetrahedron (m).
fn least_heights(mesh: &TetMesh) -> Vec<f64> {
    let mut heights = vec![f64::INFINITY; mesh.vertex_count()];
    for (tet, vertices) in mesh.tets().iter().enumerate() {
        let tetrahedron = mesh.tetrahedron(tet);
        for (&vertex, face) in vertices.iter().zip(FACES) {
            let [a, b, c] = face.map(|corner| tetrahedron.corners[corner]);
            let height = 6.0 * tetrahedron.signed_volume() / (b - a).cross(&(c - a)).norm();
            heights[vertex] = heights[vertex].min(height);
        }
    }
    heights
}
