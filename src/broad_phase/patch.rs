//! Parts of a surface in another body's frame, and what they may touch: four at a time, one for each child of a node.
//!
//! Four is the width of the tree, whatever the processor has, so these are not the numbers of `lanes`: `wide` makes them of the
//! instructions that the build may assume.

use super::triangle_tree::Node;
use crate::geometry::Aabb;
use crate::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use wide::f64x4;

/// The pose of B, for four points at once, and the margin.
pub(super) struct Frame {
    rotation: [[f64x4; 3]; 3],
    /// |R|, entry by entry, which takes half the edges of a box of B to those of the box around it in A.
    reach: [[f64x4; 3]; 3],
    translation: [f64x4; 3],
    margin: f64x4,
}

/// A part of a surface in A's frame: a child of a node of B, or one triangle of either body.
pub(super) struct Patch {
    bounds: [[f64; 2]; 3],
    normal: [f64; 3],
    between: [f64; 2],
}

/// Four triangles in A's frame, side by side: of either body.
pub(super) struct FourTriangles {
    corners: [[f64x4; 3]; 3],
    bounds: [[f64x4; 2]; 3],
    normal: [f64x4; 3],
    between: [f64x4; 2],
}

impl Frame {
    pub fn new(pose_ab: &Pose<f64>, margin: f64) -> Self {
        let rows = |matrix: &Matrix3<f64>| {
            [0, 1, 2].map(|row| splat([0, 1, 2].map(|column| matrix[(row, column)])))
        };
        Self {
            rotation: rows(pose_ab.rotation()),
            reach: rows(&pose_ab.rotation().abs()),
            translation: splat((*pose_ab.translation()).into()),
            margin: f64x4::splat(margin),
        }
    }

    /// A node of B in A's frame, in boxes of A's axes.
    #[inline]
    pub fn posed(&self, node: &Node) -> Node {
        let half = f64x4::splat(0.5);
        let middles = node.bounds.map(|[lower, upper]| (lower + upper) * half);
        let halves = node.bounds.map(|[lower, upper]| (upper - lower) * half);
        let bounds = [0, 1, 2].map(|axis| {
            let middle = dot(&self.rotation[axis], &middles) + self.translation[axis];
            let reach = dot(&self.reach[axis], &halves) + self.margin;
            [middle - reach, middle + reach]
        });
        let normal = [0, 1, 2].map(|axis| dot(&self.rotation[axis], &node.normal));
        let shift = dot(&normal, &self.translation);
        let [low, high] = node.between;
        Node {
            bounds,
            normal,
            between: [low + shift - self.margin, high + shift + self.margin],
        }
    }

    /// The four triangles of a node of B, given that node in A's frame.
    #[inline]
    pub fn triangles(&self, posed: &Node, corners: &[[f64x4; 3]; 3]) -> FourTriangles {
        let corners = corners.each_ref().map(|corner| {
            [0, 1, 2].map(|axis| dot(&self.rotation[axis], corner) + self.translation[axis])
        });
        let [a, b, c] = &corners;
        let bounds = [0, 1, 2].map(|axis| {
            [
                a[axis].fast_min(b[axis]).fast_min(c[axis]) - self.margin,
                a[axis].fast_max(b[axis]).fast_max(c[axis]) + self.margin,
            ]
        });
        FourTriangles {
            corners,
            bounds,
            normal: posed.normal,
            between: posed.between,
        }
    }
}

impl Patch {
    /// A child of a node in A's frame.
    #[inline]
    pub fn of(node: &Node, slot: usize) -> Self {
        let own = |lanes: &f64x4| lanes.as_array()[slot];
        Self {
            bounds: node
                .bounds
                .each_ref()
                .map(|sides| sides.each_ref().map(own)),
            normal: node.normal.each_ref().map(own),
            between: node.between.each_ref().map(own),
        }
    }

    /// A triangle of A, given the box and planes of its node, with planes a margin (m) further apart.
    #[inline]
    pub fn of_a(node: &Node, slot: usize, margin: f64) -> Self {
        let own = Self::of(node, slot);
        let [low, high] = own.between;
        Self {
            between: [low - margin, high + margin],
            ..own
        }
    }

    /// The same in the box around the triangle's corners, a margin (m) further out.
    #[inline]
    pub fn around(self, corners: &[Vector3<f64>; 3], margin: f64) -> Self {
        let aabb = Aabb::around(corners).inflated(margin);
        Self {
            bounds: [0, 1, 2].map(|axis| [aabb.lower[axis], aabb.upper[axis]]),
            ..self
        }
    }

    /// The children of a node of A whose boxes overlap its own and are not beside its planes, as bits. (The planes of A's
    /// nodes are not asked: that costs more than it saves.)
    #[inline]
    pub fn touched(&self, node: &Node) -> u32 {
        let near = overlapping(&node.bounds, &self.bounds);
        let normal = splat(self.normal);
        // The corners of the boxes that are farthest back and ahead along the normal.
        let back = self.normal.map(|component| usize::from(component < 0.0));
        let behind = [0, 1, 2].map(|axis| node.bounds[axis][back[axis]]);
        let ahead = [0, 1, 2].map(|axis| node.bounds[axis][1 - back[axis]]);
        let [low, high] = self.between.map(f64x4::splat);
        let cuts = dot(&normal, &behind).simd_le(high) & low.simd_le(dot(&normal, &ahead));
        (near & cuts).to_bitmask()
    }
}

impl FourTriangles {
    /// The four triangles of a node of A, with planes a margin (m) further apart.
    #[inline]
    pub fn of_a(node: &Node, corners: &[[f64x4; 3]; 3], margin: f64) -> Self {
        let (margin, [low, high]) = (f64x4::splat(margin), node.between);
        Self {
            corners: *corners,
            bounds: node.bounds,
            normal: node.normal,
            between: [low - margin, high + margin],
        }
    }

    /// Which of them a triangle of the other body may cross, as bits: those whose boxes overlap and of which neither is
    /// beside the other's plane.
    #[inline]
    pub fn crossed(&self, patch: &Patch, corners: &[Vector3<f64>; 3]) -> u32 {
        let near = overlapping(&self.bounds, &patch.bounds);
        let corners = corners.map(|corner| splat(corner.into()));
        let is_between =
            |normal: &[f64x4; 3], corners: &[[f64x4; 3]; 3], [low, high]: [f64x4; 2]| {
                let [a, b, c] = corners.each_ref().map(|corner| dot(normal, corner));
                a.fast_min(b).fast_min(c).simd_le(high) & low.simd_le(a.fast_max(b).fast_max(c))
            };
        let cuts = is_between(
            &splat(patch.normal),
            &self.corners,
            patch.between.map(f64x4::splat),
        );
        let is_cut = is_between(&self.normal, &corners, self.between);
        (near & cuts & is_cut).to_bitmask()
    }
}

#[inline]
fn dot(a: &[f64x4; 3], b: &[f64x4; 3]) -> f64x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Which of four boxes overlap one: a mask.
#[inline]
fn overlapping(four: &[[f64x4; 2]; 3], one: &[[f64; 2]; 3]) -> f64x4 {
    let [along_x, along_y, along_z] = [0, 1, 2].map(|axis| {
        let [lower, upper] = one[axis].map(f64x4::splat);
        four[axis][0].simd_le(upper) & lower.simd_le(four[axis][1])
    });
    along_x & along_y & along_z
}

#[inline]
fn splat(values: [f64; 3]) -> [f64x4; 3] {
    values.map(f64x4::splat)
}
