//! Poses, the exponential map, wrenches, and the scalars they are generic over.

use hydroelastic::scalar::{Scalar, lift, lift_vector, real_part, real_vector};
use hydroelastic::spatial::{Pose, PoseError, Twist, Wrench, rotation_from_vector, skew};
use nalgebra::{Isometry3, Matrix3, Rotation3, SVector, Vector3, Vector6, vector};
use num_dual::{
    Dual, Dual2, Dual2_64, Dual2SVec64, Dual3_64, Dual64, DualSVec64, HyperDual64, HyperDualSVec64,
    first_derivative, gradient, hessian, partial_hessian, second_derivative,
    second_partial_derivative, third_derivative,
};
use std::f64::consts::PI;

/// A few roundings of numbers of order one.
const ROUND_OFF: f64 = 2e-15;

/// The exponential map and its derivatives for angles up to one turn.
const EXACT: f64 = 1e-14;

/// Relative rounding of an angle and of its sine: the error of a rotation grows with the angle.
const ANGLE_ROUND_OFF: f64 = 1e-15;

/// Step of central differences and the error it leaves: step² times a third derivative of order
/// one, and round-off over the step.
const STEP: f64 = 1e-5;
const DIFFERENCE_ERROR: f64 = 1e-9;

/// Rotation vectors on both sides of the limit of the series (0.5 rad), small, large, and along an
/// axis.
fn rotation_vectors() -> Vec<Vector3<f64>> {
    let axes = [
        vector![1.0, 0.0, 0.0],
        vector![0.0, 0.0, -1.0],
        vector![0.48, -0.6, 0.64],
        vector![-2.0, 1.0, 2.0] / 3.0,
    ];
    let angles = [
        1e-12,
        1e-8,
        1e-4,
        0.1,
        0.499_999_999,
        0.5 - f64::EPSILON,
        0.5,
        0.5 + f64::EPSILON,
        0.500_000_001,
        1.0,
        3.0,
        PI,
        6.0,
        20.0,
    ];
    axes.iter()
        .flat_map(|axis| angles.map(|angle| axis * angle))
        .collect()
}

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
fn pose_from_isometry_maps_points_alike() {
    let isometry = Isometry3::new(vector![1.0, -2.0, 0.5], vector![0.3, -0.2, 0.9]);
    let (pose, point) = (Pose::from(isometry), vector![0.7, -0.4, 0.2]);
    let expected = isometry.transform_point(&point.into()).coords;
    assert!((pose.transformed_point(&point) - expected).amax() <= ROUND_OFF);
    assert!(pose_difference(&pose, &poses()[0]) <= ROUND_OFF);
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
        // Put right to round-off, not taken to the bit.
        assert!((pose.rotation() - rotation).amax() <= 1e-15);
        assert_eq!(*pose.translation(), vector);
    }
}

#[test]
fn numbers_that_are_not_finite_are_no_pose() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut rotation = Matrix3::identity();
        rotation[(1, 2)] = bad;
        let is_bad = |found: Result<Pose, PoseError>| matches!(found, Err(PoseError::NotFinite(value)) if value.to_bits() == bad.to_bits());
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

/// How far the matrix is from a rotation, according to the error.
fn deviation_of(rotation: Matrix3<f64>) -> f64 {
    match Pose::new(rotation, Vector3::zeros()) {
        Err(PoseError::NotARotation { deviation }) => deviation,
        other => panic!("expected NotARotation, found {other:?}"),
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
    // A stretch by 1 + s deviates by 2s + s².
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
fn skew_matrix_takes_the_cross_product() {
    let (a, b) = (vector![1.0, -2.0, 3.0], vector![0.5, 0.7, -0.2]);
    assert!((skew(&a) * b - a.cross(&b)).amax() <= ROUND_OFF);
}

#[test]
fn exponential_map_agrees_with_nalgebra() {
    assert_eq!(
        rotation_from_vector(&Vector3::<f64>::zeros()),
        Matrix3::identity()
    );
    for vector in rotation_vectors() {
        let expected = Rotation3::new(vector).into_inner();
        let error = (rotation_from_vector(&vector) - expected).amax();
        let tolerance = ANGLE_ROUND_OFF * vector.norm().max(1.0);
        assert!(error <= tolerance, "{error:e} at {vector:?}");
    }
}

#[test]
fn small_rotations_keep_their_relative_accuracy() {
    let vector = vector![3e-13, -4e-13, 1.2e-12];
    let rotation = rotation_from_vector(&vector);
    // Off the diagonal R = S + S²/2: the quadratic term is 1e-12 of the linear one.
    let relative = (rotation - skew(&vector) - Matrix3::identity()).amax() / vector.norm();
    assert!(relative <= 1e-12, "{relative:e}");
}

/// ∂R/∂vₖ by the columns of the left Jacobian J of SO(3): ∂R/∂vₖ = [J eₖ]ₓ R with
/// J = I + (1 − cos θ)/θ²·S + (θ − sin θ)/θ³·S².
fn derivative_of_rotation(v: &Vector3<f64>, k: usize) -> Matrix3<f64> {
    let (angle, s) = (v.norm(), skew(v));
    let jacobian = Matrix3::identity()
        + s * ((1.0 - angle.cos()) / angle.powi(2))
        + s * s * ((angle - angle.sin()) / angle.powi(3));
    skew(&jacobian.column(k).into_owned()) * Rotation3::new(*v).into_inner()
}

/// Large enough that the closed form of J loses no digits to cancellation.
fn ordinary_rotation_vectors() -> Vec<Vector3<f64>> {
    vec![
        vector![0.1, -0.3, 0.2],
        vector![0.3, 0.3, 0.263],
        vector![0.3, 0.3, 0.265],
        vector![0.9, -0.2, 0.4],
        vector![-1.0, 2.0, 1.5],
        vector![3.0, 4.0, -2.0],
    ]
}

#[test]
fn first_derivatives_of_the_exponential_map_agree_with_the_closed_form() {
    for v in ordinary_rotation_vectors() {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let entry = |x: Vector3<DualSVec64<3>>| rotation_from_vector(&x)[(i, j)];
            let (value, slope) = gradient(entry, &v);
            assert!((value - Rotation3::new(v)[(i, j)]).abs() <= EXACT);
            let expected = Vector3::from_fn(|k, _| derivative_of_rotation(&v, k)[(i, j)]);
            assert!(
                (slope - expected).amax() <= EXACT,
                "{:e}",
                (slope - expected).amax()
            );
        }
    }
}

#[test]
fn first_derivatives_of_the_exponential_map_agree_with_differences() {
    for v in rotation_vectors() {
        for k in 0..3 {
            let seeded = |x: Dual64| {
                let mut moved = lift_vector::<Dual64>(&v);
                moved[k] = x;
                rotation_from_vector(&moved).map(|entry| entry.eps)
            };
            let slope = seeded(Dual64::new(v[k], 1.0));
            let step = Vector3::ith(k, STEP);
            let (after, before) = (
                rotation_from_vector(&(v + step)),
                rotation_from_vector(&(v - step)),
            );
            let difference = (after - before) / (2.0 * STEP);
            assert!(
                (slope - difference).amax() <= DIFFERENCE_ERROR,
                "{:e} at {v:?}",
                (slope - difference).amax()
            );
        }
    }
}

#[test]
fn derivatives_of_the_exponential_map_at_zero_are_those_of_its_series() {
    let generators: [Matrix3<f64>; 3] = std::array::from_fn(|k| skew(&Vector3::ith(k, 1.0)));
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let entry = |x: Vector3<Dual2SVec64<3>>| rotation_from_vector(&x)[(i, j)];
        let (value, slope, curvature) = hessian(entry, &Vector3::zeros());
        assert_eq!(value.to_bits(), f64::from(u8::from(i == j)).to_bits());
        // exp(S) = I + S + S²/2 + …
        let expected = Vector3::from_fn(|k, _| generators[k][(i, j)]);
        assert!((slope - expected).amax() <= ROUND_OFF);
        let expected = Matrix3::from_fn(|k, l| {
            let (a, b) = (generators[k], generators[l]);
            ((a * b + b * a) * 0.5)[(i, j)]
        });
        assert!((curvature - expected).amax() <= ROUND_OFF);
    }
}

#[test]
fn second_derivatives_of_the_exponential_map_agree_with_differences_of_the_closed_form() {
    for v in ordinary_rotation_vectors() {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let entry = |x: Vector3<Dual2SVec64<3>>| rotation_from_vector(&x)[(i, j)];
            let (_, _, curvature) = hessian(entry, &v);
            let expected = Matrix3::from_fn(|k, l| {
                let step = Vector3::ith(l, STEP);
                let slope_at = |x: Vector3<f64>| derivative_of_rotation(&x, k)[(i, j)];
                (slope_at(v + step) - slope_at(v - step)) / (2.0 * STEP)
            });
            assert!(
                (curvature - expected).amax() <= DIFFERENCE_ERROR,
                "{:e}",
                (curvature - expected).amax()
            );
        }
    }
}

#[test]
fn derivatives_about_a_fixed_axis_are_powers_of_its_generator() {
    let axis = vector![0.48, -0.6, 0.64];
    // On both sides of the limit of the series, and at zero.
    for angle in [0.0, 1e-9, 0.3, 0.499_999, 0.500_001, 1.0, 3.0] {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let (_, first, second, third) = third_derivative(
                |x: Dual3_64| {
                    let vector = lift_vector::<Dual3_64>(&axis) * x;
                    rotation_from_vector(&vector)[(i, j)]
                },
                angle,
            );
            // d/dθ exp(θ S) = S exp(θ S).
            let (s, rotation) = (skew(&axis), Rotation3::new(axis * angle).into_inner());
            for (found, power) in [(first, s), (second, s * s), (third, s * s * s)] {
                let error = (found - (power * rotation)[(i, j)]).abs();
                assert!(error <= EXACT, "{error:e} at {angle}");
            }
        }
    }
}

#[test]
fn wrench_of_a_force_at_a_point_has_the_torque_of_its_arm() {
    let (force, p_oq) = (vector![1.0, -2.0, 0.5], vector![0.3, 0.1, -0.7]);
    let wrench = Wrench {
        torque: p_oq.cross(&force),
        force,
    };
    // About the point of attack no torque is left.
    let there = wrench.about(&p_oq);
    assert!(there.torque.amax() <= ROUND_OFF);
    assert_eq!(there.force, force);
    let offset = vector![2.0, 1.0, -1.0];
    let elsewhere = wrench.about(&offset);
    assert!((elsewhere.torque - (p_oq - offset).cross(&force)).amax() <= ROUND_OFF);
    let back = elsewhere.about(&-offset);
    assert!((back.torque - wrench.torque).amax() <= ROUND_OFF);
}

#[test]
fn wrench_power_is_the_same_in_all_axes_and_about_all_points() {
    let wrench = Wrench {
        torque: vector![0.3, 0.2, -1.0],
        force: vector![1.0, -2.0, 0.5],
    };
    let (angular, linear) = (vector![0.5, 0.1, 0.9], vector![-1.0, 0.4, 0.3]);
    let power: f64 = wrench.torque.dot(&angular) + wrench.force.dot(&linear);
    let offset = vector![0.2, 0.7, -0.5];
    let moved = wrench.about(&offset);
    let velocity_there = linear + angular.cross(&offset);
    let power_there: f64 = moved.torque.dot(&angular) + moved.force.dot(&velocity_there);
    assert!((power_there - power).abs() <= ROUND_OFF);
    let rotation = rotation_from_vector(&vector![1.0, 0.3, -0.4]);
    let turned = wrench.rotated(&rotation);
    let power_turned: f64 =
        turned.torque.dot(&(rotation * angular)) + turned.force.dot(&(rotation * linear));
    assert!((power_turned - power).abs() <= ROUND_OFF);
}

#[test]
fn wrenches_add_and_negate_by_components() {
    let a = Wrench {
        torque: vector![1.0, 2.0, 3.0],
        force: vector![4.0, 5.0, 6.0],
    };
    let b = Wrench {
        torque: vector![10.0, 20.0, 30.0],
        force: vector![40.0, 50.0, 60.0],
    };
    assert_eq!(
        (a + b).to_vector(),
        Vector6::new(11.0, 22.0, 33.0, 44.0, 55.0, 66.0)
    );
    let mut sum = Wrench::zero();
    sum += a;
    assert_eq!((sum + -a).to_vector(), Vector6::zeros());
}

// f(x) = x³ + sin x.
fn cubic_and_sine<T: Scalar>(x: T) -> T {
    x * x * x + x.sin()
}

/// Where the functions are tried.
const X: f64 = 0.7;

/// f, f′, f″, f‴ at [`X`].
fn expected_derivatives() -> [f64; 4] {
    let (sine, cosine) = X.sin_cos();
    [
        X.powi(3) + sine,
        3.0 * X * X + cosine,
        6.0 * X - sine,
        6.0 - cosine,
    ]
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= ROUND_OFF,
            "{found} is not {expected}"
        );
    }
}

#[test]
fn scalars_of_one_variable_carry_the_derivatives_of_their_order() {
    let expected = expected_derivatives();
    assert_near(&[cubic_and_sine(X)], &expected[..1]);
    let (value, first) = first_derivative(cubic_and_sine::<Dual64>, X);
    assert_near(&[value, first], &expected[..2]);
    let (value, first, second) = second_derivative(cubic_and_sine::<Dual2_64>, X);
    assert_near(&[value, first, second], &expected[..3]);
    let (value, first, second, third) = third_derivative(cubic_and_sine::<Dual3_64>, X);
    assert_near(&[value, first, second, third], &expected);
}

#[test]
fn nested_scalars_carry_derivatives_of_derivatives() {
    let x = Dual2 {
        re: Dual::new(X, 1.0),
        v1: Dual::new(1.0, 0.0),
        v2: Dual::new(0.0, 0.0),
    };
    let y = cubic_and_sine::<Dual2<Dual64>>(x);
    assert_near(&[y.re.re, y.v1.re, y.v2.re], &expected_derivatives()[..3]);
    assert_near(
        &[y.re.eps, y.v1.eps, y.v2.eps],
        &expected_derivatives()[1..],
    );
    assert_near(&[real_part(y)], &expected_derivatives()[..1]);
}

// f(v) = x y² + sin z.
fn product_and_sine<T: Scalar>(v: &Vector3<T>) -> T {
    v.x * v.y * v.y + v.z.sin()
}

#[test]
fn scalars_of_many_variables_carry_gradients_and_hessians() {
    let v = vector![2.0, -3.0, X];
    let (sine, cosine) = X.sin_cos();
    let expected_gradient = [9.0, -12.0, cosine];
    let expected_hessian = Matrix3::new(
        0.0, -6.0, 0.0, //
        -6.0, 4.0, 0.0, //
        0.0, 0.0, -sine,
    );
    let (value, slope) = gradient(|v: Vector3<DualSVec64<3>>| product_and_sine(&v), &v);
    assert_near(&[value], &[18.0 + sine]);
    assert_near(slope.as_slice(), &expected_gradient);
    let (value, slope, curvature) = hessian(|v: Vector3<Dual2SVec64<3>>| product_and_sine(&v), &v);
    assert_near(&[value], &[18.0 + sine]);
    assert_near(slope.as_slice(), &expected_gradient);
    assert_near(curvature.as_slice(), expected_hessian.as_slice());
}

/// Two variables for the first derivative, one for the second.
type Mixed = HyperDualSVec64<2, 1>;

#[test]
fn hyper_dual_scalars_carry_mixed_derivatives() {
    let in_x_and_y = |(x, y): (HyperDual64, HyperDual64)| product_and_sine(&vector![x, y, lift(X)]);
    let (value, by_x, by_y, by_both) = second_partial_derivative(in_x_and_y, (2.0, -3.0));
    assert_near(
        &[value, by_x, by_y, by_both],
        &[18.0 + X.sin(), 9.0, -12.0, -6.0],
    );
    let in_xz_and_y = |(xz, y): (SVector<Mixed, 2>, SVector<Mixed, 1>)| {
        product_and_sine(&vector![xz[0], y[0], xz[1]])
    };
    let (_, by_xz, by_y, by_both) =
        partial_hessian(in_xz_and_y, (&vector![2.0, X], &vector![-3.0]));
    assert_near(by_xz.as_slice(), &[9.0, X.cos()]);
    assert_near(by_y.as_slice(), &[-12.0]);
    assert_near(by_both.as_slice(), &[-6.0, 0.0]);
}

#[test]
fn lifted_numbers_come_back_with_no_derivative() {
    let constant: Dual64 = lift(X);
    assert_near(&[constant.re, constant.eps], &[X, 0.0]);
    let vector = vector![1.0, -2.0, X];
    assert_eq!(real_vector(&lift_vector::<Dual2_64>(&vector)), vector);
    assert_near(&[real_part(Dual64::new(X, 5.0))], &[X]);
}

#[test]
fn poses_of_first_order_have_the_first_derivatives_of_second_order() {
    let change = Matrix3::new(0.3, -0.7, 0.2, 0.5, 0.1, -0.4, 0.9, -0.2, 0.6);
    for v in rotation_vectors() {
        let real = rotation_from_vector(&v);
        let entry = |i: usize, j: usize| (real[(i, j)], change[(i, j)]);
        // The derivative of the matrix is no turn: what a pose makes of it is.
        let first = Matrix3::from_fn(|i, j| Dual64::new(entry(i, j).0, entry(i, j).1));
        let second = Matrix3::from_fn(|i, j| Dual2_64::new(entry(i, j).0, entry(i, j).1, 0.0));
        let first = Pose::new(first, Vector3::zeros()).unwrap();
        let second = Pose::new(second, Vector3::zeros()).unwrap();
        let (found, expected) = (first.rotation(), second.rotation());
        let error = found.map(|n| n.eps) - expected.map(|n| n.v1);
        assert!(error.amax() <= EXACT, "{:e}", error.amax());
        let no_turn = real.transpose() * found.map(|n| n.eps);
        assert!((no_turn + no_turn.transpose()).amax() <= EXACT);
        let error = found.map(|n| n.re) - expected.map(|n| n.re);
        assert!(error.amax() <= ROUND_OFF, "{:e}", error.amax());
    }
}
