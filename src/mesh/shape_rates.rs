use super::coordinates::first_non_finite;
use super::{MeshError, TetMesh};
use nalgebra::Vector3;

/// The derivative of a shape with respect to a parameter, such as the radius of a ball. It has the velocities of the
/// vertices and the rates of their extents, both per unit of the parameter.
///
/// Rates form a vector space: the rates for several parameters that change together are a linear combination. `From`
/// converts velocities of vertices alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeRates {
    /// Velocity of each vertex (m per unit of the parameter), in the axes of the body frame.
    pub vertices: Vec<Vector3<f64>>,
    /// Rate of the extent of each vertex (per unit of the parameter). If extents move with their vertices, all rates
    /// are 0 or the vector is empty.
    pub extents: Vec<f64>,
    /// Vertices, in ascending order, at which the shape is not differentiable, as where the distance has a kink. The
    /// rates of these vertices are one-sided or a mean. The function that made the rates documents which.
    pub ambiguous: Vec<usize>,
}

impl ShapeRates {
    /// Restricts the rates to the surface of the mesh, for a rigid body of the same shape. The order of vertices is
    /// that of [`TriangleSurface::around`](super::TriangleSurface::around).
    ///
    /// # Errors
    /// Returns an error if the number of velocities differs from the number of vertices of the mesh.
    pub fn around(&self, mesh: &TetMesh) -> Result<Self, MeshError> {
        check_count("vertices", self.vertices.len(), mesh.vertex_count())?;
        let mut around = Self::default();
        let mut ambiguous = self.ambiguous.iter().peekable();
        for (vertex, velocity) in self.vertices.iter().enumerate() {
            let is_ambiguous = ambiguous.next_if_eq(&&vertex).is_some();
            if mesh.is_on_surface(vertex) {
                if is_ambiguous {
                    around.ambiguous.push(around.vertices.len());
                }
                around.vertices.push(*velocity);
            }
        }
        Ok(around)
    }

    /// Returns the derivative of a scalar with respect to the parameter, from its derivatives with respect to vertices
    /// and extents.
    pub(crate) fn dot(
        &self,
        by_vertices: &[Vector3<f64>],
        by_extents: &[f64],
    ) -> Result<f64, MeshError> {
        check_velocities(&self.vertices, by_vertices.len())?;
        if !self.extents.is_empty() {
            check_rates(&self.extents, by_extents.len())?;
        }
        let vertices = by_vertices.iter().zip(&self.vertices);
        let by_vertices: f64 = vertices.map(|(by, velocity)| by.dot(velocity)).sum();
        let extents = by_extents.iter().zip(&self.extents);
        Ok(by_vertices + extents.map(|(by, rate)| by * rate).sum::<f64>())
    }
}

/// Rates of vertices with these velocities. Extents move with the vertices.
impl From<Vec<Vector3<f64>>> for ShapeRates {
    fn from(vertices: Vec<Vector3<f64>>) -> Self {
        Self {
            vertices,
            ..Self::default()
        }
    }
}

fn check_count(name: &'static str, found: usize, expected: usize) -> Result<(), MeshError> {
    if found == expected {
        return Ok(());
    }
    Err(MeshError::RateCount {
        name,
        found,
        expected,
    })
}

/// Checks that there is one velocity or derivative per vertex and that all are finite.
pub(super) fn check_velocities(
    velocities: &[Vector3<f64>],
    vertex_count: usize,
) -> Result<(), MeshError> {
    let name = "vertices";
    check_count(name, velocities.len(), vertex_count)?;
    match first_non_finite(velocities) {
        Some((index, value)) => Err(MeshError::NonFiniteRate { name, index, value }),
        None => Ok(()),
    }
}

/// Checks that there is one rate or derivative per extent and that all are finite.
pub(super) fn check_rates(rates: &[f64], extent_count: usize) -> Result<(), MeshError> {
    let name = "extents";
    check_count(name, rates.len(), extent_count)?;
    match rates.iter().position(|rate| !rate.is_finite()) {
        Some(index) => {
            let value = rates[index];
            Err(MeshError::NonFiniteRate { name, index, value })
        }
        None => Ok(()),
    }
}
