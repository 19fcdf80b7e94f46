use super::Feature;
use crate::broad_phase::TriangleBvh;
use crate::bvh::{Node, WIDTH};
use crate::contact_shape::{PartnerShape, RigidShape, Shape};
use crate::geometry::{Aabb, Triangle, TriangleGap, TrianglePart};
use crate::narrow_phase::RelativePair;
use crate::spatial::Pose;
use nalgebra::Vector3;

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

/// The surface of a body, with the pose of the body in A's frame.
struct Side<'a> {
    shape: PartnerShape<'a>,
    tree: &'a TriangleBvh,
    pose: Pose,
}

/// A node of a tree, or one of its triangles, with its box in A's frame. A triangle is on the level after the last level of the tree.
#[derive(Clone, Copy)]
struct Part {
    node: Node,
    bounds: Aabb,
    /// Corners (m) of a triangle in A's frame.
    corners: Option<[Vector3<f64>; 3]>,
}

impl Part {
    /// Returns an upper bound of the coordinate (m) of the points of the part along a unit vector.
    fn end_along(&self, direction: &Vector3<f64>) -> f64 {
        if let Some([a, b, c]) = &self.corners {
            return direction.dot(a).max(direction.dot(b)).max(direction.dot(c));
        }
        let reach = direction.abs().dot(&self.bounds.half_extents());
        direction.dot(&self.bounds.center()) + reach
    }
}

/// Branch and bound over the pairs of triangles, with the closest pair so far.
struct Descent<'s, 'a> {
    sides: [&'s Side<'a>; 2],
    gap: TriangleGap,
    triangles: [usize; 2],
}

impl<'a> Side<'a> {
    fn of_compliant(shape: &'a Shape, pose: Pose) -> Self {
        Self {
            shape: PartnerShape::Compliant(shape),
            tree: shape.triangle_bvh(),
            pose,
        }
    }

    fn of_rigid(shape: &'a RigidShape, pose: Pose) -> Self {
        Self {
            shape: PartnerShape::Rigid(shape),
            tree: shape.triangle_bvh(),
            pose,
        }
    }

    fn root(&self) -> Part {
        Part {
            node: Node::ROOT,
            bounds: self.tree.bvh().bounds().posed(&self.pose),
            corners: None,
        }
    }

    /// Returns the children of a node.
    fn children(&self, Node { level, index }: Node) -> impl Iterator<Item = Part> {
        let bvh = self.tree.bvh();
        let below = bvh.levels().get(level + 1).map(Vec::len);
        let count = below.unwrap_or_else(|| bvh.items().len());
        let boxes = &bvh.levels()[level][index];
        let child = move |slot: usize| {
            let (level, index) = (level + 1, WIDTH * index + slot);
            Part {
                node: Node { level, index },
                bounds: boxes.aabb(slot).posed(&self.pose),
                corners: below.is_none().then(|| self.corners(index)),
            }
        };
        (0..WIDTH.min(count - WIDTH * index)).map(child)
    }

    /// Returns the corners (m) of a triangle in A's frame.
    fn corners(&self, index: usize) -> [Vector3<f64>; 3] {
        let corners = self.tree.bvh().items()[index].corners(self.shape.cells());
        corners.map(|corner| self.pose.transformed_point(&corner))
    }

    /// Returns a triangle in A's frame, with its outward normal.
    fn triangle(&self, index: usize) -> Triangle {
        Triangle::new(self.corners(index))
    }

    /// Returns the sum of the outward normals of the triangles around a feature, in A's frame.
    fn normal_at(&self, feature: Feature) -> Vector3<f64> {
        let triangles = 0..self.tree.bvh().items().len();
        let is_around = |&index: &usize| {
            let whole = Feature::of_face(self.shape, self.face(index), TrianglePart::Interior);
            let vertices = whole.vertices();
            feature
                .vertices()
                .iter()
                .all(|vertex| vertices.contains(vertex))
        };
        let normals = triangles
            .filter(is_around)
            .map(|index| *self.triangle(index).normal());
        normals.sum()
    }

    /// Returns the cell of a triangle and the face of the cell.
    fn face(&self, index: usize) -> (usize, usize) {
        let face = self.tree.bvh().items()[index];
        (face.tet(), face.face())
    }
}

fn nearest(a: &Side, b: &Side, margin: f64) -> Nearest {
    let mut descent = Descent {
        sides: [a, b],
        gap: a.triangle(0).gap_to(&b.triangle(0)),
        triangles: [0, 0],
    };
    descent.descend(&[a.root(), b.root()]);
    let Descent { gap, triangles, .. } = descent;
    let feature = |k: usize| {
        let side = descent.sides[k];
        Feature::of_face(side.shape, side.face(triangles[k]), gap.parts[k])
    };
    let features = [feature(0), feature(1)];
    let is_touching = gap.squared_distance <= margin * margin;
    Nearest {
        features,
        touching: is_touching.then(|| a.normal_at(features[0]) - b.normal_at(features[1])),
        are_crossing: gap.are_crossing,
    }
}

impl Descent<'_, '_> {
    /// Searches two parts: splits the larger part, and continues with its children in ascending order of distance.
    fn descend(&mut self, parts: &[Part; 2]) {
        let are_triangles = parts.each_ref().map(|part| part.corners.is_some());
        let size = |k: usize| parts[k].bounds.half_extents().max();
        let split = match are_triangles {
            [true, true] => return self.compare(parts.each_ref().map(|part| part.node.index)),
            [true, false] => 1,
            [false, true] => 0,
            [false, false] => usize::from(size(1) > size(0)),
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
        -b.end_along(&-along) - a.end_along(&along) >= distance
    }

    fn compare(&mut self, indices: [usize; 2]) {
        let [a, b] = [0, 1].map(|k| self.sides[k].triangle(indices[k]));
        let gap = a.gap_to(&b);
        if gap.squared_distance < self.gap.squared_distance {
            (self.gap, self.triangles) = (gap, indices);
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
                let place = (face.tet(), face.face());
                lowest = (height(point), Feature::of_face(shape, place, part));
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
