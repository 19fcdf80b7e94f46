use super::escapes::escapes;
use super::positivity::check_positive_inside;
use super::{Escape, FieldBounds, NotFollowed};
use crate::bvh::{Bvh, PerNode};
use crate::mesh::PressureField;

/// Where a component of a contact surface without a rim can be entered. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// Edges of which such a component crosses one, of either body, if both have them.
    pub escapes: Option<Bvh<Escape>>,
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
