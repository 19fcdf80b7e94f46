use crate::bvh::{Bvh, PerNode};
use crate::geometry::{Aabb, AffineField};
use crate::mesh::{FieldTet, PressureField};
use nalgebra::Vector3;

/// Bounds of a field over a set of tetrahedra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FieldBounds {
    /// Center of the box around the tetrahedra (m).
    pub center: Vector3<f64>,
    /// Half extents of that box (m).
    pub half: Vector3<f64>,
    /// Affine approximation of the extent. Its gradient is the center of the box around all
    /// gradients. Its offset minimizes the largest error for that gradient.
    pub mean: AffineField,
    /// Largest absolute difference between the extent and `mean`.
    pub error: f64,
    /// Largest absolute difference (1/m) between each component of the gradient of the extent and
    /// the same component of the gradient of `mean`.
    pub spread: Vector3<f64>,
    /// Center of the box around the gradients in all tetrahedra that share a vertex with the set
    /// (1/m).
    pub gradient_around: Vector3<f64>,
    /// Half extents of that box (1/m).
    pub spread_around: Vector3<f64>,
    /// Largest sensitivity (1/m).
    pub sensitivity: f64,
}

/// Returns, for each vertex, the box around the gradients in the tetrahedra that contain the
/// vertex.
fn gradients_around(field: &PressureField) -> Vec<Aabb> {
    let mut boxes = vec![Aabb::around([]); field.mesh().vertex_count()];
    for (tet, vertices) in field.tets().iter().zip(field.mesh().tets()) {
        for &vertex in vertices {
            boxes[vertex] = boxes[vertex].union(&Aabb::around([&tet.extent.gradient]));
        }
    }
    boxes
}

impl FieldBounds {
    /// Computes the bounds below each node of a tree of tetrahedra.
    pub fn of_nodes(field: &PressureField, tets: &Bvh<usize>) -> PerNode<Self> {
        let around = gradients_around(field);
        PerNode::of(tets, |part, _| Self::of(field, &around, part))
    }

    /// Computes the bounds over a set of tetrahedra, given the box around the gradients at each
    /// vertex.
    fn of(field: &PressureField, around: &[Aabb], part: &[usize]) -> Self {
        let tets = || part.iter().map(|&tet| &field.tets()[tet]);
        let bounds = Aabb::around(tets().flat_map(|tet| &tet.tetrahedron.corners));
        let gradients = Aabb::around(tets().map(|tet| &tet.extent.gradient));
        let gradient = gradients.center();
        let rests = tets().flat_map(|tet| {
            let corners = tet.tetrahedron.corners.iter().zip(tet.extents);
            corners.map(|(corner, extent)| extent - gradient.dot(corner))
        });
        let (low, high) = rests.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rest| {
            (low.min(rest), high.max(rest))
        });
        let vertices = part.iter().flat_map(|&tet| field.mesh().tets()[tet]);
        let around = vertices.fold(gradients, |all, vertex| all.union(&around[vertex]));
        Self {
            center: bounds.center(),
            half: bounds.half_extents(),
            mean: AffineField {
                gradient,
                offset: 0.5 * (low + high),
            },
            error: 0.5 * (high - low),
            spread: gradients.half_extents(),
            gradient_around: around.center(),
            spread_around: around.half_extents(),
            sensitivity: tets().map(|tet| tet.sensitivity).fold(0.0, f64::max),
        }
    }

    /// Returns the bounds in one tetrahedron of the set. The bounds of the gradients around the set
    /// are kept.
    #[inline]
    pub fn narrowed_to(&self, tet: &FieldTet) -> Self {
        let bounds = tet.tetrahedron.aabb();
        Self {
            center: bounds.center(),
            half: bounds.half_extents(),
            mean: tet.extent,
            error: 0.0,
            spread: Vector3::zeros(),
            sensitivity: tet.sensitivity,
            ..*self
        }
    }
}
