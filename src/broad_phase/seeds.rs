use super::box_tree::BoxTree;
use super::positivity::check_positive_inside;
use super::{Escape, FieldTree, Landscape, NotFollowed};
use crate::geometry::{Aabb, FACES};
use crate::mesh::{FieldTet, PressureField};
use crate::spatial::Pose;

/// The R\*-tree of the triangles of a body's surface, by their boxes in the body frame. The rim of a component of a contact
/// surface is where triangles of both bodies cross.
#[derive(Debug, Clone)]
pub(crate) struct TriangleTree(BoxTree<SurfaceFace>);

/// Where a component of a contact surface without a rim can be entered. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// What such a component cannot avoid, where the field rises to few peaks.
    pub ridges: Option<Ridges>,
    /// Bounds of the field's values and slopes, from which follows where such a component may turn.
    pub slopes: FieldTree,
}

/// What a component without a rim cannot avoid (see [`Landscape`]), if both bodies have it. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Ridges {
    creased: BoxTree<usize>,
    escapes: BoxTree<Escape>,
}

/// A triangle of the surface, as a face of its tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SurfaceFace {
    tet: u32,
    face: u8,
}

impl SurfaceFace {
    /// A face of a tetrahedron, by its opposite corner, and the box around it.
    fn of(index: u32, face: u8, tet: &FieldTet) -> (Self, Aabb) {
        let corners = FACES[usize::from(face)].map(|corner| tet.tetrahedron.corners[corner]);
        (Self { tet: index, face }, Aabb::around(&corners))
    }

    /// The tetrahedron.
    pub fn tet(self) -> usize {
        self.tet as usize
    }

    /// The corner of the tetrahedron opposite to it.
    pub fn face(self) -> usize {
        self.face.into()
    }
}

impl TriangleTree {
    /// Of a compliant body: the faces of its tetrahedra that have no neighbor.
    pub fn of(field: &PressureField) -> Self {
        let faces = (0_u32..).zip(field.tets()).flat_map(|(index, tet)| {
            let is_surface = move |face: &u8| {
                field
                    .mesh()
                    .neighbor(index as usize, (*face).into())
                    .is_none()
            };
            (0_u8..4)
                .filter(is_surface)
                .map(move |face| SurfaceFace::of(index, face, tet))
        });
        Self(BoxTree::new(faces))
    }

    /// Of a rigid body, from the cells behind its triangles: each triangle is face 3 of its cell.
    pub fn of_cells(cells: &[FieldTet]) -> Self {
        let faces = (0_u32..).zip(cells);
        Self(BoxTree::new(
            faces.map(|(index, cell)| SurfaceFace::of(index, 3, cell)),
        ))
    }

    /// Visits the pairs of triangles, of this surface (in A) and the other (in B), whose boxes may overlap: that no face of
    /// either separates by more than `margin` (m).
    pub fn visit_pairs(
        &self,
        other: &Self,
        pose_ab: &Pose<f64>,
        margin: f64,
        visit: impl FnMut(SurfaceFace, SurfaceFace),
    ) {
        self.0.visit_pairs(&other.0, pose_ab, margin, visit);
    }

    /// Visits the tetrahedra or triangles (of B) with a triangle of the surface that may overlap the box `region` in A.
    pub fn visit_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(usize),
    ) {
        self.0
            .visit_near(region, pose_ab, margin, |face| visit(face.tet()));
    }
}

impl Seeds {
    /// Of a field that is positive inside.
    pub fn of(field: &PressureField) -> Result<Self, NotFollowed> {
        check_positive_inside(field)?;
        Ok(Self {
            ridges: Ridges::of(field),
            slopes: FieldTree::new(field),
        })
    }
}

impl Ridges {
    fn of(field: &PressureField) -> Option<Self> {
        let (landscape, tets) = (Landscape::of(field)?, field.tets());
        let box_of_escape = |escape: Escape| {
            let corners = &tets[escape.tet].tetrahedron.corners;
            (
                escape,
                Aabb::around(&escape.corners.map(|corner| corners[corner])),
            )
        };
        let creased = landscape.creased.iter();
        Some(Self {
            creased: BoxTree::new(creased.map(|&tet| (tet, tets[tet].tetrahedron.aabb()))),
            escapes: BoxTree::new(landscape.escapes.into_iter().map(box_of_escape)),
        })
    }

    /// Visits the tetrahedra at convex creases (of B) that may overlap the box `region` in A.
    pub fn visit_creased_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        visit: impl FnMut(usize),
    ) {
        self.creased.visit_near(region, pose_ab, margin, visit);
    }

    /// Visits the edges (of B) on the ways from peaks and creases to the surface that may overlap the box
    /// `region` in A.
    pub fn visit_escapes_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        visit: impl FnMut(Escape),
    ) {
        self.escapes.visit_near(region, pose_ab, margin, visit);
    }
}
