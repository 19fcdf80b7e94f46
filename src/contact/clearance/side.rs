use super::Feature;
use crate::broad_phase::{SurfaceFace, TriangleBvh};
use crate::bvh::{Node, WIDTH};
use crate::contact_shape::{PartnerShape, RigidShape, Shape};
use crate::geometry::{Aabb, Triangle, TrianglePart};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// The triangle of a surface that is closest to a point.
pub(super) struct ClosestFace {
    pub face: SurfaceFace,
    /// Vector (m) from the point to the closest point of the triangle.
    pub to_foot: Vector3<f64>,
    /// The part of the triangle that contains the closest point.
    pub part: TrianglePart,
}

/// The surface of a body, with the pose of the body in A's frame.
pub(super) struct Side<'a> {
    pub shape: PartnerShape<'a>,
    pub tree: &'a TriangleBvh,
    pose: Pose,
}

/// A node of a tree, or one of its triangles, with its box in A's frame. A triangle is on the level after the last level of the tree.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub node: Node,
    pub bounds: Aabb,
    /// A triangle with its corners (m) in A's frame.
    pub triangle: Option<(SurfaceFace, [Vector3<f64>; 3])>,
}

impl Part {
    /// Returns an upper bound of the coordinate (m) of the points of the part along a unit vector.
    pub fn support(&self, direction: &Vector3<f64>) -> f64 {
        match &self.triangle {
            Some((_, corners)) => support_of_corners(corners, direction),
            None => support_of_box(&self.bounds, direction),
        }
    }
}

impl<'a> Side<'a> {
    pub fn of_compliant(shape: &'a Shape, pose: Pose) -> Self {
        Self {
            shape: PartnerShape::Compliant(shape),
            tree: shape.triangle_bvh(),
            pose,
        }
    }

    pub fn of_rigid(shape: &'a RigidShape, pose: Pose) -> Self {
        Self {
            shape: PartnerShape::Rigid(shape),
            tree: shape.triangle_bvh(),
            pose,
        }
    }

    /// Returns the surface after a displacement (m) in A's frame.
    pub fn shifted(&self, displacement: &Vector3<f64>) -> Self {
        let position = self.pose.translation() + displacement;
        let pose = self.pose.with_translation(position);
        Self { pose, ..*self }
    }

    pub fn root(&self) -> Part {
        Part {
            node: Node::ROOT,
            bounds: self.tree.bvh().bounds().posed(&self.pose),
            triangle: None,
        }
    }

    /// Returns the children of a node.
    pub fn children(&self, Node { level, index }: Node) -> impl Iterator<Item = Part> {
        let bvh = self.tree.bvh();
        let below = bvh.levels().get(level + 1).map(Vec::len);
        let count = below.unwrap_or_else(|| bvh.items().len());
        let boxes = &bvh.levels()[level][index];
        let child = move |slot: usize| {
            let (level, index) = (level + 1, WIDTH * index + slot);
            Part {
                node: Node { level, index },
                bounds: boxes.aabb(slot).posed(&self.pose),
                triangle: below.is_none().then(|| {
                    let face = bvh.items()[index];
                    (face, self.corners(face))
                }),
            }
        };
        (0..WIDTH.min(count - WIDTH * index)).map(child)
    }

    /// Returns the corners (m) of a triangle in A's frame.
    fn corners(&self, face: SurfaceFace) -> [Vector3<f64>; 3] {
        let corners = face.corners(self.shape.cells());
        corners.map(|corner| self.pose.transformed_point(&corner))
    }

    /// Returns a triangle in A's frame, with its outward normal.
    pub fn triangle(&self, face: SurfaceFace) -> Triangle {
        Triangle::new(self.corners(face))
    }

    /// Returns the point of the surface that is closest to a point (m), in A's frame, and its triangle.
    pub fn closest_to(&self, point: &Vector3<f64>) -> (Vector3<f64>, SurfaceFace) {
        let local = self.pose.inverse().transformed_point(point);
        let closest = ClosestFace::to_point(self.shape, self.tree, &local);
        (
            self.pose.transformed_point(&(local + closest.to_foot)),
            closest.face,
        )
    }

    /// Returns the largest coordinate (m) of the surface along a unit vector in A's frame.
    pub fn support(&self, direction: &Vector3<f64>) -> f64 {
        let mut end = f64::NEG_INFINITY;
        self.visit_from_support(direction, |_, support_of_face| {
            end = end.max(support_of_face);
            end
        });
        end
    }

    /// Returns the triangles that reach beyond a coordinate (m) along a unit vector in A's frame, with their largest coordinates. Returns
    /// `None` if there are more than `most`.
    pub fn faces_beyond(
        &self,
        limit: f64,
        direction: &Vector3<f64>,
        most: usize,
    ) -> Option<Vec<(SurfaceFace, f64)>> {
        let mut faces = Vec::new();
        self.visit_from_support(direction, |face, support_of_face| {
            if support_of_face > limit {
                faces.push((face, support_of_face));
            }
            if faces.len() > most {
                f64::INFINITY
            } else {
                limit
            }
        });
        (faces.len() <= most).then_some(faces)
    }

    /// Visits triangles with their largest coordinate (m) along a unit vector in A's frame, beginning with the nodes that reach farthest.
    /// `visit` returns a coordinate. Triangles that do not reach it need not be visited.
    fn visit_from_support(
        &self,
        direction: &Vector3<f64>,
        mut visit: impl FnMut(SurfaceFace, f64) -> f64,
    ) {
        let local = self.pose.rotation().tr_mul(direction);
        let offset = direction.dot(self.pose.translation());
        let before = |aabb: &Aabb| -support_of_box(aabb, &local);
        self.tree.bvh().visit_ascending(before, |face| {
            let end = support_of_corners(&face.corners(self.shape.cells()), &local) + offset;
            offset - visit(face, end)
        });
    }

    /// Returns the sum of the outward normals of the triangles around a feature, in A's frame.
    pub fn normal_at(&self, feature: Feature) -> Vector3<f64> {
        let faces = self.tree.bvh().items().iter().copied();
        let is_around = |&face: &SurfaceFace| {
            let whole = Feature::of_face(self.shape, face, TrianglePart::Interior);
            let vertices = whole.vertices();
            feature
                .vertices()
                .iter()
                .all(|vertex| vertices.contains(vertex))
        };
        let normals = faces
            .filter(is_around)
            .map(|face| *self.triangle(face).normal());
        normals.sum()
    }
}

impl ClosestFace {
    /// Finds the triangle of a surface that is closest to a point (m) in the body frame.
    pub fn to_point(shape: PartnerShape, tree: &TriangleBvh, point: &Vector3<f64>) -> Self {
        let mut closest = Self {
            face: tree.bvh().items()[0],
            to_foot: Vector3::from_element(f64::INFINITY),
            part: TrianglePart::Interior,
        };
        tree.bvh().visit_outwards(point, |face| {
            let (to_foot, part) = Triangle::new(face.corners(shape.cells())).gap_to_point(point);
            if to_foot.norm_squared() < closest.to_foot.norm_squared() {
                closest = Self {
                    face,
                    to_foot,
                    part,
                };
            }
            closest.to_foot.norm_squared()
        });
        closest
    }
}

/// Returns the largest coordinate (m) of a box along a unit vector.
fn support_of_box(aabb: &Aabb, direction: &Vector3<f64>) -> f64 {
    direction.dot(&aabb.center()) + direction.abs().dot(&aabb.half_extents())
}

/// Returns the largest coordinate (m) of corners along a unit vector.
fn support_of_corners([a, b, c]: &[Vector3<f64>; 3], direction: &Vector3<f64>) -> f64 {
    direction.dot(a).max(direction.dot(b)).max(direction.dot(c))
}
