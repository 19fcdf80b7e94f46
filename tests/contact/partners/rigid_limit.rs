//! A rigid body is the limit of ever stiffer ones.

use super::{Shapes, rigid};
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// The error is this over the ratio of the moduli, at most: the soft body's pressure over the stiff one's at the same depth.
const TIMES: f64 = 4.0;

/// Where round-off takes over.
const ROUNDED: f64 = 1e-12;

fn error_against(limit: &ContactPair, pair: &ContactPair) -> f64 {
    let (expected, expected_jacobian) = limit.wrench_and_jacobian();
    let (found, jacobian) = pair.wrench_and_jacobian();
    let wrench = (found.on_a.to_vector() - expected.on_a.to_vector()).amax();
    let (found, expected_matrix) = (jacobian.on_a, expected_jacobian.on_a);
    let slopes = (found.by_pose_a - expected_matrix.by_pose_a).amax();
    (wrench / expected.on_a.to_vector().amax()).max(slopes / expected_matrix.by_pose_a.amax())
}

fn assert_falls(limit: &ContactPair, stiff: impl Fn(f64) -> f64) {
    let _ = limit;
    for power in 2..=12 {
        let ratio = 10_f64.powi(power);
        let error = stiff(ratio);
        assert!(error <= TIMES / ratio + ROUNDED, "at {ratio:e}: {error:e}");
    }
}

#[test]
fn wrench_and_jacobian_approach_those_of_a_rigid_body_as_the_ratio_of_moduli() {
    let stiff = [
        shapes::icosphere(1.0, 1).unwrap(),
        shapes::cuboid([1.2, 1.4, 1.0]).unwrap(),
    ];
    let soft = Shape::new(shapes::ellipsoid([0.9, 0.8, 1.1], 2).unwrap());
    for field in stiff {
        let stiff = Shape::new(field);
        let surface = rigid(&stiff);
        let pose = Pose::from_rotation_vector(&vector![0.4, -0.3, 0.9], vector![0.5, 1.1, 0.6]);
        let a = ContactBody::new(&soft, Pose::identity(), 1.0).unwrap();
        let limit = ContactPair::new(a, Partner::rigid(&surface, pose).unwrap());
        assert_falls(&limit, |ratio| {
            let b = ContactBody::new(&stiff, pose, ratio).unwrap();
            error_against(&limit, &ContactPair::new(a, b))
        });
    }
}

#[test]
fn a_stiff_layer_approaches_a_rigid_half_space() {
    let shapes = Shapes::mixed();
    let pose = Pose::from_rotation_vector(&vector![0.4, -0.3, 0.9], vector![0.1, 0.2, -0.3]);
    for shape in &shapes.compliant {
        let a = ContactBody::new(shape, Pose::identity(), 1.0).unwrap();
        let limit = ContactPair::new(a, Partner::rigid_half_space(pose).unwrap());
        let layer = HalfSpace::layer(0.1).unwrap();
        assert_falls(&limit, |ratio| {
            let b = Partner::half_space(&layer, pose, ratio).unwrap();
            error_against(&limit, &ContactPair::new(a, b))
        });
    }
}
