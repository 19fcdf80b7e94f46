use super::flat_tree::FlatTree;
use super::{NotFollowed, Seeds, TetTree, TriangleTree};
use crate::mesh::PressureField;
use crate::threads;
use std::fmt;
use std::sync::OnceLock;

/// What a body is made of for contact: a pressure field and the trees over its tetrahedra.
///
/// A shape has no pose and no modulus; any number of bodies may share one.
#[derive(Clone)]
pub struct Shape {
    field: PressureField,
    tree: TetTree,
    triangle_tree: TriangleTree,
    seeds: Result<Seeds, NotFollowed>,
    /// Over the tetrahedra that press, without inert ones. Made when the shape meets its first half-space: few do.
    flat_tree: OnceLock<FlatTree>,
}

impl Shape {
    /// Builds the trees over the field's tetrahedra and surface. One more is built as soon as the shape meets a half-space.
    #[must_use]
    pub fn new(field: PressureField) -> Self {
        let (tree, (triangle_tree, seeds)) = threads::both(
            || TetTree::new(&field),
            || threads::both(|| TriangleTree::of(&field), || Seeds::of(&field)),
        );
        Self {
            field,
            tree,
            triangle_tree,
            seeds,
            flat_tree: OnceLock::new(),
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

    /// The tree over the triangles of its surface.
    pub(crate) fn triangle_tree(&self) -> &TriangleTree {
        &self.triangle_tree
    }

    /// The tree over the tetrahedra that planes are held against; without inert ones.
    pub(crate) fn flat_tree(&self) -> &FlatTree {
        self.flat_tree.get().unwrap_or_else(|| {
            let tets = (0_u32..).zip(self.field.tets());
            let pressing = tets.filter(|(_, tet)| !tet.is_inert());
            let tree = FlatTree::new(pressing.map(|(index, tet)| (index, tet.tetrahedron)));
            // Built outside the lock, because a child process that is forked while the lock is held would wait for it forever.
            self.flat_tree.get_or_init(|| tree)
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
