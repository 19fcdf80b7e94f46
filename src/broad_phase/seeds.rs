use super::box_tree::BoxTree;
use super::{Escape, Landscape};
use crate::geometry::{Aabb, FACES};
use crate::mesh::{FieldTet, PressureField};
use crate::spatial::Pose;

/// Where more than one in so many tetrahedra are at convex creases, contact surfaces are not followed.
const MOST_CREASED: usize = 3;

/// Where every component of a contact surface shows, in the body frame.
#[derive(Debug, Clone)]
pub(crate) struct Seeds {
    /// The triangles of the body's surface, where the rim of a component lies.
    surface: BoxTree<SurfaceFace>,
    /// What a component without a rim cannot avoid.
    rimless: Option<RimlessSeeds>,
}

/// What a component without a rim cannot avoid (see [`Landscape`]).
#[derive(Debug, Clone)]
pub(crate) struct RimlessSeeds {
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
    /// With its box.
    fn of(index: u32, face: u8, tet: &FieldTet) -> (Self, Aabb) {
        let corners = FACES[usize::from(face)].map(|corner| tet.tetrahedron.corners[corner]);
        (Self { tet: index, face }, Aabb::around(&corners))
    }

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
    pub fn of(field: &PressureField) -> Self {
        let tets = field.tets();
        let faces = (0_u32..).zip(tets).flat_map(|(index, tet)| {
            let is_surface = move |face: &u8| {
                field
                    .mesh()
                    .neighbour(index as usize, (*face).into())
                    .is_none()
            };
            (0_u8..4)
                .filter(is_surface)
                .map(move |face| SurfaceFace::of(index, face, tet))
        });
        Self {
            surface: BoxTree::new(faces),
            rimless: RimlessSeeds::of(field),
        }
    }

    /// Of a rigid body, from the cells behind its triangles and one triangle of each connected part of its surface.
    pub fn of_rigid(cells: &[FieldTet], starts: &[usize]) -> Self {
        let faces = (0_u32..).zip(cells);
        let starts = starts.iter();
        Self {
            surface: BoxTree::new(faces.map(|(index, cell)| SurfaceFace::of(index, 3, cell))),
            rimless: Some(RimlessSeeds {
                creased: BoxTree::new(starts.map(|&i| (i, cells[i].tetrahedron.aabb()))),
                escapes: BoxTree::new([]),
            }),
        }
    }

    /// What a component without a rim cannot avoid; `None` for a field in which such a one may show nowhere, or in so many
    /// places that looking for them is no better than looking everywhere.
    pub fn rimless(&self) -> Option<&RimlessSeeds> {
        self.rimless.as_ref()
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

    /// Visits the tetrahedra or triangles (of B) with a triangle of the surface that may overlap the box `region` in A.
    pub fn visit_surface_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(usize),
    ) {
        self.surface
            .visit_near(region, pose_ab, margin, |face| visit(face.tet()));
    }
}

impl RimlessSeeds {
    fn of(field: &PressureField) -> Option<Self> {
        let landscape = Landscape::of(field)?;
        let tets = field.tets();
        if landscape.creased.len() > tets.len() / MOST_CREASED {
            return None;
        }
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
