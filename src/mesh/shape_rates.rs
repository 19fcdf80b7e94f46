use super::coordinates::first_non_finite;
use super::{MeshError, TetMesh};
use nalgebra::Vector3;

/// How a shape changes with a number that it is made of, such as the radius of a ball: velocities of its vertices, and rates of
/// their extents, both over the number's unit.
///
/// Rates are a vector space: those by several numbers that change together are sums of multiples. `From` takes the velocities of
/// vertices alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeRates {
    /// Velocity of each vertex (m over the number's unit), in the axes of the body's frame.
    pub vertices: Vec<Vector3<f64>>,
    /// Rate of the extent of each vertex (over the number's unit). Where extents stay with their vertices, all are 0, or there are
    /// none.
    pub extents: Vec<f64>,
    /// Vertices, ascending, whose rates are one of several, or a mean: at a kink, as of the distance to two faces that are
    /// equally near. Whatever made the rates says what they are there.
    pub ambiguous: Vec<usize>,
}

impl ShapeRates {
    /// Those of the surface of the mesh, as [`TriangleSurface::around`](super::TriangleSurface::around) makes it: of a rigid
    /// body of the same shape.
    ///
    /// # Errors
    /// If there are not as many velocities as the mesh has vertices.
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

    /// The derivative of a number that has these derivatives by the vertices and extents.
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

/// Vertices that move at these velocities, while extents stay with them.
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

/// Checks that there is a finite velocity, or derivative, of each vertex.
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

/// Checks that there is a finite rate, or derivative, of each extent.
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
