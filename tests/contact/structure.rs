//! Invariants at every pose: balance, symmetry, homogeneity, and the wrench as derivative of an energy. Each is checked for the closed form
//! and for dual numbers.

use crate::partners::Shapes;
use crate::support::scenes::{Random, mixed_shapes, pair, random_pair};
use crate::support::worlds::{at, cuboid, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair, ContactWrench};
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Twist, skew};
use nalgebra::{Matrix3, SMatrix, SVector, Vector6};
use num_dual::{DualSVec64, gradient};

/// Rounding errors of a wrench between two compliant bodies, and with a rigid body or a half-space.
const BALANCE: [f64; 2] = [1e-13, 1e-12];

/// Rounding error of sums of second moments, relative to the largest entry.
const SYMMETRY: f64 = 1e-11;

/// Rounding error of a wrench summed in another order or frame.
const SAME: f64 = 1e-12;

/// Rounding error of the length of a unit vector.
const UNIT: f64 = 1e-14;

/// Rounding error of the derivatives with respect to the moduli.
const HOMOGENEITY: f64 = 1e-12;

/// Rounding error of a derivative through about a hundred thousand clipped tetrahedra.
const ENERGY: f64 = 1e-11;

pub(super) fn for_random_pairs(count: usize, seed: u8, check: impl Fn(&ContactPair)) {
    let (shapes, mut random) = (mixed_shapes(), Random::new(seed));
    for _ in 0..count {
        check(&random_pair(&shapes, &mut random));
    }
}

/// Visits compliant pairs, and 60 % as many touching pairs with a rigid body or a half-space.
fn for_all_pairs(count: usize, seed: u8, check: impl Fn(&ContactPair)) {
    for_random_pairs(count, seed, &check);
    let partners = Shapes::mixed();
    partners.for_pairs(count * 3 / 5, seed, |pair, _| check(pair));
}

pub(super) fn both_ways(pair: &ContactPair) -> [(ContactWrench, SMatrix<f64, 12, 28>); 2] {
    let contact = pair.linearized();
    [
        (contact.wrench, contact.jacobian()),
        dual_wrench_jacobian(pair),
    ]
}

/// Returns the vector from A's origin to B's, in the world.
fn lever(pair: &ContactPair) -> nalgebra::Vector3<f64> {
    pair.b().pose().translation() - pair.a().pose().translation()
}

#[test]
fn forces_and_moments_balance() {
    for_all_pairs(500, 11, |pair| {
        let balance = BALANCE[usize::from(pair.b().body().is_none())];
        let ContactWrench { on_a, on_b } = pair.wrench();
        assert!((on_a.force + on_b.force).amax() <= balance * on_a.force.amax());
        let shifted = lever(pair).cross(&on_b.force);
        let moment = on_a.torque + on_b.torque + shifted;
        // The scale uses lever times force. If lever and force are nearly parallel, their product is small and carries the rounding errors
        // of larger terms.
        let scale = on_a.torque.amax() + lever(pair).norm() * on_a.force.norm();
        assert!(moment.amax() <= balance * scale, "{moment} {scale:e}");
    });
}

#[test]
fn exchanging_the_bodies_exchanges_the_wrenches() {
    for_random_pairs(500, 12, |pair| {
        let (wrench, exchanged) = (
            pair.wrench(),
            ContactPair::new(pair.b().body().unwrap(), *pair.a()).wrench(),
        );
        let error = (wrench.on_a.to_vector() - exchanged.on_b.to_vector()).amax();
        assert!(error <= SAME * wrench.on_a.to_vector().amax(), "{error:e}");
    });
}

#[test]
fn moving_the_world_turns_the_wrench_with_it() {
    let motion = Pose::from_rotation_vector(&[0.3, -1.2, 0.8].into(), [1.0, -2.0, 0.5].into());
    for_all_pairs(500, 13, |pair| {
        let (a, b) = (pair.a(), pair.b());
        let moved = ContactPair::new(
            ContactBody::new(a.shape(), motion * *a.pose(), a.modulus()).unwrap(),
            b.at(motion * *b.pose(), b.modulus().unwrap_or(1.0))
                .unwrap(),
        );
        let expected = pair.wrench().on_a.rotated(motion.rotation()).to_vector();
        let error = (moved.wrench().on_a.to_vector() - expected).amax();
        assert!(error <= SAME * expected.amax(), "{error:e}");
    });
}

/// The derivative of the wrench on a body about its own origin, with respect to its own pose, is minus the second derivative of the energy.
/// Rotations do not commute, so the rotational block contains the torque.
#[test]
fn the_stiffness_is_symmetric_up_to_half_the_torque() {
    for_random_pairs(300, 14, |pair| {
        for (wrench, jacobian) in both_ways(pair) {
            for (torque, first) in [(wrench.on_a.torque, 0), (wrench.on_b.torque, 6)] {
                let stiffness = jacobian.fixed_view::<6, 6>(first, first).into_owned();
                let asymmetry = (stiffness - stiffness.transpose()) / 2.0;
                let block = |i, j| -> Matrix3<f64> { asymmetry.fixed_view::<3, 3>(i, j).into() };
                let scale = SYMMETRY * stiffness.amax();
                assert!(block(3, 3).amax() <= scale, "force by translation");
                assert!(
                    block(0, 3).amax() <= scale,
                    "torque by translation, force by rotation"
                );
                let half_torque = skew(&torque) / 2.0;
                assert!(
                    (block(0, 0) + half_torque).amax() <= scale,
                    "torque by rotation"
                );
            }
        }
    });
}

#[test]
fn the_wrench_is_homogeneous_of_degree_one_in_the_moduli() {
    for_random_pairs(300, 15, |pair| {
        for (wrench, jacobian) in both_ways(pair) {
            let moduli = [pair.a().modulus(), pair.b().modulus().unwrap()];
            for (row, wrench) in [(0, wrench.on_a), (6, wrench.on_b)] {
                let [by_a, by_b] =
                    [0, 1].map(|body| jacobian.fixed_view::<6, 1>(row, 24 + body) * moduli[body]);
                let sum = by_a + by_b;
                let scale = by_a.amax() + wrench.to_vector().amax();
                let error = (sum - wrench.to_vector()).amax();
                assert!(error <= HOMOGENEITY * scale, "{error:e} of {scale:e}");
            }
        }
    });
}

/// Returns the pair in `T`, moved by twists.
pub(super) fn moved<'a, T: Scalar>(
    pair: &ContactPair<'a>,
    twist_a: &Vector6<T>,
    twist_b: &Vector6<T>,
) -> ContactPair<'a, T> {
    let pose = |pose, twist| Pose::lifted(pose).moved_by(&Twist::from_vector(twist));
    let (a, b) = (pair.a(), pair.b());
    let modulus_b = lift(b.modulus().unwrap_or(1.0));
    ContactPair::new(
        ContactBody::new(a.shape(), pose(a.pose(), twist_a), lift(a.modulus())).unwrap(),
        b.at(pose(b.pose(), twist_b), modulus_b).unwrap(),
    )
}

#[test]
fn the_wrench_is_minus_the_gradient_of_the_energy() {
    for_all_pairs(100, 16, |pair| {
        let energy = |motion: SVector<DualSVec64<12>, 12>| {
            let twist = |row| motion.fixed_rows::<6>(row).into_owned();
            moved(pair, &twist(0), &twist(6)).potential_energy()
        };
        let (value, slope) = gradient(energy, &SVector::zeros());
        assert!(value > 0.0);
        let wrench = pair.wrench();
        for (row, wrench) in [(0, wrench.on_a), (6, wrench.on_b)] {
            let error = (wrench.to_vector() + slope.fixed_rows::<6>(row)).amax();
            assert!(error <= ENERGY * wrench.to_vector().amax(), "{error:e}");
        }
    });
}

#[test]
fn the_surface_adds_up_to_the_wrench() {
    for_random_pairs(200, 17, |pair| {
        let (surface, wrench) = (pair.surface(), pair.wrench());
        let origin_a = pair.a().pose().translation();
        let mut sum = Vector6::zeros();
        for polygon in &surface.polygons {
            let torque = (polygon.center_of_pressure - origin_a).cross(&polygon.force());
            let force = polygon.force();
            sum += Vector6::from_iterator(torque.iter().chain(force.iter()).copied());
            assert!((polygon.normal.norm() - 1.0).abs() < UNIT && polygon.area > 0.0);
        }
        assert!((sum - wrench.on_a.to_vector()).amax() <= SAME * sum.amax());
    });
}

/// If one body is so soft that its pressure inside the other body is lower everywhere, no contact surface remains, but the soft body has
/// all of its energy. Bodies in contact or apart are not submerged. The energy is complete at any radius and modulus of the soft body.
#[test]
fn a_soft_body_within_a_hard_one_has_sunk_through_and_bodies_in_contact_or_apart_have_not() {
    let cube = cuboid([1.0; 3]);
    let hard = (&cube, Pose::identity(), 1e5);
    for (radius, softer) in [(0.1, 1.0), (0.1, 1e-6), (1e-4, 1.0), (1e-4, 1e-6)] {
        let ball = icosphere(radius, 1);
        for (x, modulus, has_sunk) in [
            (0.1, softer, true),
            (0.5 + 0.3 * radius, 1e5, false),
            (0.5 + 3.0 * radius, softer, false),
        ] {
            let ball = (&ball, at(x, 0.13, -0.07), modulus);
            for pair in [pair(ball, hard), pair(hard, ball)] {
                let has_sunk_through = pair.has_sunk_through();
                assert_eq!(has_sunk_through, has_sunk, "{x}, {radius} m, {modulus} Pa");
            }
        }
    }
    // In these pairs, all polygons lie on faces.
    let above = at(0.0, 0.0, 0.9);
    assert!(!pair((&cube, above, 1e5), hard).has_sunk_through());
}
