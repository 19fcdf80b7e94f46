//! A rigid body is the limit of bodies of increasing stiffness.

use super::{Shapes, rigid};
use crate::support::worlds::turned;
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;

/// Bound of the error times the ratio of the moduli. The error is the ratio of the soft body's pressure to the stiff body's pressure at the
/// same depth.
const TIMES: f64 = 4.0;

/// Rounding error, which dominates at large ratios.
const ROUNDED: f64 = 1e-12;

/// Returns the error of the wrench on A and of its derivatives with respect to both poses, relative to the limit.
fn error_against(limit: &ContactPair, pair: &ContactPair) -> f64 {
    let [(expected, slopes), (actual, actual_slopes)] = [limit, pair].map(|pair| {
        let contact = pair.linearized();
        let by_pose = |column| contact.by_poses.fixed_view::<6, 6>(0, column).into_owned();
        (contact.wrench.on_a.to_vector(), [0, 6].map(by_pose))
    });
    let of_slopes = slopes.iter().zip(actual_slopes);
    let of_slopes =
        of_slopes.map(|(expected, actual)| (actual - expected).amax() / expected.amax());
    let of_wrench = (actual - expected).amax() / expected.amax();
    of_slopes.fold(of_wrench, f64::max)
}

/// Checks that the error decreases in proportion to the ratio of B's modulus to A's.
fn assert_falls<'a>(limit: &ContactPair, with_ratio: impl Fn(f64) -> ContactPair<'a>) {
    for power in 2..=12 {
        let ratio = 10_f64.powi(power);
        let error = error_against(limit, &with_ratio(ratio));
        assert!(error <= TIMES / ratio + ROUNDED, "at {ratio:e}: {error:e}");
    }
}

#[test]
fn wrench_and_derivatives_approach_those_of_a_rigid_body_as_the_ratio_of_moduli() {
    let stiff = [
        shapes::icosphere(1.0, 1).unwrap(),
        shapes::cuboid([1.2, 1.4, 1.0]).unwrap(),
    ];
    let soft = Shape::new(shapes::ellipsoid([0.9, 0.8, 1.1], 2).unwrap());
    for field in stiff {
        let stiff = Shape::new(field);
        let surface = rigid(&stiff);
        let pose = turned([0.4, -0.3, 0.9], [0.5, 1.1, 0.6]);
        let a = ContactBody::new(&soft, Pose::identity(), 1.0).unwrap();
        let limit = ContactPair::new(a, Partner::rigid(&surface, pose).unwrap());
        assert_falls(&limit, |ratio| {
            ContactPair::new(a, ContactBody::new(&stiff, pose, ratio).unwrap())
        });
    }
}

#[test]
fn a_stiff_layer_approaches_a_rigid_half_space() {
    let shapes = Shapes::mixed();
    let pose = turned([0.4, -0.3, 0.9], [0.1, 0.2, -0.3]);
    for shape in &shapes.compliant {
        let a = ContactBody::new(shape, Pose::identity(), 1.0).unwrap();
        let limit = ContactPair::new(a, Partner::rigid_half_space(pose).unwrap());
        let layer = HalfSpace::layer(0.1).unwrap();
        assert_falls(&limit, |ratio| {
            ContactPair::new(a, Partner::half_space(&layer, pose, ratio).unwrap())
        });
    }
}
