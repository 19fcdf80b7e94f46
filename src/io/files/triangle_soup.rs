use nalgebra::Vector3;

/// Triangles without shared vertices, in the unit of the file.
pub(super) type TriangleSoup = Vec<[Vector3<f64>; 3]>;
