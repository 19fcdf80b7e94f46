//! The items that overlap a box, in the same frame or in another.

use super::four_boxes::{FourBoxes, WIDTH, four_bits};
use super::tree::{BoxTest, Bvh};
use crate::geometry::Aabb;
use crate::lanes::space::{difference, dot, scaled, splat, sum};
use crate::lanes::{Lanes, Numbers};
use crate::spatial::Pose;
use nalgebra::{Matrix3, Vector3};

impl<K: Copy> Bvh<K> {
    /// Visits the items whose boxes overlap `query`.
    pub fn visit_overlapping(&self, query: &Aabb, visit: impl FnMut(K)) {
        self.traverse(Overlap::of(query), visit);
    }

    /// Visits the items (in B) whose boxes may overlap the box `region` in the frame of A: no face of either separates them by
    /// more than `margin` (m).
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

/// Whether boxes overlap one in the same frame.
struct Overlap {
    lower: [f64; 3],
    upper: [f64; 3],
}

/// Whether boxes in B may overlap one in A: [`Aabb::may_overlap_posed`] for four boxes.
struct OverlapPosed {
    rotation: Matrix3<f64>,
    /// |R|, entry by entry.
    reach: Matrix3<f64>,
    /// From the center of the box in A to the origin of B (m).
    offset: Vector3<f64>,
    /// Half its edges along the axes of A, and how far it reaches along those of B, each with the margin (m).
    limits: [Vector3<f64>; 2],
}

impl Overlap {
    fn of(query: &Aabb) -> Self {
        Self {
            lower: query.lower.into(),
            upper: query.upper.into(),
        }
    }
}

impl BoxTest for Overlap {
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let (lower, upper) = (splat(lanes, &self.lower), splat(lanes, &self.upper));
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            bits |= four_bits(boxes.overlapping(lanes, [&lower, &upper], first), first);
        }
        bits
    }
}

impl OverlapPosed {
    fn of(region: &Aabb, pose_ab: &Pose<f64>, margin: f64) -> Self {
        let (half, reach) = (region.half_extents(), pose_ab.rotation().abs());
        Self {
            rotation: *pose_ab.rotation(),
            reach,
            offset: pose_ab.translation() - region.center(),
            limits: [half, reach.tr_mul(&half)].map(|limit| limit.add_scalar(margin)),
        }
    }
}

impl BoxTest for OverlapPosed {
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let row = |matrix: &Matrix3<f64>, i: usize| [0, 1, 2].map(|j| lanes.splat(matrix[(i, j)]));
        let column = |i: usize| [0, 1, 2].map(|j| lanes.splat(self.rotation[(j, i)]));
        let [limit_a, limit_b] = self.limits.map(|limit| splat(lanes, limit.as_ref()));
        let (offset, middle) = (splat(lanes, self.offset.as_ref()), lanes.splat(0.5));
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let sides = |side: usize| [0, 1, 2].map(|k| lanes.load_four(&boxes.0[k][side], first));
            let (lower, upper) = (sides(0), sides(1));
            let center = scaled(sum(upper, lower), middle);
            let half = scaled(difference(upper, lower), middle);
            let between = [0, 1, 2].map(|k| dot(row(&self.rotation, k), center) + offset[k]);
            let along = |k: usize| {
                (between[k].abs()).is_at_most(limit_a[k] + dot(row(&self.reach, k), half))
                    & (dot(column(k), between).abs()).is_at_most(limit_b[k] + half[k])
            };
            bits |= four_bits(along(0) & along(1) & along(2), first);
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

    /// Points within 1 m of the origin along each axis that lie nowhere in particular.
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
                let (mut found, mut near) = (Vec::new(), Vec::new());
                bvh.visit_overlapping(&query, |item| found.push(item));
                bvh.visit_near(&query, &pose, MARGIN, |item| near.push(item));
                let all_where = |test: &dyn Fn(&Aabb) -> bool| -> Vec<usize> {
                    (0..boxes.len()).filter(|&k| test(&boxes[k])).collect()
                };
                found.sort_unstable();
                near.sort_unstable();
                assert_eq!(found, all_where(&|aabb| aabb.overlaps(&query)));
                let may_overlap = |aabb: &Aabb| query.may_overlap_posed(aabb, &pose, MARGIN);
                assert_eq!(near, all_where(&may_overlap));
                total += found.len();
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
