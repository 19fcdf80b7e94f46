use super::Feature;
use super::separation::Separation;
use super::side::ClosestFace;
use crate::contact::ContactPair;
use crate::contact::integrate::CutSurface;
use crate::contact::polygon_source::PolygonSource;
use crate::contact::sums::PartialSum;
use crate::contact_shape::{PartnerShape, Shape};
use crate::geometry::TrianglePart;
use crate::narrow_phase::{Cut, RelativePair};
use crate::scalar::{Scalar, lift_vector, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// A point of the overlap at which the depth is evaluated.
pub(super) enum Place {
    /// A corner of the contact polygon of a cut, and its position (m) in A's frame.
    Corner(Box<Cut>, Vector3<f64>),
    /// Index of a vertex of A, and index of the cell of B that contains the vertex.
    VertexOfA(usize, usize),
    /// Position (m) of a vertex of B in B's frame, index of the vertex, and index of the tetrahedron of A that contains the vertex.
    VertexOfB(Vector3<f64>, usize, usize),
}

/// The deepest point of the overlap, with its depth (m).
pub(super) struct Deepest {
    depth: f64,
    place: Option<Place>,
    /// The last point (m) at which the depth was evaluated, and its depth (m), which is infinite before the first point.
    last: (Vector3<f64>, f64),
}

impl Deepest {
    /// Adds a point (m), unless its depth cannot exceed the largest depth so far. A depth is the sum of two distances, so the depths of two
    /// points differ by at most twice the distance between the points.
    fn add(
        &mut self,
        point: &Vector3<f64>,
        depth: impl FnOnce() -> f64,
        place: impl FnOnce() -> Place,
    ) {
        let (last, last_depth) = self.last;
        if last_depth + 2.0 * (point - last).norm() <= self.depth {
            return;
        }
        let depth = depth();
        self.last = (*point, depth);
        if depth > self.depth {
            (self.depth, self.place) = (depth, Some(place()));
        }
    }
}

impl PartialSum for Deepest {
    fn empty() -> Self {
        Self {
            depth: 0.0,
            place: None,
            last: (Vector3::zeros(), f64::INFINITY),
        }
    }

    fn merge(&mut self, next: Self) {
        if next.depth > self.depth {
            *self = next;
        }
    }
}

/// Depths of points below the surfaces of two bodies, in A's frame.
struct Depths<'a, T> {
    source: PolygonSource<'a, T>,
    pose_ba: Pose<T>,
}

impl<'a, T: Scalar> Depths<'a, T> {
    /// Creates the depths of a pair. Polygons are cut with the tolerances of `pair`.
    fn of(mut source: PolygonSource<'a, T>, pair: RelativePair<'a>) -> Self {
        source.pair = pair;
        let pose_ba = source.pose_ab.inverse();
        Self { source, pose_ba }
    }

    /// Returns the point (m) in A's frame at a place.
    fn point_at(&self, place: &Place) -> Vector3<T> {
        let pair = &self.source.pair;
        match place {
            Place::Corner(cut, point) => {
                // The order of the corners may depend on the scalar type.
                let distance = |corner: &&Vector3<T>| (real_vector(corner) - point).norm_squared();
                let polygon = self.source.polygon_in_space(cut);
                let corners = polygon.outline.corners().iter();
                let nearest = corners.min_by(|a, b| distance(a).total_cmp(&distance(b)));
                nearest.copied().unwrap_or(lift_vector(point))
            }
            Place::VertexOfA(vertex, _) => {
                lift_vector(&pair.shape_a.field().mesh().vertices()[*vertex])
            }
            Place::VertexOfB(point, ..) => self.source.pose_ab.transformed_constant(point),
        }
    }

    /// Returns the depth (m) at a point in A's frame: the depth below the surface of A plus the depth below the surface of B.
    ///
    /// At a corner on a rigid B, the depth below the surface of B is zero, because the polygon lies in this surface.
    fn at(&self, point: &Vector3<T>, is_corner: bool) -> T {
        let pair = &self.source.pair;
        let in_a = depth_below(PartnerShape::Compliant(pair.shape_a), point, pair.margin());
        if is_corner && pair.shape_b.is_rigid() {
            return in_a;
        }
        let point_in_b = self.pose_ba.transformed_point(point);
        in_a + depth_below(pair.shape_b, &point_in_b, pair.margin())
    }
}

/// Returns the depth (m) of a point below the surface of a body that contains the point. Within the margin (m) of the surface, it is the
/// depth below the plane of the closest triangle.
fn depth_below<T: Scalar>(shape: PartnerShape, point: &Vector3<T>, margin: f64) -> T {
    let tree = match shape {
        PartnerShape::Compliant(shape) => shape.triangle_bvh(),
        PartnerShape::Rigid(shape) => shape.triangle_bvh(),
        PartnerShape::HalfSpace(_) => return -point.z,
    };
    let closest = ClosestFace::to_point(shape, tree, &real_vector(point));
    let is_on_surface = closest.to_foot.norm_squared() <= margin * margin;
    let part = if is_on_surface {
        TrianglePart::Interior
    } else {
        closest.part
    };
    let feature = Feature::of_face(shape, closest.face, part);
    let points: Vec<_> = feature.points(shape).iter().map(lift_vector).collect();
    match points[..] {
        [_, _, _] => -Separation::above_face(point, &points).distance,
        _ => Separation::between(&[*point], &points, None).distance,
    }
}

impl<'a> ContactPair<'a> {
    /// Returns the pair in A's frame, the deepest place and its depth (m), or `None` if the bodies do not overlap.
    pub(super) fn deepest(&self) -> Option<(RelativePair<'a>, Place, f64)> {
        let source = self.source();
        if !may_overlap(&source.pair) {
            return None;
        }
        let surface = source.for_values(self.search());
        let pair = surface.source.pair;
        let depths = Depths::of(source, pair);
        let mut deepest = depths.deepest_corner(&surface);
        depths.add_vertices_of_a(&mut deepest);
        depths.add_vertices_of_b(&mut deepest);
        let place = deepest.place.filter(|_| deepest.depth > pair.margin());
        place.map(|place| (pair, place, deepest.depth))
    }
}

impl<'a, T: Scalar> ContactPair<'a, T> {
    /// Returns the depth (m) at a place, and the position (m) of the place in A's frame.
    pub(super) fn depth_at(&self, pair: RelativePair<'a>, place: &Place) -> (T, Vector3<T>) {
        let depths = Depths::of(self.source(), pair);
        let point = depths.point_at(place);
        (depths.at(&point, matches!(place, Place::Corner(..))), point)
    }
}

impl Depths<'_, f64> {
    fn deepest_corner(&self, surface: &CutSurface<f64>) -> Deepest {
        surface.sum_of_cuts(|deepest: &mut Deepest, cut| {
            for point in cut.polygon.corners() {
                let place = || Place::Corner(Box::new(*cut), *point);
                deepest.add(point, || self.at(point, true), place);
            }
        })
    }

    /// Adds the vertices of A inside B at which the pressure of A is not above the pressure of B.
    fn add_vertices_of_a(&self, deepest: &mut Deepest) {
        let pair = &self.source.pair;
        for (vertex, point, extent) in vertices(pair.shape_a) {
            let in_b = self.pressure_in_b(&self.pose_ba.transformed_point(point));
            let Some((cell, pressure)) = in_b else {
                continue;
            };
            if pair.modulus_a * extent <= pressure {
                let place = || Place::VertexOfA(vertex, cell);
                deepest.add(point, || self.at(point, false), place);
            }
        }
    }

    /// Adds the vertices of a compliant B inside A at which the pressure of B is not above the pressure of A.
    fn add_vertices_of_b(&self, deepest: &mut Deepest) {
        let pair = &self.source.pair;
        let PartnerShape::Compliant(shape_b) = pair.shape_b else {
            return;
        };
        for (vertex, point, extent) in vertices(shape_b) {
            let point_in_a = pair.pose_ab.transformed_point(point);
            let Some(tet) = pair.shape_a.tet_at(&point_in_a) else {
                continue;
            };
            if pair.scales[1] * extent <= pair.modulus_a * pair.tet_a(tet).extent.at(&point_in_a) {
                let place = || Place::VertexOfB(*point, vertex, tet);
                deepest.add(&point_in_a, || self.at(&point_in_a, false), place);
            }
        }
    }

    /// Returns the cell of B that contains a point in B's frame, and the pressure (Pa) of B at the point. The pressure of a rigid body is
    /// infinite. Returns `None` if the point is outside.
    fn pressure_in_b(&self, point: &Vector3<f64>) -> Option<(usize, f64)> {
        let pair = &self.source.pair;
        match pair.shape_b {
            PartnerShape::Compliant(shape) => {
                let tet = shape.tet_at(point)?;
                Some((tet, pair.scales[1] * pair.tet_b(tet).extent.at(point)))
            }
            PartnerShape::Rigid(shape) => shape.contains(point).then_some((0, f64::INFINITY)),
            PartnerShape::HalfSpace(half_space) => {
                let pressure = match half_space.thickness() {
                    Some(thickness) => -point.z / thickness * pair.scales[1],
                    None => f64::INFINITY,
                };
                (point.z <= 0.0).then_some((0, pressure))
            }
        }
    }
}

impl Place {
    /// Returns the features of A and of B at the place.
    pub fn features(&self, shape_b: PartnerShape) -> [Feature; 2] {
        let cell_b = |cell: usize| match shape_b {
            PartnerShape::HalfSpace(_) => Feature::Plane,
            PartnerShape::Compliant(_) | PartnerShape::Rigid(_) => Feature::Cell(cell),
        };
        match *self {
            Self::Corner(ref cut, _) => [Feature::Cell(cut.tets[0]), cell_b(cut.tets[1])],
            Self::VertexOfA(vertex, cell) => [Feature::Vertex(vertex), cell_b(cell)],
            Self::VertexOfB(_, vertex, tet) => [Feature::Cell(tet), Feature::Vertex(vertex)],
        }
    }
}

/// Returns the vertices: index, position (m) in the body frame, and extent.
fn vertices(shape: &Shape) -> impl Iterator<Item = (usize, &Vector3<f64>, f64)> {
    let (vertices, extents) = (shape.field().mesh().vertices(), shape.field().extents());
    let vertices = vertices.iter().zip(extents).enumerate();
    vertices.map(|(vertex, (point, extent))| (vertex, point, *extent))
}

/// Returns whether the bounding boxes of the bodies may overlap.
fn may_overlap(pair: &RelativePair) -> bool {
    let bounds = pair.shape_a.bounds();
    let bounds_b = match pair.shape_b {
        PartnerShape::Compliant(shape) => shape.bounds(),
        PartnerShape::Rigid(shape) => shape.bounds(),
        PartnerShape::HalfSpace(_) => return bounds.posed(&pair.pose_ab.inverse()).lower.z <= 0.0,
    };
    bounds.may_overlap_posed(&bounds_b, &pair.pose_ab, pair.margin())
}
