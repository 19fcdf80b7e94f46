//! Analysis of a pressure field: where the search can enter a component of a contact surface that has no boundary.
//!
//! In concave fields it is on the way from a peak to the surface (`peak_paths`); in others, where the component may turn, which follows from
//! bounds of the field ([`FieldBounds`]). Neither holds if the field is zero somewhere inside ([`NotFollowed`]). Everything is in the
//! body frame and is computed once for a shape.

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

/// Where a component of a contact surface without a boundary can be entered. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// Edges of which such a component crosses one, of either body, if both have them.
    pub peak_paths: Option<Bvh<PathEdge>>,
    /// Bounds of the field's values and slopes for each node of the tree of tetrahedra, from which follows where such a
    /// component may turn.
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
