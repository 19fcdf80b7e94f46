//! Where the model has a kink, or round-off decides.

use super::measures::{FASTEST, MARGIN, Measures, ROOM};
use hydroelastic::contact::{ContactBody, ContactPair, ContactPolygon};
use hydroelastic::geometry::Aabb;
use hydroelastic::mesh::FieldTet;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;

/// Gradients that differ by less, relative to the sensitivity of either field, count as equal.
pub const EQUAL_FIELDS: f64 = 1e-9;

/// Ridges are the same that differ by no more, relative to reach and pressure.
const RIDGE: f64 = 1e-8;

/// A polygon and a face that graze are so nearly parallel.
const GRAZING_TILT: f64 = 1e-6;

/// A corner of a polygon that grazes a face is so near to it, relative to the reach: the contact surface with a body
/// 1e8 times as stiff lies no further below its faces, and tilted by no more.
const GRAZING_DISTANCE: f64 = 1e-8;

/// Where the model has a kink, so that forces jump or change faster than a step resolves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kink {
    /// The fields of two tetrahedra that overlap are nearly equal.
    EqualFields,
    /// They are not, but their difference is below what the kernel resolves: one is a plateau, or nearly.
    Unresolved,
    /// The highest pressures of both bodies are the same at the same place: as one ridge passes the other, the
    /// contact surface between them turns over, and its force jumps to the opposite.
    Ridges,
    /// Tetrahedra are so thin, or the bodies so unlike in size, that the lines where planes meet are placed
    /// worse than one part in [`ROOM`] of the smaller body.
    Blurred,
    /// The contact surface nearly, but not quite, lies in a face, tilted by so little that the line where they meet is placed
    /// by round-off.
    Grazing,
}

/// The kink a pair is at, if it is at one.
pub fn kink_of(pair: &ContactPair) -> Option<Kink> {
    first_kink(pair, &Measures::of(pair))
}

/// The first of its kinks.
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

/// Whether the pair is at a kink of the model. Two tetrahedra whose boxes overlap have gradients so much
/// alike that their plane moves [`FASTEST`] times as far as the bodies, or that the kernel takes them for
/// equal.
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
            // Twice: a pair at the limit may be on either side of it.
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

/// The same of a soft layer, in all tetrahedra that may be below its surface.
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

/// Planes that meet at the flattest angle there is, the least height over the reach, meet in a line that is
/// off by the error of a coordinate over that angle.
fn blurred(measures: &Measures) -> Option<Kink> {
    let blur = measures.blur(measures.error);
    (ROOM * blur > 1.0).then_some(Kink::Blurred)
}

/// Whether the boxes around the highest vertices of both bodies meet, and the pressures there are the same.
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

/// Whether a polygon of the contact surface grazes a face of one of its tetrahedra.
fn grazing(pair: &ContactPair) -> Option<Kink> {
    // A rigid body and a half-space have no faces inside.
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
