//! The boundary of a solid and its derivatives.

use super::Solid;
use crate::mesh::MeshError;
use crate::mesh::shape_rates::{check_rates, check_velocities};
use nalgebra::Vector3;

/// A vertex of the mesh on an edge of the lattice that crosses the boundary.
#[derive(Debug, Clone)]
pub(super) struct BoundaryVertex {
    pub vertex: usize,
    /// The edge (m), from its inner to its outer end.
    pub edge: Vector3<f64>,
    pub follows: Option<Follows>,
}

/// The triangle that a vertex follows: the edge e of the lattice crosses its plane at the vertex, or at a height above the plane.
///
/// If the triangle moves with the velocity ẋ at the point below the vertex, and the height grows at the rate ḣ, the vertex moves at
/// the rate e (n·ẋ + ḣ)/(n·e), where n is the outer unit normal.
#[derive(Debug, Clone)]
pub(super) struct Follows {
    /// Vertices of the triangle.
    pub corners: [usize; 3],
    /// Barycentric coordinates of the place where the edge crosses the triangle.
    pub crossing: [f64; 3],
    /// Barycentric coordinates of the point of the plane below the vertex.
    pub below: [f64; 3],
    /// The normal n over n·e (1/m).
    pub normal: Vector3<f64>,
    /// The derivative of the height with respect to the length of each gap around the vertex.
    pub height_by_gap: f64,
}

impl Follows {
    /// Returns n·ẋ/(n·e) at the place with these barycentric coordinates.
    fn rate(&self, shares: [f64; 3], velocities: &[Vector3<f64>]) -> f64 {
        self.normal.dot(&weighted(self.corners, shares, velocities))
    }

    /// Adds the derivatives of a scalar with respect to the corners, from that with respect to the position along the edge of the
    /// place with these barycentric coordinates.
    fn pull_back(&self, shares: [f64; 3], by_position: f64, gradient: &mut [Vector3<f64>]) {
        for (&corner, share) in self.corners.iter().zip(shares) {
            gradient[corner] += self.normal * (share * by_position);
        }
    }

    /// Returns 1/(n·e) (1/m).
    pub fn over_slope(&self) -> f64 {
        self.normal.norm()
    }
}

fn weighted(corners: [usize; 3], shares: [f64; 3], vectors: &[Vector3<f64>]) -> Vector3<f64> {
    let terms = corners.iter().zip(shares);
    terms.map(|(&corner, share)| vectors[corner] * share).sum()
}

impl Solid {
    /// Returns the vertices of the mesh, in ascending order, at which a small change of the boundary changes the tetrahedra or at which
    /// the boundary has no triangle to follow, as in a hole or where an edge of the lattice grazes it. Derivatives of other vertices
    /// are exact up to rounding error while no vertex comes to be listed.
    #[must_use]
    pub fn ambiguous(&self) -> &[usize] {
        &self.ambiguous
    }

    /// Returns the velocity of each vertex of the mesh (m per unit of a parameter) from the velocities of the vertices of the triangles.
    ///
    /// # Errors
    /// Returns an error if the number of velocities is not that of the triangles' vertices, or if one is not finite.
    pub fn rates(&self, velocities: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(velocities, self.input_count)?;
        let count = self.mesh.vertex_count();
        let mut rates = vec![Vector3::zeros(); count];
        for (vertex, follows) in self.following() {
            rates[vertex.vertex] = vertex.edge * follows.rate(follows.crossing, velocities);
        }
        // The sum over the gaps around each vertex.
        let mut gaps = vec![0.0; count];
        for gap in &self.gaps {
            let rate = gap.rate(&rates, velocities);
            gap.vertices.iter().for_each(|&vertex| gaps[vertex] += rate);
        }
        for (vertex, follows) in self.following() {
            let height = follows.height_by_gap * gaps[vertex.vertex];
            let along = follows.rate(follows.below, velocities) + height * follows.over_slope();
            rates[vertex.vertex] = vertex.edge * along;
        }
        Ok(rates)
    }

    /// Returns the derivatives of a scalar with respect to the vertices of the triangles (unit of the scalar per m) from those with
    /// respect to the vertices of the mesh.
    ///
    /// # Errors
    /// Returns an error if the number of derivatives is not that of the mesh's vertices, or if one is not finite.
    pub fn pullback(&self, by_vertices: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, MeshError> {
        let count = self.mesh.vertex_count();
        check_velocities(by_vertices, count)?;
        let mut gradient = vec![Vector3::zeros(); self.input_count];
        let mut by_gaps = vec![0.0; count];
        for (vertex, follows) in self.following() {
            let along = vertex.edge.dot(&by_vertices[vertex.vertex]);
            follows.pull_back(follows.below, along, &mut gradient);
            by_gaps[vertex.vertex] = follows.height_by_gap * follows.over_slope() * along;
        }
        let mut by_crossings = vec![Vector3::zeros(); count];
        for gap in &self.gaps {
            let by_gap = gap.vertices.iter().map(|&vertex| by_gaps[vertex]).sum();
            gap.pull_back(by_gap, &mut by_crossings, &mut gradient);
        }
        for (vertex, follows) in self.following() {
            let along = vertex.edge.dot(&by_crossings[vertex.vertex]);
            follows.pull_back(follows.crossing, along, &mut gradient);
        }
        Ok(gradient)
    }

    fn following(&self) -> impl Iterator<Item = (&BoundaryVertex, &Follows)> {
        let boundary = self.boundary.iter();
        boundary.filter_map(|vertex| Some((vertex, vertex.follows.as_ref()?)))
    }

    /// Returns the indices of the vertices on the boundary, in the order in which [`Self::rates_of_distance`] takes derivatives.
    pub fn boundary_vertices(&self) -> impl Iterator<Item = usize> {
        self.boundary.iter().map(|vertex| vertex.vertex)
    }

    /// Returns the velocity of each vertex of the mesh (m per unit of a parameter) from derivatives of the distance function at the
    /// [`Self::boundary_vertices`]: its gradient, and its derivative with respect to the parameter (m per unit). A vertex moves along
    /// its edge e of the lattice at the rate −e ∂φ/∂θ / (∇φ·e).
    ///
    /// # Errors
    /// Returns an error if the number of gradients or derivatives is not that of the vertices on the boundary, or if a velocity is
    /// not finite.
    pub fn rates_of_distance(
        &self,
        gradients: &[Vector3<f64>],
        by_parameter: &[f64],
    ) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(gradients, self.boundary.len())?;
        check_rates(by_parameter, self.boundary.len())?;
        let mut rates = vec![Vector3::zeros(); self.mesh.vertex_count()];
        for (vertex, (gradient, by)) in self.boundary.iter().zip(gradients.iter().zip(by_parameter))
        {
            rates[vertex.vertex] = vertex.edge * (-by / gradient.dot(&vertex.edge));
        }
        check_velocities(&rates, rates.len())?;
        Ok(rates)
    }
}
