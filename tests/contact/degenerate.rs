//! Random and deliberately degenerate pairs. No result is NaN or infinite, the wrench balances, and no force exceeds the largest pressure
//! times the area.

use crate::support::scenes::{Random, grid, pair};
use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3, vector};

/// Bound of a force relative to pressures times areas, with the rounding error of their sum.
const BOUND: f64 = 1.0 + 1e-9;

/// Tolerance of Newton's third law, relative to the force.
const BALANCE: f64 = 1e-13;

/// Energy and force of round-off in surfaces that only touch, relative to the largest pressure over the whole body.
const ENERGY: f64 = 1e-15;

/// Error of the contact with slivers, relative to the force. The position error of a sliver's face is the rounding error divided by its
/// thickness.
const OF_SLIVERS: f64 = 1e-3;

/// Interval of the pairs that are also evaluated with dual numbers, which take ten times as long.
const DUAL_EVERY: usize = 4;

/// Scales of a pair (m).
const SCALES: [f64; 3] = [1e-6, 1.0, 1e6];

/// Distances of a pair from the world's origin, relative to its size.
const DISTANCES: [f64; 3] = [0.0, 1.0, 1e4];

/// Returns shapes with few tetrahedra and many coincidences: faces, edges and vertices are on a grid of quarters.
fn blocky_shapes(scale: f64) -> Vec<Shape> {
    let fields = [
        shapes::cuboid([scale; 3]),
        shapes::cuboid([0.25 * scale; 3]),
        shapes::cuboid([scale, 0.5 * scale, 1.5 * scale]),
        shapes::distance_cuboid([scale, 0.5 * scale, 1.5 * scale]),
        shapes::icosphere(0.5 * scale, 0),
        shapes::cylinder(0.5 * scale, scale, 4),
        grid(&[2, 2, 2], 0.5 * scale, |_| true),
        grid(&[2, 2, 1], 0.5 * scale, |[i, j, _]| i == 0 || j == 0),
    ];
    fields.map(|field| Shape::new(field.unwrap())).into()
}

/// Returns a rotation that maps axes to axes.
fn axis_rotation(random: &mut Random) -> Matrix3<f64> {
    let columns: [usize; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]][random.below(3)];
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]][random.below(4)];
    let signs = [signs[0], signs[1], signs[0] * signs[1]];
    Matrix3::from_fn(|row, column| {
        if columns[column] == row {
            signs[column]
        } else {
            0.0
        }
    })
}

/// Returns a relative pose: generic; aligned on a grid of quarters (faces, edges and vertices touch or coincide, or one body is inside the
/// other); or aligned and perturbed by 1e-16 to 1e-4.
fn relative_pose(random: &mut Random, scale: f64) -> Pose {
    let quarters = |random: &mut Random| {
        Vector3::from_fn(|_, _| (random.below(13) as f64 - 6.0) / 4.0 * scale)
    };
    match random.below(4) {
        0 => {
            let position = random.vector() * 0.8 * scale;
            Pose::from_rotation_vector(&random.rotation_vector(), position)
        }
        1 => Pose::from_translation(quarters(random)),
        2 => Pose::new(axis_rotation(random), quarters(random)).unwrap(),
        _ => {
            let size = 10_f64.powf(random.between(-16.0, -4.0));
            let position = quarters(random) + random.vector() * size * scale;
            let turned = Pose::new(axis_rotation(random), position).unwrap();
            turned * Pose::from_rotation_vector(&(random.vector() * size), Vector3::zeros())
        }
    }
}

fn modulus(random: &mut Random) -> f64 {
    [1.0, 1.0, 2.0, 1e7, random.between(0.5, 2.0)][random.below(5)]
}

fn check(pair: &ContactPair, with_duals: bool) {
    let contact = pair.linearized();
    let wrench = contact.wrench;
    let force = wrench.on_a.force;
    assert!(wrench.on_a.to_vector().iter().all(|x| x.is_finite()));
    assert!(wrench.on_b.to_vector().iter().all(|x| x.is_finite()));
    assert!(contact.jacobian().iter().all(|x| x.is_finite()));
    assert!((force + wrench.on_b.force).amax() <= BALANCE * force.amax());
    let surface = pair.surface();
    let largest = |body: &ContactBody| {
        let extents = body.shape().field().extents().iter();
        body.modulus() * extents.copied().fold(0.0, f64::max)
    };
    let pressure = largest(pair.a()).min(largest(&pair.b().body().unwrap()));
    let size = pair.a().shape().field().reach();
    let noise = ENERGY * pressure * size.powi(2);
    assert!(force.norm() <= pressure * surface.area() * BOUND + noise);
    for polygon in &surface.polygons {
        assert!(polygon.centroid.iter().all(|x| x.is_finite()) && polygon.pressure.is_finite());
    }
    assert!(pair.potential_energy() >= -ENERGY * pressure * size.powi(3));
    if with_duals {
        let (_, jacobian) = dual_wrench_jacobian(pair);
        assert!(jacobian.iter().all(|x| x.is_finite()));
    }
}

fn soak(pairs: usize, seed: u8) {
    let shapes = SCALES.map(blocky_shapes);
    let mut random = Random::new(seed);
    for index in 0..pairs {
        let which = random.below(SCALES.len());
        let (scale, shapes) = (SCALES[which], &shapes[which]);
        let away = random.direction() * (DISTANCES[random.below(3)] * scale);
        let pose_wa = match random.below(2) {
            0 => Pose::from_translation(away),
            _ => Pose::from_rotation_vector(&random.rotation_vector(), away),
        };
        let pose_wb = pose_wa * relative_pose(&mut random, scale);
        let (a, b) = (random.below(shapes.len()), random.below(shapes.len()));
        let (modulus_a, modulus_b) = (modulus(&mut random), modulus(&mut random));
        let pair = pair(
            (&shapes[a], pose_wa, modulus_a),
            (&shapes[b], pose_wb, modulus_b),
        );
        check(&pair, index % DUAL_EVERY == 0);
    }
}

#[test]
fn nothing_is_ever_not_a_number() {
    soak(20_000, 41);
}

#[test]
#[ignore = "a minute: 100,000 pairs"]
fn nothing_is_ever_not_a_number_in_many_pairs() {
    soak(100_000, 41);
}

/// The body is a tetrahedron in four parts around a vertex that nearly lies in a face, so the flat part is a sliver, also in four parts. If
/// faces of both bodies nearly coincide, more than round-off counts as zero, and the walk over the contact surface passes the ends of the
/// slivers.
#[test]
fn slivers_beyond_the_end_of_a_body_add_nothing() {
    let corners = [
        [1.0; 3],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    let whole = TetMesh::new(corners.map(Vector3::from).into(), vec![[0, 1, 2, 3]]).unwrap();
    let whole = Shape::new(PressureField::from_distance(&whole).unwrap());
    let vertices = vec![
        vector![-0.5, -0.4, 0.0],
        vector![0.6, -0.3, 0.0],
        vector![0.0, 0.7, 0.0],
        vector![0.1, 0.1, 0.8],
        vector![0.1, 0.0, 2.855_878_654_617_387_4e-9],
        vector![
            0.576_879_298_322_336_5,
            -0.277_220_078_234_177_5,
            6.463_131_415_510_657e-11
        ],
    ];
    let around_both = [[5, 1, 2, 4], [0, 5, 2, 4], [0, 1, 5, 4], [0, 1, 2, 5]];
    let mut tets = vec![[4, 1, 2, 3], [0, 1, 4, 3], [0, 4, 2, 3]];
    tets.extend(around_both);
    let extents = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0];
    let parts = TetMesh::new(vertices, tets).unwrap();
    let parts = Shape::new(PressureField::new(parts, extents).unwrap());
    let rotation = Matrix3::from_column_slice(&[
        0.664_782_892_998_979_2,
        0.055_364_601_227_669_94,
        -0.744_982_191_805_152_2,
        0.447_583_074_817_576_3,
        -0.827_957_891_697_801_1,
        0.337_868_496_181_837_2,
        -0.598_107_930_320_900_8,
        -0.558_050_616_437_463_7,
        -0.575_192_500_977_729_1,
    ]);
    let translation = vector![
        0.735_422_783_400_677_2,
        -1.281_588_532_230_403_5,
        -0.451_632_534_399_818_9
    ];
    let pose = Pose::new(rotation, translation).unwrap();
    let at = |move_by: Vector3<f64>| {
        let a = (&whole, Pose::from_translation(move_by), 1.0);
        pair(a, (&parts, pose, 0.809_211_131_100_106_3))
    };
    let energy = |axis: usize, step: f64| at(Vector3::ith(axis, step)).potential_energy();
    let slope = |axis, _| (energy(axis, 1e-5) - energy(axis, -1e-5)) / 2e-5;
    let expected = -Vector3::from_fn(slope);
    let error = (at(Vector3::zeros()).wrench().on_a.force - expected).norm() / expected.norm();
    assert!(error <= OF_SLIVERS, "{error:e}");
}
