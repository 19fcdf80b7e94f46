//! Second derivatives through num-dual's second-order types: the Hessian of the energy and of a
//! force component.

use super::structure::{self, for_random_pairs};
use hydroelastic::contact::ContactPair;
use hydroelastic::scalar::Scalar;
use nalgebra::{SMatrix, SVector, Vector6};
use num_dual::{Dual2SVec64, HyperDual64, hessian, second_partial_derivative};

/// Rounding error of a second derivative through clipped tetrahedra, relative to the largest entry.
const EXACT: f64 = 1e-9;

/// Error of central differences of an exact first derivative: the rounding error divided by a step of 1e-6.
const DIFFERENCES: f64 = 1e-6;

const STEP: f64 = 1e-6;

/// Returns the pair in `T` with A moved by a twist.
fn moved<'a, T: Scalar>(pair: &ContactPair<'a>, twist: &Vector6<T>) -> ContactPair<'a, T> {
    structure::moved(pair, twist, &Vector6::zeros())
}

#[test]
fn the_hessian_of_the_energy_is_minus_the_symmetric_part_of_the_jacobian() {
    for_random_pairs(40, 21, |pair| {
        let energy = |twist: SVector<Dual2SVec64<6>, 6>| moved(pair, &twist).potential_energy();
        let (_, slope, curvature) = hessian(energy, &Vector6::zeros());
        let contact = pair.linearized();
        let stiffness = contact.by_poses.fixed_view::<6, 6>(0, 0).into_owned();
        let symmetric = (stiffness + stiffness.transpose()) / 2.0;
        let error = (curvature + symmetric).amax();
        assert!(error <= EXACT * symmetric.amax(), "{error:e}");
        let wrench = contact.wrench.on_a.to_vector();
        assert!((slope + wrench).amax() <= EXACT * wrench.amax());
    });
}

#[test]
fn the_hessian_of_a_force_component_is_the_derivative_of_the_jacobian() {
    for_random_pairs(40, 22, |pair| {
        let force = |twist: SVector<Dual2SVec64<6>, 6>| moved(pair, &twist).wrench().on_a.force.y;
        let (_, gradient, curvature) = hessian(force, &Vector6::zeros());
        let row = pair
            .linearized()
            .by_poses
            .fixed_view::<1, 6>(4, 0)
            .transpose();
        assert!((gradient - row).amax() <= EXACT * row.amax());
        let differences = SMatrix::<f64, 6, 3>::from_fn(|i, j| {
            // The steps are translations, because translations commute and rotations do not.
            let row_after = |step: f64| {
                let twist = Vector6::ith(3 + j, step);
                moved(pair, &twist).linearized().by_poses[(4, i)]
            };
            (row_after(STEP) - row_after(-STEP)) / (2.0 * STEP)
        });
        let block = curvature.fixed_view::<6, 3>(0, 3).into_owned();
        let error = (block - differences).amax();
        // The gradient bounds the effect of rounding: Jacobian entries are exact to 1e-15 of the gradient.
        let scale = curvature.amax().max(row.amax());
        assert!(error <= DIFFERENCES * scale, "{error:e} of {scale:e}");
    });
}

#[test]
fn hyper_dual_numbers_give_single_entries_of_the_hessian() {
    for_random_pairs(20, 24, |pair| {
        let force_x = |(turn, lift_up): (HyperDual64, HyperDual64)| {
            let zero = HyperDual64::from_re(0.0);
            let twist = Vector6::new(zero, turn, zero, zero, zero, lift_up);
            moved(pair, &twist).wrench().on_a.force.x
        };
        let (.., mixed) = second_partial_derivative(force_x, (0.0, 0.0));
        let force = |twist: SVector<Dual2SVec64<6>, 6>| moved(pair, &twist).wrench().on_a.force.x;
        let (_, _, curvature) = hessian(force, &Vector6::zeros());
        assert!((mixed - curvature[(1, 5)]).abs() <= EXACT * curvature.amax());
    });
}
