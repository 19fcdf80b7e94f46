use super::RobustLoss;
use super::coordinates::Coordinates;
use super::equations::{Equations, QuadraticModel, Step};
use super::unknown::{Nuisance, Unknown};
use crate::contact::Shape;
use crate::dynamics::{Body, Mass, Material, Plan, World};
use crate::gradient::{Experiment, Parameter};
use crate::mesh::shapes;
use crate::scalar::SplitMix64;
use crate::spatial::rotation_from_vector;
use nalgebra::{DMatrix, DVector, Vector3};

/// Round-off of sums of a few dozen products of numbers near 1.
const ROUND_OFF: f64 = 1e-11;

/// Returns equations of a measurement of 5 poses with 2 shared and 3 own coordinates.
fn random_equations(random: &mut SplitMix64) -> Equations {
    let mut matrix = |columns| DMatrix::from_fn(60, columns, |_, _| random.next() - 0.75);
    let [deviations, shared, local] = [1, 2, 3].map(&mut matrix);
    Equations::new(
        RobustLoss::Cauchy(1.0),
        &deviations.column(0).into_owned(),
        &shared,
        &local,
    )
}

#[test]
fn eliminated_equations_give_the_step_of_all_equations_together() {
    let mut random = SplitMix64::default();
    let measurements = [random_equations(&mut random), random_equations(&mut random)];
    let (mut matrix, mut gradient) = (DMatrix::zeros(8, 8), DVector::zeros(8));
    for (equations, first) in measurements.iter().zip([2, 5]) {
        let mut top = matrix.view_mut((0, 0), (2, 2));
        top += &equations.shared.matrix;
        matrix
            .view_mut((first, first), (3, 3))
            .copy_from(&equations.local.matrix);
        matrix
            .view_mut((0, first), (2, 3))
            .copy_from(&equations.coupling);
        matrix
            .view_mut((first, 0), (3, 2))
            .copy_from(&equations.coupling.transpose());
        let mut shared = gradient.rows_mut(0, 2);
        shared += &equations.shared.gradient;
        gradient
            .rows_mut(first, 3)
            .copy_from(&equations.local.gradient);
    }
    let damping = 0.3;
    let mut damped = matrix.clone();
    damped.set_diagonal(&(damped.diagonal() * (1.0 + damping)));
    let expected = -damped.lu().solve(&gradient).unwrap();
    let step = Step::new(&measurements, &QuadraticModel::zeros(2), damping).unwrap();
    let parts = step.shared.iter().chain(step.local.iter().flatten());
    for (found, expected) in parts.zip(expected.iter()) {
        assert!(
            (found - expected).abs() < ROUND_OFF,
            "{found} instead of {expected}"
        );
    }
    let decrease = -gradient.dot(&expected) - 0.5 * expected.dot(&(&matrix * &expected));
    assert!((step.predicted_decrease - decrease).abs() < ROUND_OFF);
}

#[test]
fn derivatives_of_losses_agree_with_differences() {
    for loss in [
        RobustLoss::Squared,
        RobustLoss::Huber(2.0),
        RobustLoss::Cauchy(2.0),
    ] {
        for squared in [0.1, 3.9, 4.1, 100.0] {
            let [value, slope] = loss.at(squared);
            let step = 1e-5 * squared;
            let difference =
                (loss.at(squared + step)[0] - loss.at(squared - step)[0]) / (2.0 * step);
            assert!((difference - slope).abs() < 1e-8 && value <= squared);
        }
    }
}

fn template() -> Experiment {
    let ball = Shape::new(shapes::icosphere(0.1, 1).unwrap());
    let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0)).unwrap();
    Experiment::new(
        World::new(vec![ball]).unwrap(),
        &Plan::new(1e-3, 1).unwrap(),
    )
}

#[test]
fn jacobians_of_values_agree_with_differences() {
    let modulus = Unknown::new(Parameter::modulus("ball")).bounded(1e4, 1e6);
    let mass = Unknown::new(Parameter::mass("ball")).logarithmic();
    let coordinates = Coordinates::of_unknowns(&[modulus, mass], &template()).unwrap();
    let at = DVector::from_vec(vec![0.3, -0.4]);
    let jacobian = coordinates.jacobian(&at);
    for column in 0..2 {
        let moved = |step: f64| {
            let mut at = at.clone();
            at[column] += step;
            DVector::from_vec(coordinates.changes(&at))
        };
        let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((difference - jacobian.column(column)).norm() < 1e-8 * jacobian.norm());
    }
    let values = coordinates.values(&at);
    let restored = coordinates.of_values(&values).unwrap();
    assert!((restored - at).norm() < ROUND_OFF);
}

#[test]
fn jacobians_of_orientations_agree_with_differences_of_rotations() {
    let nuisance = Nuisance::new(Parameter::initial_orientation("ball"), 1.0);
    let coordinates = Coordinates::of_nuisances(&[nuisance], &template()).unwrap();
    let at = Vector3::new(0.7, -0.4, 1.1);
    let jacobian = coordinates.jacobian(&DVector::from_column_slice(at.as_slice()));
    for axis in 0..3 {
        let step = 1e-6;
        let moved = rotation_from_vector(&(at + Vector3::ith(axis, step)));
        let turn = moved * rotation_from_vector(&at).transpose();
        let turn = Vector3::new(turn[(2, 1)], turn[(0, 2)], turn[(1, 0)]) / step;
        assert!((turn - jacobian.fixed_view::<3, 1>(0, axis)).norm() < 1e-5);
    }
}
