//! The boundary of a solid and its derivatives.

use super::stuffing::CutVertex;
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
    /// Barycentric coordinates of the point at which the edge crosses the triangle.
    pub crossing: [f64; 3],
    /// Barycentric coordinates of the point of the plane below the vertex.
    pub below: [f64; 3],
    /// The normal n over n·e (1/m).
    pub normal: Vector3<f64>,
    /// The derivative of the height with respect to the length of each gap around the vertex.
    pub height_by_gap: f64,
}

impl Follows {
    /// Returns n·ẋ/(n·e) at the point with these barycentric coordinates.
    fn rate(&self, shares: [f64; 3], velocities: &[Vector3<f64>]) -> f64 {
        self.normal.dot(&weighted(self.corners, shares, velocities))
    }

    /// Adds the derivatives of a scalar with respect to the corners. `by_position` is its derivative with respect to the position, along
    /// the edge, of the point with these barycentric coordinates.
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

/// Returns the sum of the vectors at three corners, weighted by shares.
fn weighted(corners: [usize; 3], shares: [f64; 3], vectors: &[Vector3<f64>]) -> Vector3<f64> {
    let terms = corners.iter().zip(shares);
    terms.map(|(&corner, share)| vectors[corner] * share).sum()
}

/// The gap between a triangle on the boundary of the mesh and the surface: the height of the surface above the middle of the triangle.
#[derive(Debug, Clone)]
pub(super) struct Gap {
    /// Vertices of the triangle.
    pub vertices: [usize; 3],
    /// Vertices of the closest triangle of the surface.
    pub corners: [usize; 3],
    /// Barycentric coordinates of the closest point.
    pub shares: [f64; 3],
    /// Unit vector from the middle to the closest point, or its opposite if the surface is below the triangle.
    pub direction: Vector3<f64>,
    /// Height of the surface (m).
    pub length: f64,
    /// Whether the surface is smooth above the triangle.
    pub is_smooth: bool,
    /// Whether a small change of the boundary can change `is_smooth`.
    pub is_at_tie: bool,
}

impl Gap {
    /// Returns the rate of the length, from the velocities of the vertices of the mesh and of the surface.
    pub fn rate(&self, of_mesh: &[Vector3<f64>], of_surface: &[Vector3<f64>]) -> f64 {
        let middle = weighted(self.vertices, [1.0 / 3.0; 3], of_mesh);
        let foot = weighted(self.corners, self.shares, of_surface);
        self.direction.dot(&(foot - middle))
    }

    /// Adds the derivatives of a scalar with respect to the vertices of the mesh and of the surface. `by_length` is its derivative with
    /// respect to the length.
    pub fn pull_back(
        &self,
        by_length: f64,
        by_mesh: &mut [Vector3<f64>],
        by_surface: &mut [Vector3<f64>],
    ) {
        for (&corner, share) in self.corners.iter().zip(self.shares) {
            by_surface[corner] += self.direction * (share * by_length);
        }
        for vertex in self.vertices {
            by_mesh[vertex] -= self.direction * (by_length / 3.0);
        }
    }
}

/// The boundary of a mesh, and how it follows triangles.
#[derive(Debug, Clone)]
pub(super) struct Boundary {
    pub vertices: Vec<BoundaryVertex>,
    pub gaps: Vec<Gap>,
    /// Number of vertices of the triangles, or 0 if there are none.
    pub input_count: usize,
    /// The vertices of the mesh at which a derivative is not exact, in ascending order.
    pub ambiguous: Vec<usize>,
}

impl Boundary {
    /// Creates the boundary of stuffed tetrahedra that follow no triangles.
    pub fn of(cuts: &[CutVertex]) -> Self {
        let vertex = |cut: &CutVertex| BoundaryVertex {
            vertex: cut.vertex,
            edge: cut.edge,
            follows: None,
        };
        let ambiguous = cuts.iter().filter(|cut| cut.is_at_tie);
        Self {
            vertices: cuts.iter().map(vertex).collect(),
            gaps: Vec::new(),
            input_count: 0,
            ambiguous: ambiguous.map(|cut| cut.vertex).collect(),
        }
    }

    /// Returns the velocities of the vertices of a mesh, of which there are `count`, from those of the triangles' vertices.
    pub fn rates(
        &self,
        count: usize,
        velocities: &[Vector3<f64>],
    ) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(velocities, self.input_count)?;
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

    /// Returns the derivatives with respect to the triangles' vertices from those with respect to the vertices of the mesh.
    pub fn pullback(&self, by_vertices: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let count = by_vertices.len();
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
        gradient
    }

    fn following(&self) -> impl Iterator<Item = (&BoundaryVertex, &Follows)> {
        let boundary = self.vertices.iter();
        boundary.filter_map(|vertex| Some((vertex, vertex.follows.as_ref()?)))
    }

    /// Returns the velocities of the vertices of a mesh, of which there are `count`, from derivatives of a distance function.
    pub fn rates_of_distance(
        &self,
        count: usize,
        gradients: &[Vector3<f64>],
        by_parameter: &[f64],
    ) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(gradients, self.vertices.len())?;
        check_rates(by_parameter, self.vertices.len())?;
        let mut rates = vec![Vector3::zeros(); count];
        for (vertex, (gradient, by)) in self.vertices.iter().zip(gradients.iter().zip(by_parameter))
        {
            rates[vertex.vertex] = vertex.edge * (-by / gradient.dot(&vertex.edge));
        }
        check_velocities(&rates, rates.len())?;
        Ok(rates)
    }
}
