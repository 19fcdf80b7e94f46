//! Comparison of octets with pairs that are classified and cut one at a time.

use super::*;
use crate::contact_shape::{ContactBody, HalfSpace, Partner, RigidShape, Shape};
use crate::lanes;
use crate::mesh::{TriangleSurface, shapes};
use crate::narrow_phase::{EquilibriumPlane, PairClass};
use crate::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Error of a corner, for bodies of size 1. Clips in other coordinates round differently. The error is larger if planes meet at a small
/// angle.
const CLOSE: f64 = 1e-9;

fn pairs_of(pair: &RelativePair) -> Vec<[u32; 2]> {
    let cells_b = pair.shape_b.cells();
    let of_a = (0_u32..).zip(pair.shape_a.field().tets());
    let all = of_a.flat_map(|(i, _)| (0_u32..).zip(cells_b).map(move |(j, _)| [i, j]));
    all.filter(|[i, j]| {
        let of_b = pair.posed_tet(*j as usize).tetrahedron.aabb();
        pair.tet_a(*i as usize).tetrahedron.aabb().overlaps(&of_b)
    })
    .collect()
}

/// Returns whether two polygons are equal, except that they may begin with different corners.
fn are_same(a: &ConvexPolygon, b: &ConvexPolygon) -> bool {
    let count = a.corners().len();
    let is_turned = |turn: usize| {
        (0..count).all(|k| {
            let from = (k + turn) % count;
            (a.corners()[from] - b.corners()[k]).norm() < CLOSE && a.owners()[from] == b.owners()[k]
        })
    };
    count == b.corners().len() && (0..count).any(is_turned)
}

/// Returns ∫ 1 dA, ∫ x dA and ∫ x xᵀ dA of a polygon, in the first entry, the first column and all entries of three matrices. Splits the
/// polygon into triangles at its first corner, and applies the edge midpoint rule to each triangle.
fn moments_of(cut: &Cut, normal: &Vector3<f64>) -> [Matrix3<f64>; 3] {
    let mut moments = [Matrix3::zeros(); 3];
    let corners = cut.polygon.corners();
    for pair in corners[1..].windows(2) {
        let [a, b, c] = [corners[0], pair[0], pair[1]];
        let area = 0.5 * (b - a).cross(&(c - a)).dot(normal);
        for middle in [a + b, b + c, c + a].map(|sum| sum * 0.5) {
            moments[0][0] += area / 3.0;
            let first = moments[1].column(0) + middle * (area / 3.0);
            moments[1].set_column(0, &first);
            moments[2] += middle * middle.transpose() * (area / 3.0);
        }
    }
    moments
}

/// Asserts that an octet has the plane and the polygon moments of a pair that was cut alone. The tolerance of lengths is [`CLOSE`]. The
/// tolerance of pressures is [`CLOSE`] times the pressure gradients.
fn assert_rows_agree(octet: &Octet, index: usize, pair: &RelativePair, cut: &Cut) {
    let [a, b] = [pair.tet_a(cut.tets[0]), pair.tet_b(cut.tets[1])];
    let pressure_a = a.extent.scaled(pair.modulus_a);
    let plane = if pair.shape_b.is_rigid() {
        EquilibriumPlane::of_rigid(&cut.field_b)
    } else {
        EquilibriumPlane::between(&pressure_a, &cut.field_b)
    };
    let at = |rows: &[Row; 3]| vector_at(rows, index);
    let [e1, e2, normal] = octet.axes.each_ref().map(at);
    let origin = at(&octet.origin);
    assert!((normal - plane.normal).norm() < CLOSE);
    assert!((e1.cross(&e2) - normal).norm() < CLOSE && e1.dot(&e2).abs() < CLOSE);
    assert!(plane.height_at(&origin).abs() < CLOSE);
    for (slope, expected) in octet.slopes.iter().zip(&plane.slopes) {
        assert!((at(slope) - expected).norm() < CLOSE * (1.0 + expected.norm()));
    }
    let [expected_area, expected_first, expected_second] = moments_of(cut, &plane.normal);
    let [area, y1, y2, y11, y12, y22] = octet.moments.map(|row| row[index]);
    let in_plane = e1 * y1 + e2 * y2;
    let of_pairs = (e1 * e1.transpose()) * y11
        + (e1 * e2.transpose() + e2 * e1.transpose()) * y12
        + (e2 * e2.transpose()) * y22;
    let first = origin * area + in_plane;
    let second = origin * origin.transpose() * area
        + origin * in_plane.transpose()
        + in_plane * origin.transpose()
        + of_pairs;
    assert!((area - expected_area[0]).abs() < CLOSE);
    assert!((first - expected_first.column(0)).norm() < CLOSE);
    assert!((second - expected_second).norm() < CLOSE);
    // Along the plane, both fields have the same gradient.
    let close = CLOSE * (pair.modulus_a * a.sensitivity + pair.scales[1] * b.sensitivity);
    let gradient = pressure_a.gradient;
    assert!((at(&octet.gradient_a) - gradient).norm() < close);
    let pressure = [pressure_a.at(&origin), gradient.dot(&e1), gradient.dot(&e2)];
    for (row, expected) in octet.pressure.iter().zip(pressure) {
        assert!((row[index] - expected).abs() < close);
    }
}

/// Asserts that octets and single pairs have the same classes and polygons. Returns the number of pairs with a polygon, and the number of
/// special pairs.
fn assert_decided_alike(pair: &RelativePair) -> [usize; 2] {
    let posed: Vec<PosedTet> = (0..pair.shape_b.cells().len())
        .map(|tet| pair.posed_tet(tet))
        .collect();
    let (mut polygons, mut special) = (0, 0);
    for pairs in pairs_of(pair).chunks(ROW) {
        let mut octet = Octet::empty();
        octet.fill_with(pairs);
        lanes::run(CutOctets {
            pair,
            posed: |tet: u32| &posed[tet as usize],
            octets: std::slice::from_mut(&mut octet),
        });
        for (index, [a, b]) in pairs
            .iter()
            .map(|tets| tets.map(|tet| tet as usize))
            .enumerate()
        {
            if octet.is_special(index) {
                special += 1;
                continue;
            }
            let PairClass::Intersecting(decisions) = pair.classify(pair.tet_a(a), &posed[b], true)
            else {
                assert!(!octet.has_polygon(index));
                assert_eq!(octet.reached_faces(index, &posed[b]), 0);
                continue;
            };
            let cut = pair.cut(pair.tet_a(a), &posed[b], decisions);
            assert_eq!(octet.has_polygon(index), cut.counts());
            assert_eq!(octet.reached_faces(index, &posed[b]), cut.reached());
            if cut.counts() {
                polygons += 1;
                let octet_cut = octet.cut(index, pair, &posed[b]);
                assert!(
                    are_same(&octet_cut.polygon, &cut.polygon),
                    "{octet_cut:?} {cut:?}"
                );
                assert_rows_agree(&octet, index, pair, &cut);
                assert!(octet_cut.weights().are_whole() && cut.weights().are_whole());
            }
        }
    }
    [polygons, special]
}

#[test]
fn generic_pairs_have_the_polygons_that_one_by_one_have() {
    let mut random = StdRng::seed_from_u64(7);
    let ball = Shape::new(shapes::icosphere(0.5, 1).unwrap());
    let block = Shape::new(shapes::cuboid([0.9, 0.7, 0.8]).unwrap());
    let layered = Shape::new(shapes::distance_cuboid([0.8, 0.8, 0.8]).unwrap());
    let shapes = [&ball, &block, &layered];
    let (mut polygons, mut special) = (0, 0);
    for _ in 0..60 {
        let [a, b] = [0, 1].map(|_| shapes[random.random_range(0..3)]);
        let mut vector = |size: f64| Vector3::from_fn(|_, _| random.random_range(-size..size));
        let pose = Pose::from_rotation_vector(&vector(1.5), vector(0.4));
        let a = ContactBody::new(a, Pose::identity(), 1e4).unwrap();
        let b = Partner::from(ContactBody::new(b, pose, 3e4).unwrap());
        let [more, few] = assert_decided_alike(&RelativePair::of(&a, &b, &pose));
        (polygons, special) = (polygons + more, special + few);
    }
    assert!(polygons > 2000, "{polygons}");
    assert!(100 * special < polygons, "{special} of {polygons}");
}

#[test]
fn generic_pairs_with_cells_have_the_polygons_that_one_by_one_have() {
    let mut random = StdRng::seed_from_u64(8);
    let ball = Shape::new(shapes::icosphere(0.5, 1).unwrap());
    let round = TriangleSurface::around(shapes::icosphere(0.4, 1).unwrap().mesh());
    let round = RigidShape::new(round.unwrap());
    let layer = HalfSpace::layer(0.1).unwrap();
    let (mut polygons, mut special) = ([0; 3], 0);
    for _ in 0..30 {
        let mut vector = |size: f64| Vector3::from_fn(|_, _| random.random_range(-size..size));
        let pose = Pose::from_rotation_vector(&vector(1.5), vector(0.3));
        let a = ContactBody::new(&ball, Pose::identity(), 1e4).unwrap();
        let partners = [
            Partner::rigid(&round, pose).unwrap(),
            Partner::rigid_half_space(pose).unwrap(),
            Partner::half_space(&layer, pose, 3e4).unwrap(),
        ];
        for (b, polygons) in partners.iter().zip(&mut polygons) {
            let [more, few] = assert_decided_alike(&RelativePair::of(&a, b, &pose));
            (*polygons, special) = (*polygons + more, special + few);
        }
    }
    assert!(polygons.iter().all(|&count| count > 200), "{polygons:?}");
    assert!(
        100 * special < polygons.iter().sum(),
        "{special} of {polygons:?}"
    );
}

#[test]
fn aligned_boxes_are_special() {
    let block = Shape::new(shapes::cuboid([0.2, 0.2, 0.1]).unwrap());
    let pose = Pose::from_translation(Vector3::new(0.0, 0.0, 0.0995));
    let a = ContactBody::new(&block, Pose::identity(), 1e5).unwrap();
    let b = Partner::from(ContactBody::new(&block, pose, 1e5).unwrap());
    let [_, special] = assert_decided_alike(&RelativePair::of(&a, &b, &pose));
    assert!(special > 0);
}
