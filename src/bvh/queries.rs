//! Queries for the items that overlap a box, in the same frame or in another frame.

#![expect(
    clippy::needless_range_loop,
    reason = "adapters of iterators take closures, and a closure over lanes may stay a call, compiled for any processor"
)]

use super::four_boxes::{FourBoxes, WIDTH, four_bits};
use super::tree::{BoxTest, Bvh};
use crate::geometry::Aabb;
use crate::lanes::space::{dot, splat};
use crate::lanes::{Lanes, Numbers};
use crate::spatial::Pose;
use nalgebra::Vector3;

impl<K: Copy> Bvh<K> {
    /// Visits the items whose boxes overlap `query`.
    pub fn visit_overlapping(&self, query: &Aabb, visit: impl FnMut(K)) {
        self.traverse(query, visit);
    }

    /// Visits the items (in B) whose boxes may overlap the box `region` (in A). An item is skipped
    /// if a face of either box separates the boxes by more than `margin` (m).
    pub fn visit_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        visit: impl FnMut(K),
    ) {
        self.traverse(OverlapPosed::of(region, pose_ab, margin), visit);
    }
}

/// Test whether boxes in B may overlap a box in A: [`Aabb::may_overlap_posed`] for four boxes.
struct OverlapPosed {
    /// Rows and columns of the rotation R.
    rows: [[f64; 3]; 3],
    columns: [[f64; 3]; 3],
    /// Rows of the matrix of absolute values |Rᵢⱼ|.
    reach: [[f64; 3]; 3],
    /// Vector from the center of the box in A to the origin of B (m).
    offset: Vector3<f64>,
    /// Half extents (m) of the box in A along the axes of A, and along the axes of B. Both include
    /// the margin.
    limits: [Vector3<f64>; 2],
}

/// Selects boxes that overlap this box.
impl BoxTest for &Aabb {
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let [lower, upper] = [&self.lower, &self.upper].map(|side| splat(lanes, side.as_ref()));
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            bits |= four_bits(boxes.overlapping(lanes, [&lower, &upper], first), first);
        }
        bits
    }
}

impl OverlapPosed {
    fn of(region: &Aabb, pose_ab: &Pose<f64>, margin: f64) -> Self {
        let (half, rotation) = (region.half_extents(), pose_ab.rotation());
        let reach = rotation.abs();
        Self {
            rows: rotation.transpose().into(),
            columns: (*rotation).into(),
            reach: reach.transpose().into(),
            offset: pose_ab.translation() - region.center(),
            limits: [half, reach.tr_mul(&half)].map(|limit| limit.add_scalar(margin)),
        }
    }
}

impl BoxTest for OverlapPosed {
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let middle = lanes.splat(0.5);
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let (mut center, mut half, mut between) = ([middle; 3], [middle; 3], [middle; 3]);
            for k in 0..3 {
                let [lower, upper] = &boxes.0[k];
                let (lower, upper) = (lanes.load_four(lower, first), lanes.load_four(upper, first));
                (center[k], half[k]) = ((lower + upper) * middle, (upper - lower) * middle);
            }
            let mut near = middle.is_at_most(middle);
            for k in 0..3 {
                between[k] = dot(splat(lanes, &self.rows[k]), center) + lanes.splat(self.offset[k]);
                let reach =
                    dot(splat(lanes, &self.reach[k]), half) + lanes.splat(self.limits[0][k]);
                near = near & between[k].abs().is_at_most(reach);
            }
            for k in 0..3 {
                let reach = half[k] + lanes.splat(self.limits[1][k]);
                near = near
                    & dot(splat(lanes, &self.columns[k]), between)
                        .abs()
                        .is_at_most(reach);
            }
            bits |= four_bits(near, first);
        }
        bits
    }
}

#[cfg(test)]
mod tests {
    use crate::bvh::Bvh;
    use crate::geometry::Aabb;
    use crate::spatial::Pose;
    use nalgebra::{Vector3, vector};

    const MARGIN: f64 = 1e-13;

    /// Returns points in general position, with coordinates between −1 m and 1 m.
    fn point(k: u32) -> Vector3<f64> {
        let steps = vector![0.819_172_5, 0.671_043_6, 0.549_700_5];
        steps.map(|step| (f64::from(k) * step).fract() * 2.0 - 1.0)
    }

    fn segments(count: u32) -> Vec<[Vector3<f64>; 2]> {
        let ends = |k: u32| [point(k), point(k) + 0.2 * point(3 * k + 1)];
        (0..count).map(ends).collect()
    }

    #[test]
    fn a_tree_finds_the_items_whose_boxes_overlap() {
        for count in [0, 1, 3, 4, 5, 16, 17, 63, 64, 65, 300] {
            let items = segments(count);
            let bvh = Bvh::new(items.iter().copied().enumerate());
            let boxes: Vec<Aabb> = items.iter().map(Aabb::around).collect();
            let mut total = 0;
            for k in 0..60 {
                let query = Aabb::around(&[point(7 * k), point(5 * k + 1)]);
                let pose = Pose::from_rotation_vector(&point(k), 0.5 * point(k + 9));
                let (mut overlapping, mut near) = (Vec::new(), Vec::new());
                bvh.visit_overlapping(&query, |item| overlapping.push(item));
                bvh.visit_near(&query, &pose, MARGIN, |item| near.push(item));
                let all_where = |test: &dyn Fn(&Aabb) -> bool| -> Vec<usize> {
                    (0..boxes.len()).filter(|&k| test(&boxes[k])).collect()
                };
                overlapping.sort_unstable();
                near.sort_unstable();
                assert_eq!(overlapping, all_where(&|aabb| aabb.overlaps(&query)));
                let may_overlap = |aabb: &Aabb| query.may_overlap_posed(aabb, &pose, MARGIN);
                assert_eq!(near, all_where(&may_overlap));
                total += overlapping.len();
            }
            assert!(count < 16 || total > 0);
        }
    }

    #[test]
    fn each_item_is_below_one_node_of_a_level() {
        let bvh = Bvh::new(segments(70).into_iter().enumerate());
        let mut items = bvh.items().to_vec();
        items.sort_unstable();
        assert_eq!(items, (0..70).collect::<Vec<usize>>());
        let counts: Vec<usize> = bvh.levels().iter().map(Vec::len).collect();
        assert_eq!(counts, [1, 2, 5, 18]);
    }
}
