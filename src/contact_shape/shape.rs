use crate::broad_phase::{Projections, RStarTree, TetBvh, TriangleBvh};
use crate::geometry::Aabb;
use crate::mesh::PressureField;
use crate::parallel;
use crate::seeds::{NotFollowed, Seeds};
use nalgebra::Vector3;
use std::fmt;
use std::sync::OnceLock;

/// The shape of a compliant body: a pressure field and the search trees over its tetrahedra.
///
/// A shape has no pose and no modulus, so several bodies may share one.
#[derive(Clone)]
pub struct Shape {
    field: PressureField,
    bounds: Aabb,
    tet_bvh: TetBvh,
    triangle_bvh: TriangleBvh,
    projections: Vec<Projections>,
    seeds: Result<Seeds, NotFollowed>,
    /// The R\*-tree for culling, built on first use because few shapes need it.
    r_star_tree: OnceLock<RStarTree>,
}

impl Shape {
    /// Builds the search trees over the field's tetrahedra and surface. The R\*-tree is built when
    /// [`Culling`](crate::contact::Culling) first needs it.
    #[must_use]
    pub fn new(field: PressureField) -> Self {
        let tets = field.tets();
        let ((tet_bvh, seeds), (triangle_bvh, projections)) = parallel::both(
            || {
                let tet_bvh = TetBvh::of(&field);
                let seeds = Seeds::of(&field, tet_bvh.pressing());
                (tet_bvh, seeds)
            },
            || {
                let projections = |tet: usize| Projections::of(&tets[tet].tetrahedron);
                let of_tets = || parallel::values_of(tets.len(), projections);
                parallel::both(|| TriangleBvh::of(&field), of_tets)
            },
        );
        Self {
            bounds: field.mesh().aabb(),
            field,
            tet_bvh,
            triangle_bvh,
            projections,
            seeds,
            r_star_tree: OnceLock::new(),
        }
    }

    /// Returns the pressure field.
    #[must_use]
    pub fn field(&self) -> &PressureField {
        &self.field
    }

    /// Returns the bounding box of all tetrahedra in the body frame (m).
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the bounding-volume hierarchy over the tetrahedra.
    pub(crate) fn tet_bvh(&self) -> &TetBvh {
        &self.tet_bvh
    }

    /// Returns the bounding-volume hierarchy over the triangles of the surface.
    pub(crate) fn triangle_bvh(&self) -> &TriangleBvh {
        &self.triangle_bvh
    }

    /// Returns the projections of a tetrahedron, in the body frame.
    pub(crate) fn projections(&self, tet: usize) -> &Projections {
        &self.projections[tet]
    }

    /// Returns the R\*-tree of the tetrahedra, for culling.
    pub(crate) fn r_star_tree(&self) -> &RStarTree {
        self.r_star_tree.get().unwrap_or_else(|| {
            let tree = RStarTree::new(&self.field);
            // The tree is built outside the lock. A child process forked while the lock is held would wait for it
            // forever.
            self.r_star_tree.get_or_init(|| tree)
        })
    }

    /// Returns a tetrahedron that contains a point of the body frame, or `None` if the point is outside.
    pub(crate) fn tet_at(&self, point: &Vector3<f64>) -> Option<usize> {
        let (tets, mut tet_at) = (self.field.tets(), None);
        self.tet_bvh.visit_at(point, 0.0, |tet| {
            let mut coordinates = tets[tet].barycentric.iter();
            if coordinates.all(|coordinate| coordinate.at(point) >= 0.0) {
                tet_at = Some(tet);
            }
        });
        tet_at
    }

    /// Checks that contact surfaces with this shape can be followed from polygon to polygon.
    ///
    /// If both shapes of a pair can be followed, the time for a wrench depends on the number of polygons and hardly on
    /// the number of tetrahedra.
    ///
    /// # Errors
    /// Returns the reason why contact surfaces cannot be followed. They are then found by culling all tetrahedra, which
    /// takes more time but gives the same surfaces.
    pub fn followed(&self) -> Result<(), NotFollowed> {
        self.seeds.as_ref().map(|_| ()).map_err(|&reason| reason)
    }

    /// Returns the seeds of closed components of a contact surface, if they are sure to find all components.
    pub(crate) fn seeds(&self) -> Option<&Seeds> {
        self.seeds.as_ref().ok()
    }
}

impl fmt::Debug for Shape {
    /// Prints the number of tetrahedra in place of the long mesh.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tets = self.field.tets().len();
        formatter
            .debug_struct("Shape")
            .field("tets", &tets)
            .finish_non_exhaustive()
    }
}
