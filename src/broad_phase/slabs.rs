//! Bounding volumes of parts of a surface: a box and a slab, which around a patch of a smooth surface is much thinner.

use crate::bvh::{FourBoxes, WIDTH};
use crate::lanes::Quad;

/// The slabs that hold the triangles below each child of a node, side by side.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(super) struct FourSlabs {
    /// Unit normals of the slabs: the mean of those of the triangles. Zero if these cancel.
    pub normal: [Quad; 3],
    /// The smallest values of normal · x (m) and the largest.
    pub between: [Quad; 2],
}

/// The boxes and slabs of a level of a tree, for each node those of its children.
pub(super) struct Level<'n> {
    pub boxes: &'n [FourBoxes],
    pub slabs: &'n [FourSlabs],
}

/// The boxes and slabs of the children of a node.
#[derive(Clone, Copy)]
pub(super) struct BoxesAndSlabs<'n> {
    pub boxes: &'n FourBoxes,
    pub slabs: &'n FourSlabs,
}

impl<'n> Level<'n> {
    #[inline(always)]
    pub fn node(&self, index: usize) -> BoxesAndSlabs<'n> {
        BoxesAndSlabs {
            boxes: &self.boxes[index],
            slabs: &self.slabs[index],
        }
    }
}

impl FourSlabs {
    /// No children.
    pub const EMPTY: Self = Self {
        normal: [[0.0; WIDTH]; 3],
        between: [[f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]],
    };
}
