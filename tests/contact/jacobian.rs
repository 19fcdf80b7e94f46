//! Dual-number and closed-form Jacobians against central differences and each other.
#![allow(clippy::float_cmp, reason = "where nothing touches, zeros are exact")]

use crate::support::differences::{at_rest, by_motion, central_difference};
use crate::support::moving::{Scene, jacobian_of, numbers, seeds};
use crate::support::scenes::{Random, mixed_shapes, pair, random_pair};
use crate::support::worlds::{at, icosphere, turned};
use hydroelastic::contact::{ContactBody, ContactPair, Culling, Search};
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::scalar::DenseDual;
use hydroelastic::spatial::Pose;
use nalgebra::{SMatrix, SVector, vector};
use num_dual::{DualNum, DualSVec64, jacobian};

/// Agreement of a Jacobian with differences, relative to its largest entry.
const DIFFERENCES: f64 = 1e-7;

/// Agreement of two successive differences, at which their common value counts as the derivative.
const PLATEAU: f64 = 2e-8;

/// Agreement of the two Jacobians, relative to the largest entry: the rounding error of a derivative through well-conditioned slices and
/// clips, as for generic pairs.
const TWO_WAYS: f64 = 1e-10;

/// Rounding error of a wrench summed from other integrals.
const SAME_WRENCH: f64 = 1e-12;

/// Rounding error of sums of second moments about the other body's origin.
const EXCHANGED: f64 = 1e-11;

/// Steps (m, rad, relative modulus), from the largest, at which the third derivative dominates the error, to the smallest, at which the
/// rounding of the wrench dominates.
const STEPS: [f64; 4] = [1e-5, 1e-6, 1e-7, 1e-8];

/// Returns the central difference on which two successive steps agree.
///
/// A difference that straddles a change of topology (a corner of a polygon moves to another edge) has an error from the jump of a higher
/// derivative. The next smaller step then gives a different value. A sufficiently small step lies between two changes of topology.
fn plateau(pair: &ContactPair) -> Option<SMatrix<f64, 6, 14>> {
    let mut coarse = central_difference(pair, STEPS[0]);
    STEPS[1..].iter().find_map(|&step| {
        let fine = central_difference(pair, step);
        let agree = (fine - coarse).amax() <= PLATEAU * fine.amax();
        coarse = fine;
        agree.then_some(fine)
    })
}

#[test]
fn both_jacobians_equal_differences_at_every_generic_pose() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(1));
    let (mut compared, mut worst, mut worst_two_ways) = (0, 0.0_f64, 0.0_f64);
    while compared < 1_000 {
        let pair = random_pair(&shapes, &mut random);
        if pair.surface().is_empty() {
            continue;
        }
        let differences = plateau(&pair).expect("two steps agree at every pose");
        let scale = differences.amax();
        let closed = at_rest(&pair.linearized().jacobian());
        let dual = at_rest(&dual_wrench_jacobian(&pair).1);
        for jacobian in [closed, dual] {
            let error = (by_motion(&jacobian, &pair) - differences).amax();
            worst = worst.max(error / scale);
            assert!(
                error <= DIFFERENCES * scale,
                "pose {compared}: {error:e} of {scale:e}"
            );
        }
        let error = by_motion(&(closed - dual), &pair).amax();
        worst_two_ways = worst_two_ways.max(error / scale);
        assert!(
            error <= TWO_WAYS * scale,
            "pose {compared}: {error:e} of {scale:e}"
        );
        compared += 1;
    }
    println!("worst of {compared}: {worst:.1e}, between the two: {worst_two_ways:.1e}");
}

#[test]
fn the_wrench_that_comes_with_a_jacobian_is_the_wrench() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(2));
    for _ in 0..200 {
        let pair = random_pair(&shapes, &mut random);
        let (alone, together) = (pair.wrench(), pair.linearized().wrench);
        for (a, b) in [(alone.on_a, together.on_a), (alone.on_b, together.on_b)] {
            let (a, b) = (a.to_vector(), b.to_vector());
            assert!((a - b).amax() <= SAME_WRENCH * a.amax(), "{a} {b}");
        }
    }
}

#[test]
fn the_jacobian_of_the_wrench_on_b_is_the_one_of_exchanged_bodies() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(3));
    for _ in 0..200 {
        let pair = random_pair(&shapes, &mut random);
        let exchanged = ContactPair::new(pair.b().body().unwrap(), *pair.a());
        let (actual, expected) = (pair.linearized(), exchanged.linearized());
        let scale = at_rest(&expected.jacobian()).amax();
        let exchanged = |column: usize, half: usize| (column + half) % (2 * half);
        let by_poses = SMatrix::<f64, 6, 12>::from_fn(|row, column| {
            actual.by_poses[(row + 6, exchanged(column, 6))] - expected.by_poses[(row, column)]
        });
        let by_moduli = SMatrix::<f64, 6, 2>::from_fn(|row, column| {
            actual.by_moduli[(row + 6, exchanged(column, 1))] - expected.by_moduli[(row, column)]
        });
        let error = by_poses.amax().max(by_moduli.amax());
        assert!(error <= EXCHANGED * scale, "{error} of {scale}");
    }
}

/// A culling search sums the polygons in another order than a tracing search, so the last bits differ.
#[test]
fn the_jacobian_by_dual_numbers_keeps_the_search() {
    let ball = icosphere(1.0, 2);
    let there = turned([0.3, -0.2, 0.5], [0.9, 0.5, 0.3]);
    let followed = pair((&ball, Pose::identity(), 1.0), (&ball, there, 2.0));
    let culled = followed.with_search(Search::Culling(Culling::default()));
    let [by_following, by_culling] =
        [followed, culled].map(|pair| dual_wrench_jacobian(&pair).0.on_a.to_vector());
    assert_ne!(by_following, by_culling);
    let in_duals = |pose: Pose, modulus: f64| {
        ContactBody::new(&ball, Pose::lifted(&pose), DenseDual::<28>::from(modulus)).unwrap()
    };
    let in_duals = ContactPair::new(in_duals(Pose::identity(), 1.0), in_duals(there, 2.0));
    let expected = in_duals.with_search(Search::Culling(Culling::default()));
    let expected = expected.pipeline().wrench().on_a.real().to_vector();
    assert_eq!(by_culling, expected);
}

#[test]
fn bodies_apart_have_no_surface_no_wrench_and_no_derivatives() {
    let ball = icosphere(1.0, 1);
    let there = at(3.0, 0.0, 0.0);
    let pair = pair((&ball, Pose::identity(), 1.0), (&ball, there, 1.0));
    let surface = pair.surface();
    assert!(surface.is_empty() && surface.center_of_pressure().is_none());
    assert!(pair.touching_tets().is_empty());
    assert_eq!([surface.area(), pair.potential_energy()], [0.0; 2]);
    let contact = pair.linearized();
    let closed = (contact.wrench, contact.jacobian());
    for (wrench, jacobian) in [closed, dual_wrench_jacobian(&pair)] {
        assert_eq!(wrench.on_a.to_vector().amax(), 0.0);
        assert_eq!(jacobian.amax(), 0.0);
    }
    // Wrenches of first order, elastic and in motion.
    let scene = Scene::at_random(&pair, &mut Random::new(1));
    let (pair, law, twists) = scene.changed(&seeds());
    for wrench in [pair.wrench(), pair.moving(law, twists).wrench()] {
        assert!(numbers(&wrench).iter().all(|n| n.re == 0.0));
        assert!(jacobian_of(&wrench).iter().all(|&slope| slope == 0.0));
    }
}

/// The chain rule needs no type of this library. The user's own parameters, here a position along a curve, are passed as dual numbers, and
/// the result carries their derivatives.
#[test]
fn num_dual_differentiates_by_parameters_of_ones_own() {
    let ball = icosphere(1.0, 1);
    let along = |s: SVector<DualSVec64<1>, 1>| {
        let position = vector![s[0].sin() * 0.3, s[0] * s[0], -s[0].cos() * 1.6];
        let a = ContactBody::new(&ball, Pose::from_translation(position), 2.0.into()).unwrap();
        let b = ContactBody::new(&ball, Pose::identity(), 3.0.into()).unwrap();
        ContactPair::new(a, b).wrench().on_a.to_vector()
    };
    let s: f64 = 0.4;
    let (_, by_s) = jacobian(along, &vector![s]);
    let position = vector![s.sin() * 0.3, s * s, -s.cos() * 1.6];
    let pair = pair(
        (&ball, Pose::from_translation(position), 2.0),
        (&ball, Pose::identity(), 3.0),
    );
    let velocity = vector![0.0, 0.0, 0.0, s.cos() * 0.3, 2.0 * s, s.sin() * 1.6];
    let expected = pair.linearized().by_poses.fixed_view::<6, 6>(0, 0) * velocity;
    assert!((by_s - expected).amax() <= TWO_WAYS * expected.amax());
}
