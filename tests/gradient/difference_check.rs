//! The difference check of derivatives, tested on functions with known derivatives, correct and wrong.

use crate::support::worlds::{dynamic, icosphere};
use hydroelastic::dynamics::{
    Force, ForceContext, Material, Plan, Trajectory, World, WrenchAccumulator,
};
use hydroelastic::gradient::{DifferenceCheck, Experiment, GradientError, Outcome, Parameter};
use hydroelastic::scalar::{Scalar, lift, real_part};
use nalgebra::{DMatrix, vector};

/// Rounding error of a difference over a step of 1e-3.
const ROUNDING: f64 = 1e-12;

/// Rounding error of a difference over the shortest step, 1e-9.
const ROUNDING_AT_SHORTEST: f64 = 1e-6;

/// Curvature of a logarithm over a thirtieth of its argument, and rounding error of a difference over so short a step.
const SHORT_STEPS: f64 = 1e-4;

/// Mass (kg), force (N), duration (s).
const KILOGRAMS: f64 = 4.0;
const PUSH: f64 = 6.0;
const STEPS: usize = 8;
const TIME_STEP: f64 = 0.125;

/// Final position of the ball along y (m).
const PLACE: f64 = 2.0;

/// Distance (m) of the ball from the singularity of [`Reading::Logarithm`], which is between the steps 1e-4 and 1e-5.
const REACH: f64 = 3e-5;

fn position() -> Parameter {
    Parameter::initial_position("ball")
}

fn velocity() -> Parameter {
    Parameter::initial_velocity("ball")
}

fn mass() -> Parameter {
    Parameter::mass("ball")
}

/// A force that is the same for every body, independent of its mass.
struct Push;

impl Force for Push {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        for body in 0..now.bodies.len() {
            wrenches.apply_force_at_com(body, &vector![lift(PUSH), lift(0.0), lift(0.0)]);
        }
    }
}

/// Returns a single ball, which moves by 1 s × its velocity, and by ½·F/m·(1 s)² along x.
fn world() -> World<f64, Push> {
    let ball = icosphere(0.1, 0);
    let skin = Material::elastic(1e5);
    let ball = dynamic("ball", ball, skin, KILOGRAMS);
    let ball = ball.with_velocity(vector![0.0, 2.0, 0.5]);
    World::new(vec![ball]).unwrap().with_forces(Push).unwrap()
}

/// A function of the ball's final position (x, y, z).
enum Reading {
    /// 2 x, z − 3 y: differences are exact at every step.
    Linear,
    /// y³, and a thousand times y.
    CubeAndMore,
    /// y³: the error of a difference over the step h is h².
    Cube,
    /// x, whose derivative with respect to the mass is −x/m.
    X,
    /// 2 y with the derivative of y.
    Half,
    /// y with the derivative of −y.
    Opposite,
    /// 0 with the derivative of y.
    Imagined,
    /// y with no derivative.
    Forgotten,
    /// A constant.
    Constant,
    /// The distance of y from its final value, 2, as a square root: the derivative is 0/0.
    Distance,
    /// y, and NaN without derivatives.
    Unknown,
    /// The logarithm of the distance of x from a point slightly below the final x. Beyond this point, the logarithm is NaN.
    Logarithm,
    /// y with its derivative, but NaN at the final position of the ball.
    Hole,
    /// y, and twice y beyond the final position of the ball.
    Growing,
    /// As many zeros as the scalar has components: its value and its derivatives.
    AsManyAsNumbers,
}

impl Outcome for Reading {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[0].position();
        let [x, y, z] = [position.x, position.y, position.z];
        let constant_y = lift::<T>(real_part(y));
        match self {
            Self::Linear => vec![x * 2.0, z - y * 3.0],
            Self::CubeAndMore => vec![y * y * y, y * 1_000.0],
            Self::Cube => vec![y * y * y],
            Self::X => vec![x],
            Self::Half => vec![y + constant_y],
            Self::Opposite => vec![constant_y * 2.0 - y],
            Self::Imagined => vec![y - constant_y],
            Self::Forgotten => vec![constant_y],
            Self::Constant => vec![lift(3.0)],
            Self::Distance => vec![((y - PLACE) * (y - PLACE)).sqrt()],
            Self::Unknown => vec![y, lift(f64::NAN)],
            Self::Logarithm => vec![(x - (PUSH / KILOGRAMS / 2.0 - REACH)).ln()],
            Self::Hole if constant_y == lift::<T>(PLACE) => vec![y + f64::NAN],
            Self::Growing if real_part(y) > PLACE => vec![y; 2],
            Self::Hole | Self::Growing => vec![y],
            Self::AsManyAsNumbers => vec![lift(0.0); size_of::<T>() / size_of::<f64>()],
        }
    }
}

fn checked(parameters: &[Parameter], outcome: &Reading) -> DifferenceCheck {
    let world = world();
    let experiment = Experiment::new(&world, &Plan::new(TIME_STEP, STEPS).unwrap());
    experiment.difference_check(parameters, outcome).unwrap()
}

/// Returns the errors with respect to the ball's y at each step.
fn errors_by_y(outcome: &Reading) -> Vec<f64> {
    let check = checked(&[position()], outcome);
    check.errors.column(1).iter().copied().collect()
}

#[test]
fn right_derivatives_agree_at_every_step_but_for_rounding() {
    let check = checked(&[position(), velocity()], &Reading::Linear);
    assert_eq!(check.errors.shape(), (7, 6));
    for (step, errors) in check.steps.iter().zip(check.errors.row_iter()) {
        assert!(errors.amax() <= ROUNDING / step * 1e-3, "{errors}");
    }
    assert!(check.best() <= ROUNDING);
}

/// Compares the errors of a column at the two longest steps, at which rounding errors are smallest.
fn assert_first_errors(check: &DifferenceCheck, column: usize, expected: impl Fn(f64) -> f64) {
    let errors = check.errors.column(column);
    for (&step, error) in check.steps.iter().zip(errors.iter()).take(2) {
        let rounding = ROUNDING / step * 1e-3;
        assert!((error - expected(step)).abs() <= rounding, "{error:e}");
    }
}

#[test]
fn differences_of_a_cube_are_off_by_the_square_of_the_step() {
    let check = checked(&[position()], &Reading::Cube);
    // 3 y² + h² against 3 y², at y = 2.
    assert_first_errors(&check, 1, |step| step * step / (12.0 + step * step));
    let rounding_grows = check.errors[(6, 1)] > check.errors[(3, 1)];
    assert!(rounding_grows && check.errors[(6, 1)] <= ROUNDING_AT_SHORTEST);
}

#[test]
fn errors_are_relative_to_the_largest_derivative_by_the_number() {
    let error = errors_by_y(&Reading::CubeAndMore)[0];
    let expected = 1e-6 / 1_000.0;
    assert!((error - expected).abs() <= ROUNDING, "{error:e}");
}

#[test]
fn steps_by_a_mass_are_parts_of_it() {
    let check = checked(&[mass()], &Reading::X);
    // F/(m − h) − F/(m + h) over 2 h is F/(m² − h²).
    assert_first_errors(&check, 0, |step| step * step);
}

/// A force along x that is the cube of a parameter.
struct Cubed;

impl Force for Cubed {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let number = now.parameter("number").unwrap_or(lift(0.0));
        let force = number * number * number;
        wrenches.apply_force_at_com(0, &vector![force, lift(0.0), lift(0.0)]);
    }
}

#[test]
fn steps_by_a_number_of_forces_are_parts_of_its_magnitude_or_of_1_if_it_is_0() {
    let check = |number: f64| {
        let world = world().with_forces(Cubed).unwrap();
        let world = world.with_force_parameter("number", number).unwrap();
        let experiment = Experiment::new(world, &Plan::new(TIME_STEP, STEPS).unwrap());
        let by = [Parameter::force_parameter("number")];
        experiment.difference_check(&by, &Reading::X).unwrap()
    };
    // 3 n² + h² against 3 n², where h is relative to n.
    for number in [-2.0, 0.5] {
        assert_first_errors(&check(number), 0, |step| step * step / (3.0 + step * step));
    }
    // h² against 0.
    assert_first_errors(&check(0.0), 0, |_| 1.0);
}

#[test]
fn wrong_derivatives_are_off_at_every_step_by_as_much_as_they_are_wrong() {
    let wrong = [
        (Reading::Half, 0.5),
        (Reading::Opposite, 2.0),
        (Reading::Imagined, 1.0),
        (Reading::Forgotten, 1.0),
    ];
    for (outcome, expected) in wrong {
        let check = checked(&[position()], &outcome);
        for error in check.errors.column(1).iter() {
            assert!((error - expected).abs() <= ROUNDING_AT_SHORTEST, "{error}");
        }
        assert!((check.best() - expected).abs() <= ROUNDING_AT_SHORTEST);
        // x and z have no effect.
        assert!(
            check
                .errors
                .column(0)
                .amax()
                .max(check.errors.column(2).amax())
                <= 0.0
        );
    }
}

#[test]
fn an_outcome_that_depends_on_nothing_has_no_error() {
    let check = checked(&[position(), mass()], &Reading::Constant);
    assert!(check.errors.amax() <= 0.0);
    assert!(check.best() <= 0.0);
}

#[test]
fn a_derivative_that_is_not_finite_is_an_infinite_error_at_every_step() {
    let check = checked(&[position()], &Reading::Distance);
    assert!(check.errors.iter().all(|error| *error == f64::INFINITY));
    assert_eq!(check.best_by_parameter(), [f64::INFINITY; 3]);
    assert!(check.best().is_infinite());
    assert_eq!(check.plateau(1), None);
}

#[test]
fn an_outcome_that_is_not_finite_is_an_infinite_error() {
    for outcome in [Reading::Unknown, Reading::Hole] {
        let check = checked(&[position()], &outcome);
        assert_eq!(check.best_by_parameter(), [f64::INFINITY; 3]);
    }
}

#[test]
fn an_outcome_whose_length_depends_on_values_is_refused() {
    let world = world();
    let experiment = Experiment::new(&world, &Plan::new(TIME_STEP, STEPS).unwrap());
    let (expected, found) = (1, 2);
    let error = experiment.difference_check(&[position()], &Reading::Growing);
    let lengths = GradientError::OutcomeLength { expected, found };
    assert_eq!(error.unwrap_err(), lengths);
    assert_eq!(
        lengths.to_string(),
        "the outcome has 2 numbers in one rollout and 1 in another, but its length must not depend on values"
    );
}

#[test]
fn an_outcome_whose_length_depends_on_the_scalar_is_refused() {
    let world = world();
    let experiment = Experiment::new(&world, &Plan::new(TIME_STEP, STEPS).unwrap());
    let outcome = Reading::AsManyAsNumbers;
    // One parameter takes a dual number of width six; 97 parameters take one of width 96 and one of width six.
    let error = experiment
        .difference_check(&[mass()], &outcome)
        .unwrap_err();
    let (expected, found) = (1 + 6, 1);
    assert_eq!(error, GradientError::OutcomeLength { expected, found });
    let error = experiment
        .jacobian(&vec![mass(); 97], &outcome)
        .unwrap_err();
    let (expected, found) = (1 + 96, 1 + 6);
    assert_eq!(error, GradientError::OutcomeLength { expected, found });
}

#[test]
fn a_difference_that_is_not_finite_is_an_infinite_error_at_its_step_alone() {
    let check = checked(&[position()], &Reading::Logarithm);
    let errors = check.errors.column(0);
    let (reached, others) = (errors.rows(0, 2), errors.rows(2, 5));
    assert!(reached.iter().all(|error| *error == f64::INFINITY));
    assert!(others.iter().all(|error| error.is_finite()));
    assert!(check.best() <= SHORT_STEPS, "{check}");
    let (_, longest) = check.plateau(0).unwrap();
    assert!(longest < 1e-4, "{longest:e}");
}

#[test]
fn columns_are_named_after_the_parameters_and_their_numbers() {
    let check = checked(&[position(), mass()], &Reading::Constant);
    let expected = [
        "InitialPosition(\"ball\") x",
        "InitialPosition(\"ball\") y",
        "InitialPosition(\"ball\") z",
        "Mass(\"ball\")",
    ];
    assert_eq!(check.numbers, expected);
}

/// Returns a check of two parameters at three steps with these errors.
fn with_errors(errors: [[f64; 2]; 3]) -> DifferenceCheck {
    let mut check = checked(&[mass(), mass()], &Reading::Constant);
    check.steps = vec![1e-2, 1e-4, 1e-6];
    check.errors = DMatrix::from_fn(3, 2, |row, column| errors[row][column]);
    check
}

#[test]
fn the_best_is_the_worst_of_what_each_number_has_at_its_best_step() {
    let check = with_errors([[1e-3, 2e-8], [1e-9, 5e-7], [1e-5, 3e-8]]);
    assert_eq!(check.best_by_parameter(), [1e-9, 2e-8]);
    assert!((check.best() - 2e-8).abs() <= 0.0);
}

#[test]
fn the_plateau_reaches_over_the_steps_within_ten_times_the_best() {
    let check = with_errors([[1e-3, 2e-8], [1e-9, 5e-7], [9e-9, 3e-8]]);
    assert_eq!(check.plateau(0), Some((1e-6, 1e-4)));
    assert_eq!(check.plateau(1), Some((1e-6, 1e-2)));
    let alone = with_errors([[1.1e-8, 0.0], [1e-9, 1.0], [1.1e-8, 1.0]]);
    assert_eq!(alone.plateau(0), Some((1e-4, 1e-4)));
    assert_eq!(alone.plateau(1), Some((1e-2, 1e-2)));
}

#[test]
fn the_check_prints_a_line_for_each_number() {
    let check = with_errors([[1e-3, 2e-8], [1e-9, 5e-7], [9e-9, 3e-8]]);
    let expected = "Mass(\"ball\"): 1.0e-9 (steps 1e-6 to 1e-4)\n\
        Mass(\"ball\"): 2.0e-8 (steps 1e-6 to 1e-2)";
    assert_eq!(check.to_string(), expected);
}

/// The fields of a check are public, so a check may be created or changed manually.
#[test]
fn errors_that_are_not_numbers_count_as_infinite() {
    let [nan, inf] = [f64::NAN, f64::INFINITY];
    let check = with_errors([[nan, nan], [1e-9, inf], [2e-9, nan]]);
    assert_eq!(check.best_by_parameter(), [1e-9, inf]);
    assert!(check.best().is_infinite());
    assert_eq!(check.plateau(0), Some((1e-6, 1e-4)));
    assert_eq!(check.plateau(1), None);
    let expected = "Mass(\"ball\"): 1.0e-9 (steps 1e-6 to 1e-4)\n\
        Mass(\"ball\"): inf (finite at no step)";
    assert_eq!(check.to_string(), expected);
}
