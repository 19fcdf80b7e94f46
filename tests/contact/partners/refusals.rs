//! Invalid partners are rejected, and inputs that a partner ignores are not.

use super::rigid;
use crate::support::worlds::{at, cuboid};
use hydroelastic::contact::{BodyError, ContactBody, ContactPair, HalfSpace, Partner};
use hydroelastic::spatial::Pose;

const NO_MODULI: [f64; 4] = [0.0, -1.0, f64::INFINITY, f64::NAN];

#[test]
fn a_soft_layer_needs_a_positive_modulus() {
    let layer = HalfSpace::layer(0.1).unwrap();
    let soft = Partner::half_space(&layer, Pose::identity(), 1.0).unwrap();
    for modulus in NO_MODULI {
        let refused = Partner::half_space(&layer, Pose::identity(), modulus);
        assert!(matches!(refused, Err(BodyError::Modulus(_))), "{modulus}");
        let refused = soft.at(Pose::identity(), modulus);
        assert!(matches!(refused, Err(BodyError::Modulus(_))), "{modulus}");
    }
}

#[test]
fn a_rigid_partner_ignores_the_modulus() {
    let cube = rigid(&cuboid([1.0; 3]));
    let bare = HalfSpace::rigid();
    for modulus in NO_MODULI {
        let half_space = Partner::half_space(&bare, Pose::identity(), modulus).unwrap();
        assert_eq!(half_space.modulus(), None);
        let cube: Partner = Partner::rigid(&cube, Pose::identity()).unwrap();
        let moved = cube.at(Pose::identity(), modulus).unwrap();
        assert_eq!(moved.modulus(), None);
    }
}

/// Otherwise the force would be zero, because the squares of gradients overflow.
#[test]
fn pressures_must_not_rise_beyond_double_precision() {
    let [thin, bare] = [HalfSpace::layer(1e-6).unwrap(), HalfSpace::rigid()];
    let cube = cuboid([0.2; 3]);
    let here = Pose::identity();
    for modulus in [1e148, 1e200, f64::MAX] {
        let layer = Partner::half_space(&thin, here, modulus).map(|_| ());
        let body = ContactBody::new(&cube, here, modulus * 1e5).map(|_| ());
        for refused in [layer, body] {
            let is_named = |error: &BodyError| {
                matches!(error, BodyError::Steep { .. } | BodyError::Modulus(_))
            };
            assert!(refused.as_ref().is_err_and(is_named), "{refused:?}");
        }
        assert!(Partner::half_space(&bare, here, modulus).is_ok());
    }
    // The steepest accepted layer still has a force. It is rigid up to round-off.
    let above = at(0.01, 0.02, 0.09);
    let cube = ContactBody::new(&cube, above, 1e100).unwrap();
    let [on_layer, on_rigid] = [
        Partner::half_space(&thin, here, 1e146).unwrap(),
        Partner::rigid_half_space(here).unwrap(),
    ]
    .map(|partner| ContactPair::new(cube, partner).wrench().on_a.force.z);
    assert!(
        (on_layer / on_rigid - 1.0).abs() < 1e-12,
        "{on_layer} {on_rigid}"
    );
}

#[test]
fn a_partner_needs_a_finite_pose() {
    let nowhere = at(0.0, f64::NAN, 0.0);
    let layer = HalfSpace::layer(0.1).unwrap();
    let cube = rigid(&cuboid([1.0; 3]));
    for refused in [
        Partner::rigid(&cube, nowhere),
        Partner::rigid_half_space(nowhere),
        Partner::half_space(&layer, nowhere, 1.0),
    ] {
        assert!(matches!(refused, Err(BodyError::Pose(_))));
    }
}
