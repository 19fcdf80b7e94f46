//! Where there is no derivative, or none that is finite: experiments say so, and where it is lost.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Acceleration, Batch, Body, ExternalForces, Mass, Material, Situation, Trajectory, World,
};
use hydroelastic::gradient::{
    Experiment, FinalPosition, GradientError, Outcome, OutcomeJacobian, Parameter,
};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use nalgebra::vector;

const MASS: Parameter = Parameter::Mass("ball");
const VELOCITY: Parameter = Parameter::InitialVelocity("ball");

/// A power of two: times are exact.
const TIME_STEP: f64 = 0.125;
const STEPS: usize = 8;

/// Rounding of a difference over a step of 1e-3.
const ROUNDING: f64 = 1e-12;

/// A force at rest that is none, but whose derivative is lost.
enum Lost {
    /// Nowhere.
    Nowhere,
    /// From this time (s) on: drag by |v|·v, with 0/0 for the derivative of |v| at rest.
    Drag { from: f64 },
    /// By v_y alone, within two steps: it grows by more than 1e199 in each.
    Overflow,
}

impl ExternalForces for Lost {
    fn acceleration<T: Scalar>(
        &self,
        situation: &Situation<T>,
        contact: Acceleration<T>,
    ) -> Acceleration<T> {
        let velocity = situation.state.velocity();
        let linear = match self {
            Self::Drag { from } if situation.time >= *from => {
                velocity * -velocity.dot(velocity).sqrt()
            }
            Self::Overflow => vector![lift(0.0), velocity.y * 1e200, lift(0.0)],
            Self::Nowhere | Self::Drag { .. } => return contact,
        };
        Acceleration {
            linear: contact.linear + linear,
            ..contact
        }
    }
}

fn ball(name: &str, skin: Material) -> Body {
    let ball = Shape::new(shapes::icosphere(0.1, 0).unwrap());
    Body::dynamic(name, ball, skin, Mass::Total(4.0)).unwrap()
}

/// A ball at rest.
fn world(external: Lost) -> World<f64, Lost> {
    let ball = ball("ball", Material::elastic(1e5));
    World::new(vec![ball]).unwrap().with_external(external)
}

fn experiment(world: &World<f64, Lost>) -> Experiment<'_, Lost> {
    Experiment::new(world, TIME_STEP, STEPS).unwrap()
}

fn place(world: &World<f64, Lost>) -> FinalPosition {
    FinalPosition::of_body(world, "ball").unwrap()
}

/// The step, time (s) and number of a state's derivative that was lost, and what was found.
fn lost_in_state(error: GradientError) -> (usize, f64, String, OutcomeJacobian) {
    match error {
        GradientError::StateDerivativeNotFinite {
            step,
            time,
            body,
            number,
            found,
        } if body == "ball" => (step, time, number, *found),
        error => panic!("{error}"),
    }
}

#[test]
fn a_derivative_that_a_force_loses_is_refused_with_the_first_step_that_lacks_it() {
    // Leapfrog asks for forces in the middle of a step; step 5 begins at 0.5 s.
    for (from, expected) in [(0.0, 1), (0.5, 5), (0.9, 8)] {
        let drag = || Lost::Drag { from };
        for every in [1, 2, STEPS] {
            let world = world(drag());
            let experiment = experiment(&world).recording_every(every);
            let error = experiment.jacobian(&[MASS, VELOCITY], &place(&world));
            let (step, time, number, _) = lost_in_state(error.unwrap_err());
            assert_eq!((step, number.as_str()), (expected, "Mass(\"ball\")"));
            assert!((time - expected as f64 * TIME_STEP).abs() <= 0.0);
        }
    }
}

#[test]
fn an_overflow_is_named_after_the_number_it_is_by_and_the_other_columns_are_kept() {
    let world = world(Lost::Overflow);
    let error = experiment(&world)
        .jacobian(&[MASS, VELOCITY], &place(&world))
        .unwrap_err();
    assert!(error.to_string().starts_with(
        "step 2 (t = 0.25 s) took body \"ball\" to a state whose derivative by InitialVelocity(\"ball\") y is not finite"
    ), "{error}");
    let (.., found) = lost_in_state(error);
    assert_eq!(found.value.as_slice(), [0.0; 3]);
    assert_eq!(found.jacobian.column(1).as_slice(), [1.0, 0.0, 0.0]);
    assert!(!found.jacobian[(1, 2)].is_finite());
    assert_eq!(found.jacobian.column(3).as_slice(), [0.0, 0.0, 1.0]);
}

#[test]
fn a_derivative_that_is_lost_in_the_second_pass_of_many_parameters_is_refused() {
    let mut parameters = vec![MASS; 96];
    parameters.push(VELOCITY);
    let world = world(Lost::Overflow);
    let error = experiment(&world).jacobian(&parameters, &place(&world));
    let (step, _, number, found) = lost_in_state(error.unwrap_err());
    assert_eq!((step, number.as_str()), (2, "InitialVelocity(\"ball\") y"));
    assert_eq!(found.jacobian.ncols(), 96 + 3);
}

#[test]
fn a_lost_derivative_that_the_outcome_does_not_see_is_no_error() {
    let by = [VELOCITY];
    let overflowing = world(Lost::Overflow);
    let x = experiment(&overflowing).jacobian(&by, &Reading::X).unwrap();
    assert_eq!(x.jacobian.as_slice(), [1.0, 0.0, 0.0]);
    // Of eight steps, six are recorded.
    let late = world(Lost::Drag { from: 0.75 });
    let experiment = experiment(&late).recording_every(6);
    assert!(experiment.jacobian(&by, &place(&late)).is_ok());
}

/// Of the ball's last state.
enum Reading {
    /// x.
    X,
    /// x, and |v| by a root, with 0/0 for its derivative at rest.
    Speed,
    /// x, and y by 1e307.
    Huge,
    /// x + z, and y by more than there are numbers for.
    TooHuge,
}

impl Outcome for Reading {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let ball = &trajectory.last().bodies[0];
        let (position, velocity) = (ball.position(), ball.velocity());
        match self {
            Self::X => vec![position.x],
            Self::Speed => vec![position.x, velocity.dot(velocity).sqrt()],
            Self::Huge => vec![position.x, position.y * 1e307],
            Self::TooHuge => vec![position.x + position.z, position.y * 1e307 * 1e307],
        }
    }
}

#[test]
fn a_derivative_that_the_outcome_itself_loses_is_refused_with_its_row() {
    let world = world(Lost::Nowhere);
    let error = experiment(&world)
        .jacobian(&[VELOCITY], &Reading::Speed)
        .unwrap_err();
    let message = "number 1 of the outcome, counted from 0, has a derivative by InitialVelocity(\"ball\") x that is not finite, though those of all states are: the outcome may take a root or a norm of zero";
    assert_eq!(error.to_string(), message);
    let GradientError::OutcomeDerivativeNotFinite { row, number, found } = error else {
        panic!("{error}")
    };
    assert_eq!((row, number.as_str()), (1, "InitialVelocity(\"ball\") x"));
    assert_eq!(
        found.jacobian.row(0).transpose().as_slice(),
        [1.0, 0.0, 0.0]
    );
}

#[test]
fn derivatives_that_are_zero_or_huge_are_no_errors() {
    let world = world(Lost::Nowhere);
    let by = [MASS, VELOCITY];
    let found = experiment(&world).jacobian(&by, &Reading::Huge).unwrap();
    let expected = [0.0, 0.0, 1e307, 0.0];
    assert_eq!(found.jacobian.row(1).transpose().as_slice(), expected);
    assert_eq!(found.jacobian.column(0).as_slice(), [0.0, 0.0]);
}

#[test]
fn the_check_has_infinite_errors_by_what_is_lost_and_compares_the_rest() {
    let world = world(Lost::Nowhere);
    let checked = |outcome| {
        let check = experiment(&world).difference_check(&[MASS, VELOCITY], &outcome);
        check.unwrap()
    };
    let check = checked(Reading::TooHuge);
    let best = check.best_by_parameter();
    assert!(best[0] <= 0.0 && best[1] <= ROUNDING && best[3] <= ROUNDING);
    assert!(
        check
            .errors
            .column(2)
            .iter()
            .all(|error| error.is_infinite())
    );
    assert!(check.best().is_infinite());
    let best = checked(Reading::Speed).best_by_parameter();
    assert!(best.iter().all(|error| error.is_infinite()));
}

#[test]
fn a_sample_without_a_derivative_is_an_error_among_the_others() {
    let drag = world(Lost::Drag { from: 0.0 });
    let batch = Batch::new(TIME_STEP, STEPS).unwrap();
    let samples = [[0.5, 0.0, 0.0], [0.0; 3], [0.0, 0.1, 0.0]];
    let slopes = batch.gradients_after(&drag, &[VELOCITY], &samples, &Reading::X);
    let jacobians = batch.jacobians_after(&drag, &[VELOCITY], &samples, &place(&drag));
    assert!(slopes[0].is_ok() && slopes[2].is_ok());
    assert!(jacobians[0].is_ok() && jacobians[2].is_ok());
    let errors = [slopes[1].clone().err(), jacobians[1].clone().err()];
    for error in errors {
        let (step, _, number, _) = lost_in_state(error.unwrap());
        assert_eq!((step, number.as_str()), (1, "InitialVelocity(\"ball\") x"));
    }
}
