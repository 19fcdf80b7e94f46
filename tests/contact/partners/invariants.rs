//! Invariants at every pose and for every partner: homogeneity, reciprocity, and the closed form against dual numbers through the clips.
//! `structure.rs` tests balance, frames and energy.

use super::Shapes;
use hydroelastic::contact::ContactPair;
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::spatial::skew;
use nalgebra::{Matrix6, Vector6};

/// Rounding error of a wrench summed in another order or frame.
const SAME: f64 = 1e-12;

/// Rounding error of second moments, relative to the largest entry.
const JACOBIAN: f64 = 1e-11;

/// Rounding error of derivatives through slices and clips, relative to the largest entry.
const TWO_WAYS: f64 = 1e-10;

fn lever(pair: &ContactPair) -> nalgebra::Vector3<f64> {
    pair.b().pose().translation() - pair.a().pose().translation()
}

/// About a fixed point, a motion of A is equivalent to the opposite motion of B followed by a rotation of the wrench. The Hessian of the
/// energy is symmetric.
#[test]
fn moving_one_body_is_minus_the_transpose_of_moving_the_other() {
    let shapes = Shapes::mixed();
    shapes.for_pairs(300, 42, |pair, _| {
        let contact = pair.linearized();
        let by_poses =
            [0, 6].map(|column| contact.by_poses.fixed_view::<6, 6>(0, column).into_owned());
        let arm = lever(pair);
        // Motion of B about A's origin: B's own rotation by ω is a rotation about A's origin and a translation by ω × (p_A − p_B).
        let mut about_a = Matrix6::<f64>::identity();
        about_a.fixed_view_mut::<3, 3>(3, 0).copy_from(&skew(&arm));
        let by_b = by_poses[1] * about_a.try_inverse().unwrap();
        // About a fixed point, the torque of A's wrench is smaller by F × δp.
        let mut by_a = by_poses[0];
        let mut corner = by_a.fixed_view_mut::<3, 3>(0, 3);
        corner -= skew(&contact.wrench.on_a.force);
        let error = (by_a + by_b.transpose()).amax();
        assert!(
            error <= JACOBIAN * by_b.amax(),
            "{error:e} of {:e}",
            by_b.amax()
        );
    });
}

#[test]
fn the_wrench_is_homogeneous_in_the_moduli() {
    let shapes = Shapes::mixed();
    shapes.for_pairs(300, 43, |pair, _| {
        let contact = pair.linearized();
        let column = |body: usize| contact.by_moduli.fixed_view::<6, 1>(0, body).into_owned();
        let (by_a, by_b) = (column(0), column(1));
        let sum = by_a * pair.a().modulus() + by_b * pair.b().modulus().unwrap_or(0.0);
        let expected = contact.wrench.on_a.to_vector();
        assert!((sum - expected).amax() <= SAME * expected.amax());
        if pair.b().modulus().is_none() {
            assert_eq!(by_b, Vector6::zeros());
        }
    });
}

#[test]
fn closed_form_and_dual_numbers_agree() {
    let shapes = Shapes::mixed();
    let mut worst = 0.0_f64;
    shapes.for_pairs(300, 44, |pair, _| {
        let contact = pair.linearized();
        let (dual_wrench, dual) = dual_wrench_jacobian(pair);
        for (row, wrench, expected_wrench) in [
            (0, contact.wrench.on_a, dual_wrench.on_a),
            (6, contact.wrench.on_b, dual_wrench.on_b),
        ] {
            let expected = dual.fixed_rows::<6>(row);
            let error = (contact.jacobian().fixed_rows::<6>(row) - expected).amax();
            worst = worst.max(error / expected.amax());
            let (wrench, expected_wrench) = (wrench.to_vector(), expected_wrench.to_vector());
            assert!((wrench - expected_wrench).amax() <= SAME * expected_wrench.amax());
        }
    });
    println!("worst: {worst:.1e}");
    assert!(worst <= TWO_WAYS, "{worst:e}");
}
