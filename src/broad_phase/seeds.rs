use super::positivity::check_positive_inside;
use super::{Escape, FieldBounds, Landscape, NotFollowed};
use crate::bvh::{Bvh, PerNode};
use crate::mesh::PressureField;

/// Where a component of a contact surface without a rim can be entered. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// What such a component cannot avoid, where the field rises to few peaks.
    pub ridges: Option<Ridges>,
    /// Bounds of the field's values and slopes for each node of the tree of tetrahedra, from which follows where such a
    /// component may turn.
    pub bounds: PerNode<FieldBounds>,
}

/// What a component without a rim cannot avoid (see [`Landscape`]), if both bodies have it. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Ridges {
    /// The tetrahedra at convex creases.
    pub creased: Bvh<usize>,
    /// The edges on the ways from peaks and creases to the surface.
    pub escapes: Bvh<Escape>,
}

impl Seeds {
    /// Of a field that is positive inside, with a tree of its tetrahedra.
    pub fn of(field: &PressureField, tets: &Bvh<usize>) -> Result<Self, NotFollowed> {
        check_positive_inside(field)?;
        Ok(Self {
            ridges: Ridges::of(field),
            bounds: FieldBounds::of_nodes(field, tets),
        })
    }
}

impl Ridges {
    fn of(field: &PressureField) -> Option<Self> {
        let (landscape, tets) = (Landscape::of(field)?, field.tets());
        let ends_of = |escape: Escape| {
            let corners = &tets[escape.tet].tetrahedron.corners;
            (escape, escape.corners.map(|corner| corners[corner]))
        };
        let creased = landscape.creased.iter();
        Some(Self {
            creased: Bvh::new(creased.map(|&tet| (tet, tets[tet].tetrahedron.corners))),
            escapes: Bvh::new(landscape.escapes.into_iter().map(ends_of)),
        })
    }
}
