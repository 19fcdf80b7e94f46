//! Positions at which the model has a kink, or at which the result depends on round-off.

use super::measures::{FASTEST, MARGIN, Measures, ROOM};
use hydroelastic::contact::{ContactBody, ContactPair, ContactPolygon};
use hydroelastic::geometry::Aabb;
use hydroelastic::mesh::FieldTet;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;

/// Difference of gradients, relative to the sensitivity of either field, below which they count as equal.
pub const EQUAL_FIELDS: f64 = 1e-9;

/// Difference of ridges, relative to reach and pressure, below which they count as equal.
const RIDGE: f64 = 1e-8;

/// Largest angle between a polygon and a face that graze each other.
const GRAZING_TILT: f64 = 1e-6;

/// Largest distance of a corner of a grazing polygon from the face, relative to the reach. In contact with a body 1e8 times as stiff, the
/// contact surface is this close to the faces, with an angle of at most the grazing tilt.
const GRAZING_DISTANCE: f64 = 1e-8;

/// A kink of the model, at which forces jump or change faster than a step resolves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kink {
    /// The fields of two overlapping tetrahedra are nearly equal.
    EqualFields,
    /// The fields differ, but by less than the kernel resolves, because one is a plateau or nearly a plateau.
    Unresolved,
    /// The highest pressures of both bodies are equal at the same point. As one ridge passes the other, the contact surface between them
    /// reverses, and its force jumps to the opposite.
    Ridges,
    /// Tetrahedra are so thin, or the bodies so different in size, that lines in which planes meet have errors larger than one part in
    /// [`ROOM`] of the smaller body.
    Blurred,
    /// The contact surface nearly lies in a face. The angle is so small that the line in which they meet depends on round-off.
    Grazing,
}

/// Returns the kink of a pair, if any.
pub fn kink_of(pair: &ContactPair) -> Option<Kink> {
    first_kink(pair, &Measures::of(pair))
}

/// Returns the first of the pair's kinks.
pub fn first_kink(pair: &ContactPair, measures: &Measures) -> Option<Kink> {
    [
        blurred(measures),
        equal_fields(pair, measures),
        ridges(pair),
        grazing(pair),
    ]
    .into_iter()
    .flatten()
    .next()
}

/// Returns whether the pair is at a kink of the model: two tetrahedra with overlapping boxes have nearly equal gradients. Either their
/// plane moves [`FASTEST`] times as far as the bodies, or the kernel treats the gradients as equal.
fn equal_fields(pair: &ContactPair, measures: &Measures) -> Option<Kink> {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let Some(body_b) = pair.b().body() else {
        return equal_layer(pair, &pose_ab);
    };
    let bodies = [pair.a(), &body_b];
    let [a, b] = bodies.map(|body| (body.shape().field().tets(), body.modulus()));
    let mut worst = None;
    for tet_b in b.0 {
        let gradient_b = pose_ab.rotation() * tet_b.extent.gradient * b.1;
        let box_b = posed_box(tet_b, &pose_ab).inflated(measures.error);
        for tet_a in a.0 {
            let gradient_a = tet_a.extent.gradient * a.1;
            let difference = (gradient_a - gradient_b).norm();
            let alike = difference * FASTEST <= gradient_a.norm().min(gradient_b.norm());
            let sensitivity = (tet_a.sensitivity * a.1).max(tet_b.sensitivity * b.1);
            // The factor two covers pairs on either side of the limit.
            let kink = if alike {
                Kink::EqualFields
            } else if difference <= 2.0 * EQUAL_FIELDS * sensitivity {
                Kink::Unresolved
            } else {
                continue;
            };
            if worst != Some(Kink::Unresolved) && tet_a.tetrahedron.aabb().overlaps(&box_b) {
                worst = Some(kink);
            }
        }
    }
    worst
}

/// Returns the kink due to equal gradients in a compliant layer, for all tetrahedra that may be below its surface.
fn equal_layer(pair: &ContactPair, pose_ab: &Pose) -> Option<Kink> {
    let thickness = pair.b().half_space_shape()?.thickness()?;
    let normal = pose_ab.rotation().column(2).into_owned();
    let steepness = pair.b().modulus()? / thickness;
    let (field, modulus) = (pair.a().shape().field(), pair.a().modulus());
    let near = GRAZING_DISTANCE * field.reach();
    let mut worst = None;
    for tet in field.tets() {
        let gradient = tet.extent.gradient * modulus;
        let difference = (gradient + normal * steepness).norm();
        let height = |corner: &Vector3<f64>| normal.dot(&(corner - pose_ab.translation()));
        if tet
            .tetrahedron
            .corners
            .iter()
            .all(|corner| height(corner) > near)
        {
            continue;
        }
        if difference * FASTEST <= gradient.norm().min(steepness) {
            worst = worst.or(Some(Kink::EqualFields));
        } else if difference <= 2.0 * EQUAL_FIELDS * (tet.sensitivity * modulus).max(steepness) {
            worst = Some(Kink::Unresolved);
        }
    }
    worst
}

/// Returns whether lines in which planes meet are blurred. At the smallest possible angle, the least height divided by the reach, the error
/// of the line is the error of a coordinate divided by the angle.
fn blurred(measures: &Measures) -> Option<Kink> {
    let blur = measures.blur(measures.error);
    (ROOM * blur > 1.0).then_some(Kink::Blurred)
}

/// Returns whether the boxes around the highest vertices of both bodies overlap with equal pressures.
fn ridges(pair: &ContactPair) -> Option<Kink> {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let ridge = |body: &ContactBody, pose: &Pose| {
        let field = body.shape().field();
        let highest = field.extents().iter().copied().fold(0.0, f64::max);
        let vertices = field.mesh().vertices().iter().zip(field.extents());
        let on_top: Vec<_> = vertices
            .filter(|(_, extent)| **extent >= highest)
            .map(|(vertex, _)| pose.transformed_point(vertex))
            .collect();
        (highest * body.modulus(), Aabb::around(&on_top))
    };
    let b = pair.b().body()?;
    let (pressure_a, box_a) = ridge(pair.a(), &Pose::identity());
    let (pressure_b, box_b) = ridge(&b, &pose_ab);
    let reach = pair.a().shape().field().reach() + b.shape().field().reach();
    let is_same = (pressure_a - pressure_b).abs() <= RIDGE * pressure_a.max(pressure_b);
    (is_same && box_a.overlaps(&box_b.inflated(RIDGE * reach))).then_some(Kink::Ridges)
}

/// Returns whether a polygon of the contact surface grazes a face of one of its tetrahedra.
fn grazing(pair: &ContactPair) -> Option<Kink> {
    // A rigid body and a half-space have no inner faces.
    let bodies: Vec<_> = [Some(*pair.a()), pair.b().body()]
        .into_iter()
        .flatten()
        .collect();
    let reach = Measures::of(pair).reach;
    let near = GRAZING_DISTANCE * (reach[0] + reach[1]);
    let grazes = |polygon: &ContactPolygon| {
        bodies.iter().zip(polygon.tets).any(|(body, tet)| {
            let inverse = body.pose().inverse();
            let normal = inverse.rotation() * polygon.normal;
            let tet = &body.shape().field().tets()[tet];
            tet.barycentric
                .iter()
                .zip(tet.barycentric_steepness)
                .any(|(face, steepness)| {
                    let tilt = normal.cross(&face.gradient).norm() / steepness;
                    let is_near = |corner: &Vector3<f64>| {
                        let distance =
                            face.at(&inverse.transformed_point(corner)).abs() / steepness;
                        (MARGIN * near / GRAZING_DISTANCE..=near).contains(&distance)
                    };
                    tilt <= GRAZING_TILT && polygon.outline.corners().iter().any(is_near)
                })
        })
    };
    pair.surface()
        .polygons
        .iter()
        .any(grazes)
        .then_some(Kink::Grazing)
}

fn posed_box(tet: &FieldTet, pose: &Pose) -> Aabb {
    Aabb::around(
        &tet.tetrahedron
            .corners
            .map(|corner| pose.transformed_point(&corner)),
    )
}
