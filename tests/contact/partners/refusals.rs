//! What is no partner is refused, and what a partner ignores is not.

use super::rigid;
use hydroelastic::contact::{BodyError, HalfSpace, Partner, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

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
    let cube = rigid(&Shape::new(shapes::cuboid([1.0; 3]).unwrap()));
    let bare = HalfSpace::rigid();
    for modulus in NO_MODULI {
        let half_space = Partner::half_space(&bare, Pose::identity(), modulus).unwrap();
        assert_eq!(half_space.modulus(), None);
        let cube = Partner::rigid(&cube, Pose::identity()).unwrap();
        let moved = cube.at(Pose::identity(), modulus).unwrap();
        assert_eq!(moved.modulus(), None);
    }
}

#[test]
fn a_partner_needs_a_finite_pose() {
    let nowhere = Pose::from_translation(vector![0.0, f64::NAN, 0.0]);
    let layer = HalfSpace::layer(0.1).unwrap();
    let cube = rigid(&Shape::new(shapes::cuboid([1.0; 3]).unwrap()));
    for refused in [
        Partner::rigid(&cube, nowhere),
        Partner::rigid_half_space(nowhere),
        Partner::half_space(&layer, nowhere, 1.0),
    ] {
        assert!(matches!(refused, Err(BodyError::Pose(_))));
    }
}
