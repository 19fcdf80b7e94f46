use super::Feature;
use super::separation::unit;
use super::side::{Part, Side};
use crate::broad_phase::SurfaceFace;
use crate::bvh::WIDTH;
use crate::contact_shape::PartnerShape;
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
/// Largest depth of an overlap that counts as round-off, in multiples of the margin: 1.2e-10 of the size of the bodies.
pub(super) const TOUCHING: f64 = 4096.0;
/// Distance by which bodies that touch are moved apart, in multiples of the margin, so that their closest features are well-conditioned.
const SHIFT: f64 = 2.0 * TOUCHING;

/// Closest features of the boundary surfaces of A and B.
pub(super) struct Nearest {
    /// The closest features. If the bodies touch, features that tie with them are included. The distances of ties differ by less than the
    /// margin.
    pub features: Vec<[Feature; 2]>,
    /// Direction from A to B in A's frame, if the bodies touch or overlap. `None` for half-spaces, because their normal is known.
    pub touching: Option<Vector3<f64>>,
    /// Whether the surfaces cross by more than round-off.
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
            PartnerShape::HalfSpace(_) => nearest_to_plane(pair),
        }
    }
}

/// Search for the closest triangles, with the closest pair so far.
struct Search<'s, 'a> {
    sides: [&'s Side<'a>; 2],
    gap: TriangleGap,
    faces: [SurfaceFace; 2],
}

/// Finds the closest features of two surfaces.
///
/// If the surfaces touch, round-off would decide which features are closest, and in which direction. The result is then the closest features
/// after a shift that separates the bodies. If none of three shifts separates them, the surfaces cross by more than round-off or touch on
/// several sides, and the result is the closest features without a shift.
fn nearest(a: &Side, b: &Side, margin: f64) -> Nearest {
    let search = Search::over([a, b]);
    if search.is_apart(margin) {
        return search.nearest();
    }
    let separated = |direction: Vector3<f64>| {
        let b = b.shifted(&(direction * (SHIFT * margin)));
        let search = Search::over([a, &b]);
        search.is_apart(margin).then(|| Nearest {
            features: search.ties(margin),
            touching: Some(direction),
            are_crossing: false,
        })
    };
    let directions = search.outward_directions();
    let touching = directions.into_iter().find_map(separated);
    touching.unwrap_or_else(|| Nearest {
        touching: Some(directions[0]),
        ..search.nearest()
    })
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

    fn is_apart(&self, margin: f64) -> bool {
        self.gap.squared_distance > margin * margin
    }

    fn nearest(&self) -> Nearest {
        Nearest {
            features: vec![self.features_of(self.faces, self.gap.parts)],
            touching: None,
            are_crossing: self.gap.are_crossing,
        }
    }

    /// Returns the closest features, and the features near the support planes whose distance is larger by at most the margin (m).
    fn ties(&self, margin: f64) -> Vec<[Feature; 2]> {
        let most = self.gap.squared_distance.sqrt() + margin;
        let ([a, b], mut features) = (self.sides, self.nearest().features);
        for faces in self.pairs_near_supports(most).unwrap_or_default() {
            for (between, parts) in a.triangle(faces[0]).gaps_to(&b.triangle(faces[1])) {
                let tie = self.features_of(faces, parts);
                if between.norm_squared() <= most * most && !features.contains(&tie) {
                    features.push(tie);
                }
            }
        }
        features
    }

    fn features_of(&self, faces: [SurfaceFace; 2], parts: [TrianglePart; 2]) -> [Feature; 2] {
        [0, 1].map(|k| Feature::of_face(self.sides[k].shape, faces[k], parts[k]))
    }

    /// Returns unit vectors from A to B that may separate the bodies, from the normals of the closest features.
    fn outward_directions(&self) -> [Vector3<f64>; 3] {
        let features = self.features_of(self.faces, self.gap.parts);
        let normal = |k: usize| unit(&self.sides[k].normal_at(features[k]));
        let [a, b] = [normal(0), normal(1)];
        [unit(&(a - b)), a, -b]
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

    /// Compares only the triangles near the support planes. Returns `None` without comparison if there are too many triangles.
    fn compare_near_supports(&mut self) -> Option<()> {
        if !self.gap.are_crossing {
            for faces in self.pairs_near_supports(self.gap.squared_distance.sqrt())? {
                self.compare(faces);
            }
        }
        Some(())
    }

    /// Returns the pairs of triangles that are nearer than a distance (m) along the direction between the closest points so far. Other pairs are
    /// not closer than this distance. Returns `None` if there are too many triangles, as for bodies that are not convex.
    fn pairs_near_supports(&self, distance: f64) -> Option<Vec<[SurfaceFace; 2]>> {
        let along = self.gap.between / self.gap.squared_distance.sqrt();
        let [a, b] = self.sides;
        let (support_a, support_b) = (a.support(&along), b.support(&-along));
        let faces_a = a.faces_beyond(-support_b - distance, &along, MOST_COMPARED)?;
        let faces_b = b.faces_beyond(-support_a - distance, &-along, MOST_COMPARED)?;
        let pairs = faces_a
            .iter()
            .flat_map(|a| faces_b.iter().map(move |b| [a, b]));
        let near = pairs.filter(|[a, b]| a.1 + b.1 > -distance);
        Some(near.map(|[a, b]| [a.0, b.0]).collect())
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

/// Finds the vertex of A with the smallest height above the plane of a half-space B, or the lowest vertices if the bodies touch.
fn nearest_to_plane(pair: &RelativePair) -> Nearest {
    let (a, pose_ba, margin) = (pair.shape_a, pair.pose_ab.inverse(), pair.margin());
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
    let mut vertices = vec![lowest.1];
    if lowest.0.abs() <= TOUCHING * margin {
        let points = a.field().mesh().vertices().iter().enumerate();
        let ties = points.filter(|(_, point)| height(point) <= lowest.0 + margin);
        vertices = ties.map(|(vertex, _)| Feature::Vertex(vertex)).collect();
    }
    let features = vertices.into_iter().map(|vertex| [vertex, Feature::Plane]);
    Nearest {
        features: features.collect(),
        touching: None,
        are_crossing: lowest.0 < -TOUCHING * margin,
    }
}
