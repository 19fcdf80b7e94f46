//! Poses and twists: composition, inversion, motion, rejection and lifting.

use crate::samples_and_tolerances::{EXACT, ROUND_OFF, rotation_vectors};
use hydroelastic::scalar::lift;
use hydroelastic::spatial::{Pose, PoseError, Twist, rotation_from_vector};
use nalgebra::{Matrix3, Vector3, Vector6, vector};
use num_dual::{Dual2_64, Dual64};

fn poses() -> [Pose; 3] {
    [
        Pose::from_rotation_vector(&vector![0.3, -0.2, 0.9], vector![1.0, -2.0, 0.5]),
        Pose::from_rotation_vector(&vector![2.0, 1.0, -0.4], vector![-0.3, 0.1, 0.7]),
        Pose::from_translation(vector![0.0, 4.0, -1.0]),
    ]
}

fn pose_difference(a: &Pose, b: &Pose) -> f64 {
    let rotation = (a.rotation() - b.rotation()).amax();
    rotation.max((a.translation() - b.translation()).amax())
}

#[test]
fn composed_pose_maps_like_one_pose_after_the_other() {
    let [pose_wa, pose_ab, _] = poses();
    let p_bq = vector![0.7, -0.4, 0.2];
    let p_aq = pose_ab.transformed_point(&p_bq);
    let p_wq = (pose_wa * pose_ab).transformed_point(&p_bq);
    assert!((p_wq - pose_wa.transformed_point(&p_aq)).amax() <= ROUND_OFF);
}

#[test]
fn composition_is_associative() {
    let [a, b, c] = poses();
    assert!(pose_difference(&((a * b) * c), &(a * (b * c))) <= ROUND_OFF);
}

#[test]
fn inverse_undoes_the_pose_from_both_sides() {
    for pose in poses() {
        let identity = Pose::identity();
        assert!(pose_difference(&(pose * pose.inverse()), &identity) <= ROUND_OFF);
        assert!(pose_difference(&(pose.inverse() * pose), &identity) <= ROUND_OFF);
    }
}

#[test]
fn moved_pose_turns_about_its_own_origin_in_outer_axes() {
    let [pose, ..] = poses();
    let (angular, linear) = (vector![0.1, 0.2, -0.3], vector![1.0, 2.0, 3.0]);
    let moved = pose.moved_by(&Twist { angular, linear });
    assert!((moved.translation() - pose.translation() - linear).amax() <= ROUND_OFF);
    let expected = rotation_from_vector(&angular) * pose.rotation();
    assert!((moved.rotation() - expected).amax() <= ROUND_OFF);
}

#[test]
fn twist_from_vector_has_the_angular_part_first() {
    let twist = Twist::from_vector(&Vector6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0));
    assert_eq!(twist.angular, vector![1.0, 2.0, 3.0]);
    assert_eq!(twist.linear, vector![4.0, 5.0, 6.0]);
    let still: Twist = Twist::zero();
    assert_eq!(
        (still.angular, still.linear),
        (Vector3::zeros(), Vector3::zeros())
    );
}

#[test]
fn rotations_are_accepted_and_kept() {
    for vector in rotation_vectors() {
        let rotation = rotation_from_vector(&vector);
        let pose = Pose::new(rotation, vector).unwrap();
        // The rotation is corrected to round-off, not copied exactly.
        assert!((pose.rotation() - rotation).amax() <= 1e-15);
        assert_eq!(*pose.translation(), vector);
    }
}

#[test]
fn numbers_that_are_not_finite_are_no_pose() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut rotation = Matrix3::identity();
        rotation[(1, 2)] = bad;
        let is_bad = |pose: Result<Pose, PoseError>| matches!(pose, Err(PoseError::NotFinite(value)) if value.to_bits() == bad.to_bits());
        assert!(is_bad(Pose::new(rotation, Vector3::zeros())));
        assert!(is_bad(Pose::new(
            Matrix3::identity(),
            vector![0.0, bad, 0.0]
        )));
    }
    let message = PoseError::NotFinite(f64::NAN).to_string();
    assert_eq!(
        message,
        "a pose must be finite, but a component of its rotation or translation is NaN"
    );
}

/// Returns the matrix's deviation from a rotation, as reported by the error.
fn deviation_of(rotation: Matrix3<f64>) -> f64 {
    match Pose::new(rotation, Vector3::zeros()) {
        Err(PoseError::NotARotation { deviation }) => deviation,
        unexpected => panic!("expected NotARotation, found {unexpected:?}"),
    }
}

#[test]
fn matrices_that_stretch_shear_or_mirror_are_no_pose() {
    let stretch = Matrix3::from_diagonal(&vector![1.0, 1.1, 1.0]);
    // |RᵀR − I| = 1.1² − 1.
    assert!((deviation_of(stretch) - 0.21).abs() <= ROUND_OFF);
    let mut shear = Matrix3::identity();
    shear[(0, 1)] = 0.125;
    assert!((deviation_of(shear) - 0.125).abs() <= ROUND_OFF);
    let mirror = Matrix3::from_diagonal(&vector![1.0, 1.0, -1.0]);
    assert!((deviation_of(mirror) - 2.0).abs() <= ROUND_OFF);
    assert!((deviation_of(-Matrix3::identity()) - 2.0).abs() <= ROUND_OFF);
    assert!((deviation_of(Matrix3::zeros()) - 1.0).abs() <= ROUND_OFF);
    let message = PoseError::NotARotation { deviation: 0.21 }.to_string();
    assert_eq!(
        message,
        "a rotation must be orthonormal with determinant 1 to 1e-9, but the matrix is 2.1e-1 away from it"
    );
}

#[test]
fn rotations_pass_up_to_the_stated_deviation() {
    // A stretch by 1 + s has the deviation 2s + s².
    let stretched = |s: f64| Pose::new(Matrix3::identity() * (1.0 + s), Vector3::zeros());
    assert!(stretched(0.3e-9).is_ok());
    assert!(stretched(0.6e-9).is_err());
}

#[test]
fn pose_check_looks_at_values_whatever_the_derivatives() {
    let rotation = Matrix3::from_element(Dual64::new(0.0, 5.0)) + Matrix3::identity();
    assert!(Pose::new(rotation, Vector3::from_element(Dual64::new(1.0, 7.0))).is_ok());
    assert!(Pose::new(rotation * lift::<Dual64>(2.0), Vector3::identity()).is_err());
}

#[test]
fn lifted_pose_has_the_value_and_no_derivatives() {
    let [pose, ..] = poses();
    let lifted: Pose<Dual64> = Pose::lifted(&pose);
    assert_eq!(*lifted.real().rotation(), *pose.rotation());
    assert_eq!(*lifted.real().translation(), *pose.translation());
    assert_eq!(lifted.rotation().map(|entry| entry.eps), Matrix3::zeros());
    assert_eq!(
        lifted.translation().map(|entry| entry.eps),
        Vector3::zeros()
    );
}

#[test]
fn poses_of_first_order_have_the_first_derivatives_of_second_order() {
    let change = Matrix3::new(0.3, -0.7, 0.2, 0.5, 0.1, -0.4, 0.9, -0.2, 0.6);
    for v in rotation_vectors() {
        let real = rotation_from_vector(&v);
        let entry = |i: usize, j: usize| (real[(i, j)], change[(i, j)]);
        // The derivative of the matrix is not that of a rotation, and the pose projects it to one.
        let first = Matrix3::from_fn(|i, j| Dual64::new(entry(i, j).0, entry(i, j).1));
        let second = Matrix3::from_fn(|i, j| Dual2_64::new(entry(i, j).0, entry(i, j).1, 0.0));
        let first = Pose::new(first, Vector3::zeros()).unwrap();
        let second = Pose::new(second, Vector3::zeros()).unwrap();
        let (rotation, reference_rotation) = (first.rotation(), second.rotation());
        let error = rotation.map(|n| n.eps) - reference_rotation.map(|n| n.v1);
        assert!(error.amax() <= EXACT, "{:e}", error.amax());
        let no_turn = real.transpose() * rotation.map(|n| n.eps);
        assert!((no_turn + no_turn.transpose()).amax() <= EXACT);
        let error = rotation.map(|n| n.re) - reference_rotation.map(|n| n.re);
        assert!(error.amax() <= ROUND_OFF, "{:e}", error.amax());
    }
}
