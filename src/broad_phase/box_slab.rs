//! Parts of a surface in another body's frame, with tests against the four children of a node at
//! once.
//!
//! All tests are comparisons. So zeros of either sign are equal. A slot without a child touches
//! nothing, even if its numbers are NaN.

#![expect(
    clippy::needless_range_loop,
    reason = "adapters of iterators take closures, and a closure over lanes may stay a call, compiled for any processor"
)]

use super::slabs::{BoxesAndSlabs, FourSlabs};
use crate::bvh::{FourBoxes, FourCorners, WIDTH, four_bits};
use crate::geometry::Aabb;
use crate::lanes::space::{dot, splat};
use crate::lanes::{Lanes, Numbers, Quad};
use crate::spatial::Pose;
use nalgebra::{Matrix3, Vector3};

/// The pose of B, the margin (m), and the box around A's surface.
pub(super) struct RelativePose {
    rotation: [[f64; 3]; 3],
    /// Absolute values |Rᵢⱼ|. They map the half extents of a box of B to the half extents of its
    /// bounding box in A.
    reach: [[f64; 3]; 3],
    translation: [f64; 3],
    margin: f64,
    around_a: Aabb,
}

/// A part of a surface in A's frame: a child of a node of B, or one triangle of either body.
pub(super) struct BoxSlab {
    bounds: [[f64; 2]; 3],
    normal: [f64; 3],
    between: [f64; 2],
}

/// A part of a surface, repeated in all lanes.
pub(super) struct BoxSlabInLanes<N> {
    lower: [N; 3],
    upper: [N; 3],
    pub normal: [N; 3],
    pub between: [N; 2],
    /// For each axis, the side of a box that is farther back along the normal: 0 for the lower
    /// side, 1 for the upper.
    back: [usize; 3],
}

impl RelativePose {
    pub fn new(around_a: Aabb, pose_ab: &Pose<f64>, margin: f64) -> Self {
        let rows = |matrix: &Matrix3<f64>| {
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]))
        };
        Self {
            rotation: rows(pose_ab.rotation()),
            reach: rows(&pose_ab.rotation().abs()),
            translation: (*pose_ab.translation()).into(),
            margin,
            around_a,
        }
    }

    /// Transforms a node of B to A's frame, with boxes along A's axes. Also returns which children
    /// have boxes that overlap the box around A's surface, one bit each.
    #[inline(always)]
    pub fn posed<L: Lanes>(&self, lanes: L, node: BoxesAndSlabs) -> (FourBoxes, FourSlabs, u32) {
        let (mut boxes, mut slabs, mut near) = (FourBoxes::EMPTY, FourSlabs::EMPTY, 0);
        let (half, margin) = (lanes.splat(0.5), lanes.splat(self.margin));
        for first in (0..WIDTH).step_by(L::COUNT) {
            let load = |quad: &Quad| lanes.load_four(quad, first);
            let (mut middles, mut halves, mut normal) = ([half; 3], [half; 3], [half; 3]);
            for axis in 0..3 {
                let [lower, upper] = &node.boxes.0[axis];
                middles[axis] = (load(lower) + load(upper)) * half;
                halves[axis] = (load(upper) - load(lower)) * half;
            }
            let normal_b = [
                load(&node.slabs.normal[0]),
                load(&node.slabs.normal[1]),
                load(&node.slabs.normal[2]),
            ];
            let mut overlap = half.is_at_most(half);
            for axis in 0..3 {
                let middle = dot(splat(lanes, &self.rotation[axis]), middles)
                    + lanes.splat(self.translation[axis]);
                let reach = dot(splat(lanes, &self.reach[axis]), halves) + margin;
                let (lower, upper) = (middle - reach, middle + reach);
                let lower_a = lanes.splat(self.around_a.lower[axis]);
                let upper_a = lanes.splat(self.around_a.upper[axis]);
                overlap = overlap & lower.is_at_most(upper_a) & lower_a.is_at_most(upper);
                lower.store_four(&mut boxes.0[axis][0], first);
                upper.store_four(&mut boxes.0[axis][1], first);
                normal[axis] = dot(splat(lanes, &self.rotation[axis]), normal_b);
                normal[axis].store_four(&mut slabs.normal[axis], first);
            }
            let shift = dot(normal, splat(lanes, &self.translation));
            let [low, high] = &node.slabs.between;
            (load(low) + shift - margin).store_four(&mut slabs.between[0], first);
            (load(high) + shift + margin).store_four(&mut slabs.between[1], first);
            near |= four_bits(overlap, first);
        }
        (boxes, slabs, near)
    }

    /// Transforms the corners of four triangles of B to A's frame. Also returns the boxes around
    /// them along A's axes.
    #[inline(always)]
    pub fn triangles<L: Lanes>(
        &self,
        lanes: L,
        corners: &FourCorners<3>,
    ) -> (FourCorners<3>, FourBoxes) {
        let mut posed = [[[0.0; WIDTH]; 3]; 3];
        let mut boxes = FourBoxes::EMPTY;
        let margin = lanes.splat(self.margin);
        for first in (0..WIDTH).step_by(L::COUNT) {
            let load = |quad: &Quad| lanes.load_four(quad, first);
            for axis in 0..3 {
                let row = splat(lanes, &self.rotation[axis]);
                let shift = lanes.splat(self.translation[axis]);
                let mut along = [shift; 3];
                for corner in 0..3 {
                    let [x, y, z] = &corners[corner];
                    along[corner] = dot(row, [load(x), load(y), load(z)]) + shift;
                    along[corner].store_four(&mut posed[corner][axis], first);
                }
                let [a, b, c] = along;
                (a.min(b).min(c) - margin).store_four(&mut boxes.0[axis][0], first);
                (a.max(b).max(c) + margin).store_four(&mut boxes.0[axis][1], first);
            }
        }
        (posed, boxes)
    }
}

impl BoxSlab {
    /// Creates the patch of a child of a node in A's frame.
    #[inline(always)]
    pub fn of(node: BoxesAndSlabs, slot: usize) -> Self {
        let [[x0, x1], [y0, y1], [z0, z1]] = &node.boxes.0;
        let [n1, n2, n3] = &node.slabs.normal;
        let [low, high] = &node.slabs.between;
        Self {
            bounds: [
                [x0[slot], x1[slot]],
                [y0[slot], y1[slot]],
                [z0[slot], z1[slot]],
            ],
            normal: [n1[slot], n2[slot], n3[slot]],
            between: [low[slot], high[slot]],
        }
    }

    /// Creates the patch of a triangle of A from the box and the slab of its node. The planes of
    /// the slab are moved outwards by a margin (m).
    #[inline(always)]
    pub fn of_a(node: BoxesAndSlabs, slot: usize, margin: f64) -> Self {
        let patch = Self::of(node, slot);
        let [low, high] = patch.between;
        Self {
            between: [low - margin, high + margin],
            ..patch
        }
    }

    /// Replaces the box by the box around the triangle's corners, inflated by a margin (m).
    pub fn around(self, corners: &[Vector3<f64>; 3], margin: f64) -> Self {
        let aabb = Aabb::around(corners).inflated(margin);
        Self {
            bounds: [0, 1, 2].map(|axis| [aabb.lower[axis], aabb.upper[axis]]),
            ..self
        }
    }

    #[inline(always)]
    pub fn in_lanes<L: Lanes>(&self, lanes: L) -> BoxSlabInLanes<L::Numbers> {
        let [[x0, x1], [y0, y1], [z0, z1]] = self.bounds;
        let [n1, n2, n3] = self.normal;
        BoxSlabInLanes {
            lower: splat(lanes, &[x0, y0, z0]),
            upper: splat(lanes, &[x1, y1, z1]),
            normal: splat(lanes, &self.normal),
            between: [lanes.splat(self.between[0]), lanes.splat(self.between[1])],
            back: [
                usize::from(n1 < 0.0),
                usize::from(n2 < 0.0),
                usize::from(n3 < 0.0),
            ],
        }
    }
}

impl<N: Numbers> BoxSlabInLanes<N> {
    /// Returns the children of a node of A that the patch may touch, one bit each. Their boxes
    /// overlap the box of the patch and are not outside its slab. The slabs of A's nodes are not
    /// tested, because the test costs more than it saves.
    #[inline(always)]
    pub fn touched<L: Lanes<Numbers = N>>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let [x, y, z] = &boxes.0;
        let [back_x, back_y, back_z] = self.back;
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let load = |quad: &Quad| lanes.load_four(quad, first);
            // The corners of the boxes that are farthest back and farthest ahead along the normal.
            let behind = [load(&x[back_x]), load(&y[back_y]), load(&z[back_z])];
            let ahead = [
                load(&x[1 - back_x]),
                load(&y[1 - back_y]),
                load(&z[1 - back_z]),
            ];
            let [low, high] = self.between;
            let cuts =
                dot(self.normal, behind).is_at_most(high) & low.is_at_most(dot(self.normal, ahead));
            let near = boxes.overlapping(lanes, self.sides(), first);
            bits |= four_bits(near & cuts, first);
        }
        bits
    }

    /// Returns the lower and the upper side of the patch's box.
    #[inline(always)]
    pub fn sides(&self) -> [&[N; 3]; 2] {
        [&self.lower, &self.upper]
    }
}
