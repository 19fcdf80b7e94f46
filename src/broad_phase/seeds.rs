use super::box_tree::BoxTree;
use super::positivity::check_positive_inside;
use super::{Escape, FieldTree, Landscape, NotFollowed};
use crate::geometry::{Aabb, FACES};
use crate::mesh::PressureField;
use crate::spatial::Pose;

/// Where every component of a contact surface shows: the triangles of a body's surface, where its rim
/// lies, and what a component without a rim cannot avoid. In the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    surface: BoxTree<SurfaceFace>,
    /// Where the field rises to few peaks.
    pub ridges: Option<Ridges>,
    /// Where it slopes which way.
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
    /// The tetrahedron.
    pub fn tet(self) -> usize {
        self.tet as usize
    }

    /// The corner opposite.
    pub fn face(self) -> usize {
        self.face.into()
    }
}

impl Seeds {
    /// Of a field that is positive inside.
    pub fn of(field: &PressureField) -> Result<Self, NotFollowed> {
        check_positive_inside(field)?;
        let tets = field.tets();
        let faces = (0_u32..).zip(tets).flat_map(|(index, tet)| {
            let is_surface = move |face: &u8| {
                field
                    .mesh()
                    .neighbour(index as usize, (*face).into())
                    .is_none()
            };
            (0_u8..4).filter(is_surface).map(move |face| {
                let corners =
                    FACES[usize::from(face)].map(|corner| tet.tetrahedron.corners[corner]);
                (SurfaceFace { tet: index, face }, Aabb::around(&corners))
            })
        });
        Ok(Self {
            surface: BoxTree::new(faces),
            ridges: Ridges::of(field),
            slopes: FieldTree::new(field),
        })
    }

    /// Visits the pairs of triangles of both surfaces, this one's in A and the other's in B, whose boxes
    /// overlap.
    pub fn visit_surface_pairs(
        &self,
        other: &Self,
        pose_ab: &Pose<f64>,
        margin: f64,
        visit: impl FnMut(SurfaceFace, SurfaceFace),
    ) {
        self.surface
            .visit_pairs(&other.surface, pose_ab, margin, visit);
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
