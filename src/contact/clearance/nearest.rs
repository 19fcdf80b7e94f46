use super::Feature;
use super::side::{Part, Side};
use crate::broad_phase::SurfaceFace;
use crate::bvh::WIDTH;
use crate::contact_shape::{PartnerShape, Shape};
use crate::geometry::{Aabb, TriangleGap, TrianglePart};
use crate::narrow_phase::RelativePair;
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Largest number of alternating projections onto both surfaces.
const ROUNDS: usize = 16;
/// Ratio of squared distances above which further projections are not worth their cost.
const STALL_RATIO: f64 = 0.999;
/// Largest number of triangles of each body for a comparison of all pairs.
const MOST_COMPARED: usize = 32;

/// Closest features of the boundary surfaces of A and B.
pub(super) struct Nearest {
    pub features: [Feature; 2],
    /// Direction from A to B in A's frame, if the features touch within the tolerance of the contact.
    pub touching: Option<Vector3<f64>>,
    /// Whether the surfaces cross.
    pub are_crossing: bool,
}

impl Nearest {
    /// Finds the closest features.
    pub fn of(pair: &RelativePair) -> Self {
        let a = Side::of_compliant(pair.shape_a, Pose::identity());
        match pair.shape_b {
            PartnerShape::Compliant(b) => {
                nearest(&a, &Side::of_compliant(b, pair.pose_ab), pair.margin())
            }
            PartnerShape::Rigid(b) => nearest(&a, &Side::of_rigid(b, pair.pose_ab), pair.margin()),
            PartnerShape::HalfSpace(_) => nearest_to_plane(pair.shape_a, &pair.pose_ab),
        }
    }
}

/// Search for the closest triangles, with the closest pair so far.
struct Search<'s, 'a> {
    sides: [&'s Side<'a>; 2],
    gap: TriangleGap,
    faces: [SurfaceFace; 2],
}

fn nearest(a: &Side, b: &Side, margin: f64) -> Nearest {
    let search = Search::over([a, b]);
    let Search { gap, faces, .. } = search;
    let feature = |k: usize| Feature::of_face(search.sides[k].shape, faces[k], gap.parts[k]);
    let features = [feature(0), feature(1)];
    let is_touching = gap.squared_distance <= margin * margin;
    Nearest {
        features,
        touching: is_touching.then(|| a.normal_at(features[0]) - b.normal_at(features[1])),
        are_crossing: gap.are_crossing,
    }
}

impl<'s, 'a> Search<'s, 'a> {
    /// Searches all pairs of triangles.
    fn over(sides: [&'s Side<'a>; 2]) -> Self {
        let faces = sides.map(|side| side.tree.bvh().items()[0]);
        let gap = sides[0]
            .triangle(faces[0])
            .gap_to(&sides[1].triangle(faces[1]));
        let mut search = Self { sides, gap, faces };
        search.approach();
        if search.compare_near_supports().is_none() {
            search.descend(&sides.map(Side::root));
        }
        search
    }

    /// Finds a close pair by alternating projection onto both surfaces, beginning at the center of A's box.
    fn approach(&mut self) {
        let [a, b] = self.sides;
        let mut point_of_a = a.tree.bvh().bounds().center();
        for _ in 0..ROUNDS {
            let before = self.gap.squared_distance;
            let (point_of_b, face_b) = b.closest_to(&point_of_a);
            let (next, face_a) = a.closest_to(&point_of_b);
            point_of_a = next;
            self.compare([face_a, face_b]);
            if self.gap.squared_distance >= STALL_RATIO * before {
                return;
            }
        }
    }

    /// Compares only the triangles near the support planes of both bodies, along the direction between the closest points so far. A triangle
    /// of A that is behind the support plane of B by at least the present distance is not part of a closer pair, and vice versa. Returns
    /// `None` without comparison if there are too many triangles, as for bodies that are not convex.
    fn compare_near_supports(&mut self) -> Option<()> {
        if self.gap.are_crossing {
            return Some(());
        }
        let distance = self.gap.squared_distance.sqrt();
        let along = self.gap.between / distance;
        let [a, b] = self.sides;
        let (support_a, support_b) = (a.support(&along), b.support(&-along));
        let faces_a = a.faces_beyond(-support_b - distance, &along, MOST_COMPARED)?;
        let faces_b = b.faces_beyond(-support_a - distance, &-along, MOST_COMPARED)?;
        for &face_a in &faces_a {
            for &face_b in &faces_b {
                self.compare([face_a, face_b]);
            }
        }
        Some(())
    }

    /// Searches two parts: splits the larger part, and continues with its children in ascending order of distance.
    fn descend(&mut self, parts: &[Part; 2]) {
        let size = |k: usize| parts[k].bounds.half_extents().max();
        let split = match parts.each_ref().map(|part| part.triangle) {
            [Some((face_a, _)), Some((face_b, _))] => return self.compare([face_a, face_b]),
            [Some(_), None] => 1,
            [None, Some(_)] => 0,
            [None, None] => usize::from(size(1) > size(0)),
        };
        let rest = parts[1 - split];
        let mut children = [(f64::INFINITY, rest); WIDTH];
        let nodes = self.sides[split].children(parts[split].node);
        for (child, node) in children.iter_mut().zip(nodes) {
            *child = (node.bounds.squared_distance_to_box(&rest.bounds), node);
        }
        children.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for (squared_distance, child) in children {
            if squared_distance >= self.gap.squared_distance {
                return;
            }
            let mut next = *parts;
            next[split] = child;
            if !self.are_separated(&next) {
                self.descend(&next);
            }
        }
    }

    /// Returns whether the parts are farther apart than the closest points so far, along the direction of these points. This direction
    /// separates most parts of convex bodies.
    fn are_separated(&self, [a, b]: &[Part; 2]) -> bool {
        let distance = self.gap.squared_distance.sqrt();
        let along = self.gap.between / distance;
        // For crossing triangles, the distance is 0, and the direction is not finite.
        -b.support(&-along) - a.support(&along) >= distance
    }

    fn compare(&mut self, faces: [SurfaceFace; 2]) {
        let [a, b] = [0, 1].map(|k| self.sides[k].triangle(faces[k]));
        let gap = a.gap_to(&b);
        if gap.squared_distance < self.gap.squared_distance {
            (self.gap, self.faces) = (gap, faces);
        }
    }
}

/// Finds the vertex of A with the smallest height above the plane of a half-space.
fn nearest_to_plane(a: &Shape, pose_ab: &Pose) -> Nearest {
    let pose_ba = pose_ab.inverse();
    let up = pose_ba.rotation().row(2).transpose();
    let height = |point: &Vector3<f64>| up.dot(point) + pose_ba.translation().z;
    let lowest_of = |aabb: &Aabb| height(&aabb.center()) - up.abs().dot(&aabb.half_extents());
    let (shape, tets) = (PartnerShape::Compliant(a), a.field().tets());
    let mut lowest = (f64::INFINITY, Feature::Vertex(0));
    a.triangle_bvh().bvh().visit_ascending(lowest_of, |face| {
        for (corner, point) in face.corners(tets).iter().enumerate() {
            if height(point) < lowest.0 {
                let part = TrianglePart::Corner(corner);
                lowest = (height(point), Feature::of_face(shape, face, part));
            }
        }
        lowest.0
    });
    Nearest {
        features: [lowest.1, Feature::Plane],
        touching: None,
        are_crossing: lowest.0 < 0.0,
    }
}
