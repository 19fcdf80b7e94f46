use crate::bvh::{BoxTest, Bvh, FourBoxes, FourCorners, WIDTH, four_bits};
use crate::geometry::{Aabb, AffineField};
use crate::lanes::space::{dot, splat};
use crate::lanes::{Lanes, Numbers, Quad};
use crate::mesh::PressureField;
use nalgebra::Vector3;

/// Bounding-volume hierarchies of a mesh's tetrahedra, in the body frame. Inert tetrahedra have a
/// separate tree.
#[derive(Debug, Clone)]
pub(crate) struct TetBvh {
    pressing: Bvh<usize>,
    /// Corners of the tetrahedra that are not inert, for each node of the last level.
    corners: Vec<FourCorners<4>>,
    inert: Bvh<usize>,
}

impl TetBvh {
    /// Builds the trees: O(n log n).
    pub fn of(field: &PressureField) -> Self {
        let bvh_of = |is_inert: bool| {
            let tets = field.tets().iter().enumerate();
            let chosen = tets.filter(|(_, tet)| tet.is_inert() == is_inert);
            Bvh::new(chosen.map(|(index, tet)| (index, tet.tetrahedron.corners)))
        };
        let pressing = bvh_of(false);
        Self {
            corners: pressing.corners(|tet| field.tets()[tet].tetrahedron.corners),
            pressing,
            inert: bvh_of(true),
        }
    }

    /// Returns the tree of the tetrahedra that are not inert.
    pub fn pressing(&self) -> &Bvh<usize> {
        &self.pressing
    }

    /// Visits all tetrahedra, including inert ones, whose boxes contain a point. The point is
    /// accurate to `margin` (m).
    pub fn visit_at(&self, point: &Vector3<f64>, margin: f64, mut visit: impl FnMut(usize)) {
        let query = Aabb::around([point]).inflated(margin);
        for bvh in [&self.pressing, &self.inert] {
            bvh.visit_overlapping(&query, &mut visit);
        }
    }

    /// Visits the tetrahedra, except inert ones, in which an affine field has values from `least`
    /// to `most`. `least` must be finite, because the boxes of missing children are at infinity.
    pub fn visit_between(
        &self,
        field: &AffineField,
        [least, most]: [f64; 2],
        visit: impl FnMut(usize),
    ) {
        let gradient: [f64; 3] = field.gradient.into();
        let test = FieldRange {
            gradient,
            offset: field.offset,
            rises: gradient.map(|slope| slope >= 0.0),
            least,
            most,
            tets: &self.corners,
        };
        self.pressing.traverse(test, visit);
    }
}

/// Test whether an affine field has values in a range.
struct FieldRange<'t> {
    gradient: [f64; 3],
    offset: f64,
    /// Whether the field rises along each axis.
    rises: [bool; 3],
    least: f64,
    most: f64,
    tets: &'t [FourCorners<4>],
}

impl FieldRange<'_> {
    /// Returns whether the values from `lowest` to `highest` overlap the range, one bit for each
    /// child.
    #[inline(always)]
    fn are_met<L: Lanes>(&self, lanes: L, [lowest, highest]: [L::Numbers; 2], first: usize) -> u32 {
        let [least, most] = [self.least, self.most].map(|limit| lanes.splat(limit));
        four_bits(lowest.is_at_most(most) & least.is_at_most(highest), first)
    }
}

impl BoxTest for FieldRange<'_> {
    #[inline(always)]
    fn children<L: Lanes>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let gradient = splat(lanes, &self.gradient);
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let [mut lowest, mut highest] = [lanes.splat(self.offset); 2];
            for (axis, sides) in boxes.0.iter().enumerate() {
                // Sides of the boxes where the field is lowest and highest.
                let rises = usize::from(self.rises[axis]);
                let [falling, rising] = [&sides[1 - rises], &sides[rises]];
                lowest = lowest + gradient[axis] * lanes.load_four(falling, first);
                highest = highest + gradient[axis] * lanes.load_four(rising, first);
            }
            bits |= self.are_met(lanes, [lowest, highest], first);
        }
        bits
    }

    /// Tests the corners of tetrahedra. If values are 0 and −0, either may be the minimum or the
    /// maximum. This has no effect, because 0 and −0 compare equal.
    #[inline(always)]
    fn items<L: Lanes>(&self, lanes: L, _boxes: &FourBoxes, leaf: usize) -> u32 {
        let (tets, gradient) = (&self.tets[leaf], splat(lanes, &self.gradient));
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let load = |quad: &Quad| lanes.load_four(quad, first);
            let corner = |[x, y, z]: &[Quad; 3]| [load(x), load(y), load(z)];
            let value = |tet_corner: usize| dot(gradient, corner(&tets[tet_corner]));
            let [a, b, c, d] = [value(0), value(1), value(2), value(3)];
            let offset = lanes.splat(self.offset);
            let lowest = a.min(b).min(c.min(d)) + offset;
            let highest = a.max(b).max(c.max(d)) + offset;
            bits |= self.are_met(lanes, [lowest, highest], first);
        }
        bits
    }
}
