//! Crossing test of four triangles with a triangle of the other body.

use super::box_slab::BoxSlab;
use super::slabs::{BoxesAndSlabs, FourSlabs};
use crate::bvh::{FourBoxes, FourCorners, WIDTH, four_bits};
use crate::lanes::space::{dot, splat};
use crate::lanes::{Lanes, Numbers, Quad};
use nalgebra::Vector3;

/// Four triangles of either body in A's frame, as a structure of arrays.
pub(super) struct FourTriangles<'f> {
    corners: &'f FourCorners<3>,
    boxes: &'f FourBoxes,
    normal: &'f [Quad; 3],
    between: [Quad; 2],
}

impl<'f> FourTriangles<'f> {
    /// Creates the triangles of a node of B from their slabs and corners, and the boxes around the
    /// corners in A's frame.
    pub fn of_b(slabs: &'f FourSlabs, (corners, boxes): &'f (FourCorners<3>, FourBoxes)) -> Self {
        Self {
            corners,
            boxes,
            normal: &slabs.normal,
            between: slabs.between,
        }
    }

    /// Creates the triangles of a node of A. The planes of each slab are moved outwards by a margin
    /// (m).
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

    /// Returns which of the four triangles a triangle of the other body may cross, one bit each.
    /// The boxes of such triangles overlap, and neither triangle is entirely on one side of the
    /// plane of the other.
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
            let corner_distance =
                |corner: usize| dot(box_slab.normal, vector(&self.corners[corner]));
            let distances = [corner_distance(0), corner_distance(1), corner_distance(2)];
            let cuts = reach_into(distances, box_slab.between);
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

/// Returns whether the range of three numbers overlaps a given range.
#[inline(always)]
fn reach_into<N: Numbers>([a, b, c]: [N; 3], [low, high]: [N; 2]) -> N::Mask {
    a.min(b).min(c).is_at_most(high) & low.is_at_most(a.max(b).max(c))
}
