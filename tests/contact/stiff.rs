//! Wildly unequal moduli: a body ever stiffer becomes rigid, and contact is not lost.

use crate::support::octahedra::{OVERLAP, fall, octahedron, stacked};
use crate::support::scenes::pair;
use hydroelastic::contact::Shape;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// What is left of the stiff body's give at the ratio of 1e8 compared with.
const RIGID: f64 = 1e-8;

/// Round-off of a sum over some tetrahedra.
const EXACT: f64 = 1e-12;

#[test]
fn contact_with_an_ever_stiffer_ball_tends_to_that_with_a_rigid_one() {
    let ball = Shape::new(shapes::icosphere(1.0, 2).unwrap());
    let above = Pose::from_rotation_vector(&vector![0.3, 0.2, 0.1], vector![0.1, 0.2, 1.6]);
    let force = |modulus| {
        let stiff = pair((&ball, above, modulus), (&ball, Pose::identity(), 1.0));
        let soft = pair((&ball, Pose::identity(), 1.0), (&ball, above, modulus));
        (stiff.wrench().on_a.force, soft.wrench().on_b.force)
    };
    let (limit, _) = force(1e8);
    assert!(limit.norm() > 0.1);
    for exponent in 9..=17 {
        let (on_stiff, exchanged) = force(10_f64.powi(exponent));
        for found in [on_stiff, exchanged] {
            let error = (found - limit).norm() / limit.norm();
            assert!(error <= RIGID, "1e{exponent}: {error:e}");
        }
    }
}

/// min(p_A, p_B) is the softer body's pressure almost everywhere: a difference of the stiff one's integrals would
/// be lost in their rounding.
#[test]
fn energy_of_contact_with_an_ever_stiffer_body_tends_to_that_with_a_rigid_one() {
    let shape = octahedron(0);
    for exponent in [8, 12, 16] {
        let stiff = 10_f64.powi(exponent);
        for moduli in [[1.0, stiff], [stiff, 1.0]] {
            let energy = stacked(&shape, moduli).potential_energy();
            // The force 2 k l³/3 does work over the way 2 dl, where k tends to twice the softer modulus.
            let expected = fall(moduli) * OVERLAP.powi(4) / 3.0;
            let error = (energy / expected - 1.0).abs();
            assert!(error <= EXACT, "1e{exponent}: {error:e}");
        }
    }
}
