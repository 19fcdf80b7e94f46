use crate::geometry::Aabb;
use crate::lanes::{Lanes, Mask, Numbers, Quad};
use nalgebra::Vector3;
use std::array::from_fn;

/// Children of a node, at most.
pub(crate) const WIDTH: usize = 4;

/// The boxes of the children of a node, side by side: along each axis, the smallest coordinates (m) and the largest. The box of a
/// missing child is inside out.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(crate) struct FourBoxes(pub [[Quad; 2]; 3]);

/// The corners (m) of four items, by corner and coordinate; the last item again where there are fewer.
pub(crate) type FourCorners<const N: usize> = [[Quad; 3]; N];

impl FourBoxes {
    /// No children.
    pub const EMPTY: Self = Self([[[f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]]; 3]);

    /// Up to four boxes.
    pub fn of(boxes: &[Aabb]) -> Self {
        let mut four = Self::EMPTY;
        for (slot, aabb) in boxes.iter().enumerate() {
            for (axis, [lower, upper]) in four.0.iter_mut().enumerate() {
                (lower[slot], upper[slot]) = (aabb.lower[axis], aabb.upper[axis]);
            }
        }
        four
    }

    /// The box of a child.
    #[inline]
    pub fn aabb(&self, slot: usize) -> Aabb {
        let side = |side: usize| Vector3::from_fn(|axis, _| self.0[axis][side][slot]);
        Aabb {
            lower: side(0),
            upper: side(1),
        }
    }

    /// The box around all children.
    pub fn union(&self) -> Aabb {
        let boxes = (0..WIDTH).map(|slot| self.aabb(slot));
        boxes.fold(Aabb::around([]), |all, aabb| all.union(&aabb))
    }

    /// Whether a box, the same in all lanes, overlaps those of the children from `first` on.
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

/// The bits of four lanes from `first` on. Eight lanes have each bit twice.
#[inline(always)]
pub(crate) fn four_bits<N>(mask: impl Mask<N>, first: usize) -> u32 {
    mask.bits() << first & ((1 << WIDTH) - 1)
}

/// The corners of up to four items.
pub(crate) fn side_by_side<const N: usize>(items: &[[Vector3<f64>; N]]) -> FourCorners<N> {
    let last = items.len() - 1;
    from_fn(|corner| from_fn(|axis| from_fn(|slot| items[slot.min(last)][corner][axis])))
}
