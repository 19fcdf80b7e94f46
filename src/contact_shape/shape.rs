use crate::broad_phase::{Projections, RStarTree, TetBvh, TriangleBvh};
use crate::geometry::Aabb;
use crate::mesh::PressureField;
use crate::seeds::{NotFollowed, Seeds};
use crate::threads;
use std::fmt;
use std::sync::OnceLock;

/// What a body is made of for contact: a pressure field and the trees over its tetrahedra.
///
/// A shape has no pose and no modulus; any number of bodies may share one.
#[derive(Clone)]
pub struct Shape {
    field: PressureField,
    bounds: Aabb,
    tet_bvh: TetBvh,
    triangle_bvh: TriangleBvh,
    projections: Vec<Projections>,
    seeds: Result<Seeds, NotFollowed>,
    /// Built when the shape is first culled by it: few shapes are.
    r_star_tree: OnceLock<RStarTree>,
}

impl Shape {
    /// Builds the trees over the field's tetrahedra and surface. The R\*-tree is built when
    /// [`Culling`](crate::contact::Culling) first needs it.
    #[must_use]
    pub fn new(field: PressureField) -> Self {
        let tets = field.tets();
        let ((tet_bvh, seeds), (triangle_bvh, projections)) = threads::both(
            || {
                let tet_bvh = TetBvh::of(&field);
                let seeds = Seeds::of(&field, tet_bvh.pressing());
                (tet_bvh, seeds)
            },
            || {
                let projections = |tet: usize| Projections::of(&tets[tet].tetrahedron);
                let of_tets = || threads::values_of(tets.len(), projections);
                threads::both(|| TriangleBvh::of(&field), of_tets)
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

    /// The pressure field.
    #[must_use]
    pub fn field(&self) -> &PressureField {
        &self.field
    }

    /// The box around all tetrahedra, in the body frame.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The tree over the tetrahedra.
    pub(crate) fn tet_bvh(&self) -> &TetBvh {
        &self.tet_bvh
    }

    /// The tree over the triangles of its surface.
    pub(crate) fn triangle_bvh(&self) -> &TriangleBvh {
        &self.triangle_bvh
    }

    /// The projections of a tetrahedron, in the body frame.
    pub(crate) fn projections(&self, tet: usize) -> &Projections {
        &self.projections[tet]
    }

    /// The R\*-tree of the tetrahedra, for culling.
    pub(crate) fn r_star_tree(&self) -> &RStarTree {
        self.r_star_tree.get().unwrap_or_else(|| {
            let tree = RStarTree::new(&self.field);
            // Built outside the lock, because a child process that is forked while the lock is held would wait for it forever.
            self.r_star_tree.get_or_init(|| tree)
        })
    }

    /// Checks that contact surfaces with this shape can be followed from polygon to polygon. If they can with both shapes of a
    /// pair, the time that a wrench takes depends on the number of polygons and hardly on that of tetrahedra.
    ///
    /// # Errors
    /// Why not. Contact surfaces with the shape are then found by culling all of its tetrahedra: the same ones, in more time.
    pub fn followed(&self) -> Result<(), NotFollowed> {
        self.seeds.as_ref().map(|_| ()).map_err(|&reason| reason)
    }

    /// Where components of a contact surface without a rim can be entered, if all of them can be found so.
    pub(crate) fn seeds(&self) -> Option<&Seeds> {
        self.seeds.as_ref().ok()
    }
}

impl fmt::Debug for Shape {
    /// The number of tetrahedra stands for the mesh, which would fill pages.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tets = self.field.tets().len();
        formatter
            .debug_struct("Shape")
            .field("tets", &tets)
            .finish_non_exhaustive()
    }
}
