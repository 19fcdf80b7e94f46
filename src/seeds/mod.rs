//! Analysis of a pressure field: places where a search can enter a closed component of a contact
//! surface. A component is closed if it has no boundary curve.
//!
//! In concave fields, a closed component crosses a path from a peak to the surface (`escapes`). In
//! other fields, the search enters where the component may turn, which follows from bounds of the
//! field ([`FieldBounds`]). Neither method works if the field is zero somewhere inside
//! ([`NotFollowed`]). Everything is in the body frame and is computed once for a shape.

mod escapes;
mod field_bounds;
mod positivity;

use crate::bvh::{Bvh, PerNode};
use crate::mesh::PressureField;
pub(crate) use escapes::Escape;
use escapes::escapes;
pub(crate) use field_bounds::FieldBounds;
pub use positivity::NotFollowed;
use positivity::check_positive_inside;

/// Data that tell where a search can enter closed components of a contact surface, in the body
/// frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// Edges of paths from peaks to the surface, if the field has such paths. If both bodies have
    /// them, every closed component crosses such an edge of one body.
    pub escapes: Option<Bvh<Escape>>,
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
        let ends_of = |escape: Escape| {
            let corners = &field.tets()[escape.tet].tetrahedron.corners;
            (escape, escape.corners.map(|corner| corners[corner]))
        };
        let escapes = escapes(field);
        Ok(Self {
            escapes: escapes.map(|edges| Bvh::new(edges.into_iter().map(ends_of))),
            bounds: FieldBounds::of_nodes(field, tets),
        })
    }
}
