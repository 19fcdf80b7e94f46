//! Random and deliberately degenerate pairs: nothing is ever NaN or infinite, the wrench
//! balances, and no force exceeds the largest pressure times the area.

use crate::support::scenes::{Random, grid, pair};
use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3};

/// Rounding of a sum of pressures times areas.
const BOUND: f64 = 1.0 + 1e-9;

/// Third law, relative to the force.
const BALANCE: f64 = 1e-13;

/// Energy and force of round-off, relative to the largest pressure over the whole body: surfaces
/// that only touch leave so much.
const ENERGY: f64 = 1e-15;

/// Every so many pairs, the dual numbers are run as well: they take ten times as long.
const DUAL_EVERY: usize = 4;

/// Scales a pair may have (m).
const SCALES: [f64; 3] = [1e-6, 1.0, 1e6];

/// How far from the world's origin a pair may be, in its own sizes.
const DISTANCES: [f64; 3] = [0.0, 1.0, 1e4];

/// Few tetrahedra, many coincidences: faces, edges and vertices on a grid of quarters.
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

/// A rotation that takes the axes to axes.
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

/// Relative poses: generic, aligned on a grid of quarters (faces, edges and vertices that touch or
/// coincide, one body inside the other), and the same shaken by 1e-16 to 1e-4.
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
    let (wrench, jacobian) = pair.wrench_and_jacobian();
    let force = wrench.on_a.force;
    assert!(wrench.on_a.to_vector().iter().all(|x| x.is_finite()));
    assert!(wrench.on_b.to_vector().iter().all(|x| x.is_finite()));
    assert!(jacobian.on_a.matrix().iter().all(|x| x.is_finite()));
    assert!(jacobian.on_b.matrix().iter().all(|x| x.is_finite()));
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
        assert!(jacobian.on_a.matrix().iter().all(|x| x.is_finite()));
        assert!(jacobian.on_b.matrix().iter().all(|x| x.is_finite()));
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
