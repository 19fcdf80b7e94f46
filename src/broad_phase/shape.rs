use super::{NotFollowed, RimTree, Seeds, TetTree};
use crate::mesh::PressureField;
use crate::threads;
use std::fmt;

/// What a body is made of for contact: a pressure field and the R\*-trees over its tetrahedra.
///
/// A shape has no pose and no modulus; any number of bodies may share one.
#[derive(Clone)]
pub struct Shape {
    field: PressureField,
    tree: TetTree,
    rims: RimTree,
    seeds: Result<Seeds, NotFollowed>,
}

impl Shape {
    /// Builds the trees over the field's tetrahedra and surface.
    #[must_use]
    pub fn new(field: PressureField) -> Self {
        let (tree, (rims, seeds)) = threads::both(
            || TetTree::new(&field),
            || threads::both(|| RimTree::of(&field), || Seeds::of(&field)),
        );
        Self {
            field,
            tree,
            rims,
            seeds,
        }
    }

    /// The pressure field.
    #[must_use]
    pub fn field(&self) -> &PressureField {
        &self.field
    }

    /// The tree over the tetrahedra.
    #[must_use]
    pub fn tree(&self) -> &TetTree {
        &self.tree
    }

    /// The triangles of its surface.
    pub(crate) fn rims(&self) -> &RimTree {
        &self.rims
    }

    /// Whether contact surfaces with this shape are followed from polygon to polygon: if they are with both bodies, the time
    /// of a wrench depends on the number of polygons alone.
    ///
    /// # Errors
    /// Why they are found by culling all tetrahedra instead, as slow as this is.
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
