use crate::geometry::Aabb;
use crate::lanes::{Lanes, Mask, Numbers, Quad};
use nalgebra::Vector3;
use std::array::from_fn;

/// Maximum number of children of a node.
pub(crate) const WIDTH: usize = 4;

/// Boxes of the children of a node, as a structure of arrays. For each axis, the arrays hold the
/// smallest coordinates (m) and the largest. The box of a missing child is inverted.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(crate) struct FourBoxes(pub [[Quad; 2]; 3]);

/// Corners (m) of four items, indexed by corner, coordinate and item. If there are fewer items, the
/// last item is repeated.
pub(crate) type FourCorners<const N: usize> = [[Quad; 3]; N];

impl FourBoxes {
    /// Boxes of a node without children.
    pub const EMPTY: Self = Self([[[f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]]; 3]);

    /// Creates the boxes of up to four children.
    pub fn of(boxes: &[Aabb]) -> Self {
        let mut four = Self::EMPTY;
        for (slot, aabb) in boxes.iter().enumerate() {
            for (axis, [lower, upper]) in four.0.iter_mut().enumerate() {
                (lower[slot], upper[slot]) = (aabb.lower[axis], aabb.upper[axis]);
            }
        }
        four
    }

    /// Returns the box of a child.
    #[inline]
    pub fn aabb(&self, slot: usize) -> Aabb {
        let side = |side: usize| Vector3::from_fn(|axis, _| self.0[axis][side][slot]);
        Aabb {
            lower: side(0),
            upper: side(1),
        }
    }

    /// Returns the smallest box that contains all children.
    pub fn union(&self) -> Aabb {
        let boxes = (0..WIDTH).map(|slot| self.aabb(slot));
        boxes.fold(Aabb::around([]), |all, aabb| all.union(&aabb))
    }

    /// Returns which children, beginning with child `first`, overlap a box. The box is the same in
    /// all lanes.
    #[inline(always)]
    pub fn overlapping<L: Lanes>(
        &self,
        lanes: L,
        [lower, upper]: [&[L::Numbers; 3]; 2],
        first: usize,
    ) -> <L::Numbers as Numbers>::Mask {
        let along = |axis: usize| {
            let [lower_sides, upper_sides] = &self.0[axis];
            lanes.load_four(lower_sides, first).is_at_most(upper[axis])
                & lower[axis].is_at_most(lanes.load_four(upper_sides, first))
        };
        along(0) & along(1) & along(2)
    }
}

/// Converts a mask of children, beginning with child `first`, to one bit for each child. With eight
/// lanes, each child occurs twice. The copies are dropped.
#[inline(always)]
pub(crate) fn four_bits<N>(mask: impl Mask<N>, first: usize) -> u32 {
    mask.bits() << first & ((1 << WIDTH) - 1)
}

/// Arranges the corners of up to four items as a structure of arrays.
pub(crate) fn side_by_side<const N: usize>(items: &[[Vector3<f64>; N]]) -> FourCorners<N> {
    let last = items.len() - 1;
    from_fn(|corner| from_fn(|axis| from_fn(|slot| items[slot.min(last)][corner][axis])))
}
