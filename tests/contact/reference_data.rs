//! Wrenches and Jacobians against the numbers of independent programs.

use super::structure::both_ways;
use crate::support::reference::{jacobian_cases, wrench_cases};
use hydroelastic::contact::ContactWrench;
use nalgebra::{DMatrix, SMatrix, SVector, Vector3};

/// Tolerance of wrenches. The programs agree with each other to 1.5e-14; meshes with larger torque arms need more.
const WRENCH: f64 = 1e-11;

/// Tolerance of central differences. The differences of the reference have an error of about 1e-9.
const DIFFERENCES: f64 = 1e-7;

/// Tolerance of complex-step Jacobians, which are exact to round-off. Their poses are printed with 17 digits.
const COMPLEX_STEP: f64 = 1e-11;

/// Returns rows and columns in the order of a 12×12 or 12×14 reference matrix: force first, translation first.
fn in_reference_order(jacobian: &SMatrix<f64, 12, 28>) -> DMatrix<f64> {
    let swap = |k: usize| (k / 6) * 6 + (k % 6 + 3) % 6;
    DMatrix::from_fn(12, 14, |row, column| {
        let column = if column < 12 {
            swap(column)
        } else {
            column + 12
        };
        jacobian[(swap(row), column)]
    })
}

fn wrench_in_reference_order(wrench: &ContactWrench) -> SVector<f64, 12> {
    let parts = [
        wrench.on_a.force,
        wrench.on_a.torque,
        wrench.on_b.force,
        wrench.on_b.torque,
    ];
    SVector::from_fn(|row, _| parts[row / 3][row % 3])
}

fn assert_close(name: &str, actual: &Vector3<f64>, expected: [f64; 3], scale: f64) {
    let error = (actual - Vector3::from(expected)).amax();
    assert!(
        error <= WRENCH * scale,
        "{name}: {actual:?}, not {expected:?}"
    );
}

#[test]
fn wrenches_equal_those_of_independent_programs() {
    for case in wrench_cases().iter().filter(|case| !case.degenerate) {
        let shapes = case.posed.shapes();
        let pair = case.posed.pair(&shapes);
        let (wrench, surface) = (pair.wrench(), pair.surface());
        let expected = &case.wrench;
        let force = Vector3::from(expected.force_a).norm();
        assert_close(&case.name, &wrench.on_a.force, expected.force_a, force);
        assert_close(&case.name, &wrench.on_b.force, expected.force_b, force);
        // If the force passes near an origin, its torque there is a small difference. The scale is therefore the torque of the force with
        // an arm of 1 m on these meshes.
        let torque = |expected: [f64; 3]| Vector3::from(expected).norm().max(force);
        let (torque_a, torque_b) = (expected.torque_a.unwrap(), expected.torque_b.unwrap());
        assert_close(&case.name, &wrench.on_a.torque, torque_a, torque(torque_a));
        assert_close(&case.name, &wrench.on_b.torque, torque_b, torque(torque_b));
        // Between equal plateaus of a layered mesh, the plane is arbitrary.
        if let Some(area) = expected.area.filter(|_| !case.name.starts_with("grid4")) {
            assert!(
                (surface.area() - area).abs() <= WRENCH * area,
                "{}",
                case.name
            );
        }
    }
}

#[test]
fn forces_of_degenerate_cases_equal_those_of_independent_programs() {
    let cases = wrench_cases();
    let degenerate: Vec<_> = cases.iter().filter(|case| case.degenerate).collect();
    assert_eq!(degenerate.len(), 10);
    for case in degenerate {
        let wrench = case.posed.pair(&case.posed.shapes()).wrench();
        let scale = Vector3::from(case.wrench.force_a).norm();
        assert_close(&case.name, &wrench.on_a.force, case.wrench.force_a, scale);
        assert_close(&case.name, &wrench.on_b.force, case.wrench.force_b, scale);
    }
}

#[test]
fn jacobians_equal_the_central_differences_of_independent_programs() {
    let mut compared = 0;
    for case in wrench_cases() {
        let Some(expected) = &case.jacobian else {
            continue;
        };
        let shapes = case.posed.shapes();
        let pair = case.posed.pair(&shapes);
        let expected = DMatrix::from_fn(12, 12, |i, j| expected[i][j]);
        for (_, jacobian) in both_ways(&pair) {
            let actual = in_reference_order(&jacobian);
            let error = (actual.columns(0, 12) - &expected).amax();
            assert!(
                error <= DIFFERENCES * expected.amax(),
                "{}: {error:e}",
                case.name
            );
            let by_moduli = [
                (12, case.force_a_by_modulus_a),
                (13, case.force_a_by_modulus_b),
            ];
            for (column, expected) in by_moduli {
                let expected = Vector3::from(expected.unwrap());
                let actual = actual.fixed_view::<3, 1>(0, column);
                let error = (actual - expected).amax();
                assert!(
                    error <= DIFFERENCES * expected.amax(),
                    "{}: {error:e}",
                    case.name
                );
            }
        }
        compared += 1;
    }
    assert_eq!(compared, 29);
}

#[test]
fn jacobians_equal_complex_step_jacobians() {
    let cases = jacobian_cases();
    assert_eq!(cases.len(), 8);
    for case in cases {
        let shapes = case.posed.shapes();
        let pair = case.posed.pair(&shapes);
        let mut expected = DMatrix::from_fn(12, 14, |i, j| case.jacobian[i][j]);
        // The reference differentiates with respect to the logarithms of the moduli.
        expected
            .column_mut(12)
            .scale_mut(1.0 / case.posed.modulus_a);
        expected
            .column_mut(13)
            .scale_mut(1.0 / case.posed.modulus_b);
        for (wrench, jacobian) in both_ways(&pair) {
            let error = (wrench_in_reference_order(&wrench) - SVector::from(case.wrench)).amax();
            assert!(error <= WRENCH * SVector::from(case.wrench).amax());
            let error = (in_reference_order(&jacobian) - &expected).amax();
            assert!(error <= COMPLEX_STEP * expected.amax(), "{error:e}");
        }
        assert!((pair.surface().area() - case.area).abs() <= WRENCH * case.area);
    }
}
