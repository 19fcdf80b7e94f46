use nalgebra::Vector3;

/// Triangles as files and modelers have them, before any check: they may be open, overlap, or be oriented inconsistently.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleSoup {
    /// Positions of the vertices (m) in the body frame.
    pub vertices: Vec<Vector3<f64>>,
    /// Vertex indices of each triangle, counter-clockwise when seen from outside. They may be out of range.
    pub triangles: Vec<[usize; 3]>,
}
