//! Conversion of poses to and from isometries of nalgebra.

use hydroelastic::contact::{BodyError, ContactBody, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, PoseError};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3, vector};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Rounding error of converting a rotation matrix to a quaternion and back: a dozen rounding errors of numbers of order one.
const ROUND_OFF: f64 = 2e-15;

/// Rounding error of the length of a normalized quaternion.
const UNIT: f64 = 4.0 * f64::EPSILON;

/// Generates small rotations, half turns, at which the largest component of the quaternion changes, and several turns.
fn turns() -> impl Strategy<Value = Vector3<f64>> {
    let axes = prop_oneof![
        prop::array::uniform3(-1.0..1.0).prop_map(Vector3::from),
        Just(vector![1.0, 0.0, 0.0]),
        Just(vector![0.0, -1.0, 0.0]),
        Just(vector![0.0, 0.0, 1.0]),
        Just(vector![1.0, 1.0, 1.0]),
        Just(vector![1.0, -1.0, 0.0]),
    ];
    let angles = prop_oneof![
        -7.0..7.0,
        -1e-8..1e-8,
        Just(0.0),
        Just(PI),
        Just(PI - 1e-9),
        Just(PI / 2.0),
        Just(2.0 * PI / 3.0),
    ];
    let not_zero = axes.prop_filter("no axis", |axis: &Vector3<f64>| axis.norm() > 1e-3);
    (not_zero, angles).prop_map(|(axis, angle)| axis.normalize() * angle)
}

fn positions() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0).prop_map(Vector3::from)
}

fn poses() -> impl Strategy<Value = Pose> {
    (turns(), positions()).prop_map(|(turn, origin)| Pose::from_rotation_vector(&turn, origin))
}

proptest! {
    #[test]
    fn pose_and_isometry_map_points_alike(pose_ab in poses(), p_bq in positions()) {
        let p_aq = Isometry3::from(pose_ab) * Point3::from(p_bq);
        prop_assert!((p_aq.coords - pose_ab.transformed_point(&p_bq)).amax() <= ROUND_OFF);
    }

    #[test]
    fn a_pose_comes_back_from_its_isometry(pose in poses()) {
        let back = Pose::from(Isometry3::from(pose));
        prop_assert!((back.rotation() - pose.rotation()).amax() <= ROUND_OFF);
        prop_assert_eq!(back.translation(), pose.translation());
    }

    #[test]
    fn an_isometry_comes_back_from_its_pose(turn in turns(), origin in positions()) {
        let isometry = Isometry3::new(origin, turn);
        let back = Isometry3::from(Pose::from(isometry));
        // Two opposite quaternions represent each rotation.
        let [q, p] = [isometry.rotation.coords, back.rotation.coords];
        prop_assert!((q - p).amax().min((q + p).amax()) <= ROUND_OFF);
        prop_assert_eq!(back.translation, isometry.translation);
    }

    #[test]
    fn products_go_over_into_products(a in poses(), b in poses()) {
        let product = Pose::from(Isometry3::from(a) * Isometry3::from(b));
        let expected = a * b;
        prop_assert!((product.rotation() - expected.rotation()).amax() <= ROUND_OFF);
        prop_assert!((product.translation() - expected.translation()).amax() <= ROUND_OFF);
    }
}

#[test]
fn the_quaternion_has_length_one_whatever_products_did_to_the_pose() {
    for [w, i, j, k] in [[0.5; 4], [1.0, 0.0, 0.0, 0.0], [0.0, 0.6, 0.0, -0.8]] {
        // This drift is far larger than that of products. The error of the matrix is twice as large.
        let drifted = Quaternion::new(w, i, j, k) * 1.0001;
        let pose = Pose::from(isometry(drifted, Vector3::zeros()));
        let length = Isometry3::from(pose).rotation.norm();
        assert!((length - 1.0).abs() <= UNIT, "{length}");
    }
}

fn isometry(quaternion: Quaternion<f64>, origin: Vector3<f64>) -> Isometry3<f64> {
    let orientation = UnitQuaternion::new_unchecked(quaternion);
    Isometry3::from_parts(Translation3::from(origin), orientation)
}

/// Returns the reason why no body can have the pose.
fn refusal(pose: Pose) -> BodyError {
    let shape = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
    ContactBody::new(&shape, pose, 1e5).unwrap_err()
}

#[test]
fn an_isometry_that_is_not_finite_makes_no_body() {
    let upright = Quaternion::new(1.0, 0.0, 0.0, 0.0);
    for bad in [f64::NAN, f64::INFINITY] {
        let turned = isometry(Quaternion::new(1.0, bad, 0.0, 0.0), Vector3::zeros());
        let moved = isometry(upright, vector![0.0, bad, 0.0]);
        for isometry in [turned, moved] {
            let error = refusal(Pose::from(isometry));
            assert!(
                matches!(error, BodyError::Pose(PoseError::NotFinite(_))),
                "{error}"
            );
            let back = Isometry3::from(Pose::from(isometry));
            let numbers = back.rotation.coords.iter().chain(&back.translation.vector);
            assert!(numbers.into_iter().any(|number| !number.is_finite()));
        }
    }
}

#[test]
fn an_isometry_whose_quaternion_is_not_of_length_one_makes_no_body() {
    let doubled = isometry(Quaternion::new(1.5, 0.0, 0.0, 0.0), Vector3::zeros());
    // The matrix has the squares of the quaternion's components, so RᵀR − I is 1.5⁴ − 1.
    let BodyError::Pose(PoseError::NotARotation { deviation }) = refusal(Pose::from(doubled))
    else {
        panic!("expected NotARotation")
    };
    assert!(deviation >= 1.5_f64.powi(4) - 1.0, "{deviation}");
}
