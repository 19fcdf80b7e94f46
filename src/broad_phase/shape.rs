use super::{Seeds, TetTree};
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
    seeds: Seeds,
}

impl Shape {
    /// Builds the trees over the field's tetrahedra and surface.
    #[must_use]
    pub fn new(field: PressureField) -> Self {
        let (tree, seeds) = threads::both(|| TetTree::new(&field), || Seeds::of(&field));
        Self { field, tree, seeds }
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

    /// Where contact surfaces can be entered.
    pub(crate) fn seeds(&self) -> &Seeds {
        &self.seeds
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
