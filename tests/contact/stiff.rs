//! Very different moduli: a body of increasing stiffness becomes rigid, and contact is not lost.

use crate::support::octahedra::{OVERLAP, fall, octahedron, stacked};
use crate::support::scenes::pair;
use crate::support::worlds::{cuboid, icosphere, turned};
use hydroelastic::contact::Shape;
use hydroelastic::spatial::Pose;

/// Remaining compliance of the stiff body at the reference ratio of 1e8.
const RIGID: f64 = 1e-8;

/// Pressure gradient (Pa/m), a tenth below the largest allowed value.
const STEEP: f64 = 9e152;

/// Rounding error of a sum over some tetrahedra.
const EXACT: f64 = 1e-12;

#[test]
fn contact_with_an_ever_stiffer_ball_tends_to_that_with_a_rigid_one() {
    let ball = icosphere(1.0, 2);
    let above = turned([0.3, 0.2, 0.1], [0.1, 0.2, 1.6]);
    let force = |modulus| {
        let stiff = pair((&ball, above, modulus), (&ball, Pose::identity(), 1.0));
        let soft = pair((&ball, Pose::identity(), 1.0), (&ball, above, modulus));
        (stiff.wrench().on_a.force, soft.wrench().on_b.force)
    };
    let (limit, _) = force(1e8);
    assert!(limit.norm() > 0.1);
    for exponent in 9..=17 {
        let (on_stiff, exchanged) = force(10_f64.powi(exponent));
        for wrench in [on_stiff, exchanged] {
            let error = (wrench - limit).norm() / limit.norm();
            assert!(error <= RIGID, "1e{exponent}: {error:e}");
        }
    }
}

/// No value overflows, even away from the contact surface, where p_A − p_B cannot be converted to a height above the surface.
#[test]
fn contact_is_finite_at_the_steepest_pressures() {
    let ball = icosphere(1e5, 1);
    let block = cuboid([1e5, 7e4, 1.3e5]);
    let modulus = |shape: &Shape| STEEP / shape.field().steepest();
    let pose = turned([0.3, -0.7, 0.4], [5e4, 3e4, 6e4]);
    let pair = pair(
        (&ball, Pose::identity(), modulus(&ball)),
        (&block, pose, 0.7 * modulus(&block)),
    );
    let contact = pair.linearized();
    let wrench = contact.wrench;
    assert!(wrench.on_a.force.norm() > 0.0);
    let numbers = wrench.on_a.to_vector();
    assert!(numbers.iter().all(|number| number.is_finite()));
    let numbers = contact.jacobian();
    assert!(numbers.iter().all(|number| number.is_finite()));
}

/// min(p_A, p_B) is the softer body's pressure almost everywhere. A difference of the stiff body's integrals would be lost in their
/// rounding errors.
#[test]
fn energy_of_contact_with_an_ever_stiffer_body_tends_to_that_with_a_rigid_one() {
    let shape = octahedron(0);
    for exponent in [8, 12, 16] {
        let stiff = 10_f64.powi(exponent);
        for moduli in [[1.0, stiff], [stiff, 1.0]] {
            let energy = stacked(&shape, moduli).potential_energy();
            // The force 2 k l³/3 does work over the distance 2 dl, where k tends to twice the softer modulus.
            let expected = fall(moduli) * OVERLAP.powi(4) / 3.0;
            let error = (energy / expected - 1.0).abs();
            assert!(error <= EXACT, "1e{exponent}: {error:e}");
        }
    }
}
