//! Bounding volumes of parts of a surface: a box and a slab. Around a patch of a smooth surface,
//! the slab is much thinner than the box.

use crate::bvh::{FourBoxes, WIDTH};
use crate::lanes::Quad;

/// Slabs that contain the triangles below each child of a node, as a structure of arrays.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(super) struct FourSlabs {
    /// Unit normals of the slabs: the normalized sums of the triangles' area vectors. Zero if the
    /// area vectors cancel.
    pub normal: [Quad; 3],
    /// Smallest and largest values of normal · x (m).
    pub between: [Quad; 2],
}

/// Boxes and slabs of the children of each node of a level.
pub(super) struct Level<'n> {
    pub boxes: &'n [FourBoxes],
    pub slabs: &'n [FourSlabs],
}

/// Boxes and slabs of the children of one node.
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
    /// Slabs of a node without children.
    pub const EMPTY: Self = Self {
        normal: [[0.0; WIDTH]; 3],
        between: [[f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]],
    };
}
