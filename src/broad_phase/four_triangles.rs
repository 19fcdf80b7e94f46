//! Four triangles of a surface side by side, and which of them a triangle of the other body may cross.

use super::box_slab::BoxSlab;
use super::slabs::{BoxesAndSlabs, FourSlabs};
use crate::bvh::{FourBoxes, FourCorners, WIDTH, four_bits};
use crate::lanes::space::{dot, splat};
use crate::lanes::{Lanes, Numbers, Quad};
use nalgebra::Vector3;

/// Four triangles in A's frame, side by side: of either body.
pub(super) struct FourTriangles<'f> {
    corners: &'f FourCorners<3>,
    boxes: &'f FourBoxes,
    normal: &'f [Quad; 3],
    between: [Quad; 2],
}

impl<'f> FourTriangles<'f> {
    /// Those of a node of B, given their slabs, corners and the boxes around these in A's frame.
    pub fn of_b(slabs: &'f FourSlabs, (corners, boxes): &'f (FourCorners<3>, FourBoxes)) -> Self {
        Self {
            corners,
            boxes,
            normal: &slabs.normal,
            between: slabs.between,
        }
    }

    /// Those of a node of A, with planes a margin (m) further apart.
    #[inline(always)]
    pub fn of_a(node: BoxesAndSlabs<'f>, corners: &'f FourCorners<3>, margin: f64) -> Self {
        let [mut low, mut high] = node.slabs.between;
        for slot in 0..WIDTH {
            low[slot] -= margin;
            high[slot] += margin;
        }
        Self {
            corners,
            boxes: node.boxes,
            normal: &node.slabs.normal,
            between: [low, high],
        }
    }

    /// Which of them a triangle of the other body may cross, as bits: those whose boxes overlap and of which neither is
    /// beside the other's plane.
    #[inline(always)]
    pub fn crossed<L: Lanes>(
        &self,
        lanes: L,
        box_slab: &BoxSlab,
        corners: &[Vector3<f64>; 3],
    ) -> u32 {
        let box_slab = box_slab.in_lanes(lanes);
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let load = |quad: &Quad| lanes.load_four(quad, first);
            let vector = |[x, y, z]: &[Quad; 3]| [load(x), load(y), load(z)];
            let own_corner = |corner: usize| dot(box_slab.normal, vector(&self.corners[corner]));
            let own = [own_corner(0), own_corner(1), own_corner(2)];
            let cuts = reach_into(own, box_slab.between);
            let normal = vector(self.normal);
            let corner = |corner: usize| dot(normal, splat(lanes, corners[corner].as_ref()));
            let [low, high] = &self.between;
            let is_cut = reach_into([corner(0), corner(1), corner(2)], [load(low), load(high)]);
            let near = self.boxes.overlapping(lanes, box_slab.sides(), first);
            bits |= four_bits(near & cuts & is_cut, first);
        }
        bits
    }
}

/// Whether three numbers are not all below a range, nor all above.
#[inline(always)]
fn reach_into<N: Numbers>([a, b, c]: [N; 3], [low, high]: [N; 2]) -> N::Mask {
    a.min(b).min(c).is_at_most(high) & low.is_at_most(a.max(b).max(c))
}
