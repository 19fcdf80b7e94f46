//! Analysis of a pressure field: places where a search can enter a closed component of a contact
//! surface. A component is closed if it has no boundary curve.
//!
//! In concave fields, a closed component crosses a path from a peak to the surface (`peak_paths`). In
//! other fields, the search enters where the component may turn, which follows from bounds of the
//! field ([`FieldBounds`]). Neither method works if the field is zero somewhere inside
//! ([`NotFollowed`]). Everything is in the body frame and is computed once for a shape.

mod field_bounds;
mod peak_paths;
mod positivity;

use crate::bvh::{Bvh, PerNode};
use crate::mesh::PressureField;
pub(crate) use field_bounds::FieldBounds;
pub(crate) use peak_paths::PathEdge;
use peak_paths::peak_paths;
pub use positivity::NotFollowed;
use positivity::check_positive_inside;

/// Data that tell where a search can enter closed components of a contact surface, in the body
/// frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// Edges of paths from peaks to the surface, if the field has such paths. If both bodies have
    /// them, every closed component crosses such an edge of one body.
    pub peak_paths: Option<Bvh<PathEdge>>,
    /// Bounds of the field's values and gradients for each node of the tree of tetrahedra. They
    /// tell where a closed component may turn.
    pub bounds: PerNode<FieldBounds>,
}

impl Seeds {
    /// Analyzes a field, given a tree of its tetrahedra.
    ///
    /// # Errors
    /// If the field is zero somewhere inside.
    pub fn of(field: &PressureField, tets: &Bvh<usize>) -> Result<Self, NotFollowed> {
        check_positive_inside(field)?;
        let ends_of = |edge: PathEdge| {
            let corners = &field.tets()[edge.tet].tetrahedron.corners;
            (edge, edge.corners.map(|corner| corners[corner]))
        };
        let peak_paths = peak_paths(field);
        Ok(Self {
            peak_paths: peak_paths.map(|edges| Bvh::new(edges.into_iter().map(ends_of))),
            bounds: FieldBounds::of_nodes(field, tets),
        })
    }
}
