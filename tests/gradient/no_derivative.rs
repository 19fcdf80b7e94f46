//! Missing or infinite derivatives: experiments report them, and the step in which they were lost.

use crate::support::worlds::{cuboid, dynamic, icosphere};
use hydroelastic::dynamics::{
    Batch, Body, Force, ForceContext, Material, Plan, StateGradient, Trajectory, World,
    WrenchAccumulator,
};
use hydroelastic::gradient::{
    Experiment, FinalPosition, GradientError, Mode, Outcome, OutcomeJacobian, Parameter,
};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::sync::Arc;

/// Time step (s), a power of two, so that times are exact.
const TIME_STEP: f64 = 0.125;
const STEPS: usize = 8;

/// Rounding error of a difference over a step of 1e-3.
const ROUNDING: f64 = 1e-12;

/// Agreement with differences for a slide with friction.
const RUBBING: f64 = 1e-6;

fn mass() -> Parameter {
    Parameter::mass("ball")
}

fn velocity() -> Parameter {
    Parameter::initial_velocity("ball")
}

/// A force that is zero at rest, but whose derivative is lost.
enum Lost {
    /// No loss.
    Nowhere,
    /// From this time (s) on: drag proportional to |v|·v, with 0/0 for the derivative of |v| at rest.
    Drag { from: f64 },
    /// Overflow of the derivative with respect to v_y only, within two steps, in each of which it grows by more than 1e199. For a slow
    /// body, the overflow takes three steps, in each of which the derivative grows by more than 1e119.
    Overflow,
}

impl Force for Lost {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        for (index, body) in now.bodies.iter().enumerate() {
            let Some(inertia) = body.inertia() else {
                continue;
            };
            let velocity = now.states[index].velocity();
            let linear = match self {
                Self::Drag { from } if now.time >= *from => {
                    velocity * -velocity.dot(velocity).sqrt()
                }
                Self::Overflow if body.name() == "slow" => {
                    vector![lift(0.0), velocity.y * 1e120, lift(0.0)]
                }
                Self::Overflow => vector![lift(0.0), velocity.y * 1e200, lift(0.0)],
                Self::Nowhere | Self::Drag { .. } => continue,
            };
            wrenches.apply_force_at_com(index, &(linear * inertia.mass));
        }
    }
}

type LosingWorld = World<f64, Lost>;

fn ball(name: &str, skin: Material) -> Body {
    let ball = icosphere(0.1, 0);
    dynamic(name, ball, skin, 4.0)
}

/// Returns a ball at rest.
fn world(force: Lost) -> LosingWorld {
    let ball = ball("ball", Material::elastic(1e5));
    World::new(vec![ball]).unwrap().with_forces(force).unwrap()
}

fn plan() -> Plan {
    Plan::new(TIME_STEP, STEPS).unwrap()
}

fn experiment(world: &LosingWorld) -> Experiment {
    Experiment::new(world, &plan())
}

fn final_position(world: &LosingWorld) -> FinalPosition {
    FinalPosition::of_body(world, "ball").unwrap()
}

/// Returns the step, time (s) and component of the state derivative that was lost, and the results.
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
    // Leapfrog evaluates forces in the middle of a step; step 5 begins at 0.5 s.
    for (from, expected) in [(0.0, 1), (0.5, 5), (0.9, 8)] {
        let drag = || Lost::Drag { from };
        for every in [1, 2, STEPS] {
            let world = world(drag());
            let experiment = Experiment::new(&world, &plan().recording_every(every));
            let error = experiment.jacobian(&[mass(), velocity()], &final_position(&world));
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
        .jacobian(&[mass(), velocity()], &final_position(&world))
        .unwrap_err();
    assert!(error.to_string().starts_with(
        "step 2 (t = 0.25 s) took body \"ball\" to a state whose derivative with respect to InitialVelocity(\"ball\") y is not finite"
    ), "{error}");
    let (.., jacobian) = lost_in_state(error);
    assert_eq!(jacobian.value.as_slice(), [0.0; 3]);
    assert_eq!(jacobian.jacobian.column(1).as_slice(), [1.0, 0.0, 0.0]);
    assert!(!jacobian.jacobian[(1, 2)].is_finite());
    assert_eq!(jacobian.jacobian.column(3).as_slice(), [0.0, 0.0, 1.0]);
}

#[test]
fn a_derivative_that_is_lost_in_the_second_pass_of_many_parameters_is_refused() {
    let mut parameters = vec![mass(); 96];
    parameters.push(velocity());
    let world = world(Lost::Overflow);
    let error = experiment(&world).jacobian(&parameters, &final_position(&world));
    let (step, _, number, outcome_jacobian) = lost_in_state(error.unwrap_err());
    assert_eq!((step, number.as_str()), (2, "InitialVelocity(\"ball\") y"));
    assert_eq!(outcome_jacobian.jacobian.ncols(), 96 + 3);
}

#[test]
fn of_derivatives_that_are_lost_in_several_passes_the_earliest_is_named() {
    let skin = Material::elastic(1e5);
    let world = World::new(vec![ball("slow", skin), ball("ball", skin)]).unwrap();
    let world = world.with_ignored("slow", "ball").unwrap();
    let world = world.with_forces(Lost::Overflow).unwrap();
    let slow = Parameter::initial_velocity("slow");
    for [first, last] in [[slow.clone(), velocity()], [velocity(), slow]] {
        let mut parameters = vec![first];
        parameters.extend(vec![mass(); 93]);
        parameters.push(last);
        let error = experiment(&world).jacobian(&parameters, &Reading::Sum);
        let (step, _, number, _) = lost_in_state(error.unwrap_err());
        assert_eq!((step, number.as_str()), (2, "InitialVelocity(\"ball\") y"));
    }
}

#[test]
fn a_lost_derivative_that_the_outcome_does_not_see_is_no_error() {
    let by = [velocity()];
    let overflowing = world(Lost::Overflow);
    let x = experiment(&overflowing).jacobian(&by, &Reading::X).unwrap();
    assert_eq!(x.jacobian.as_slice(), [1.0, 0.0, 0.0]);
}

#[test]
fn the_last_state_is_seen_whatever_is_recorded() {
    let late = world(Lost::Drag { from: 0.75 });
    let experiment = Experiment::new(&late, &plan().recording_every(6));
    assert!(
        experiment
            .jacobian(&[velocity()], &final_position(&late))
            .is_err()
    );
}

/// A function of the first body's final state.
enum Reading {
    /// y, summed over all bodies.
    Sum,
    /// x.
    X,
    /// x, and |v| as a square root, with 0/0 for its derivative at rest.
    Speed,
    /// x, and y times 1e307.
    Huge,
    /// x + z, and y times a factor that overflows.
    TooHuge,
}

impl Outcome for Reading {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let ball = &trajectory.last().bodies[0];
        let (position, velocity) = (ball.position(), ball.velocity());
        match self {
            Self::Sum => {
                let bodies = trajectory.last().bodies.iter();
                vec![bodies.fold(lift(0.0), |sum: T, body| sum + body.position().y)]
            }
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
        .jacobian(&[velocity()], &Reading::Speed)
        .unwrap_err();
    let message = "number 1 of the outcome, counted from 0, has a derivative with respect to InitialVelocity(\"ball\") x that is not finite, although the derivatives of all states are finite: the outcome may take a root or a norm of zero";
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
    let by = [mass(), velocity()];
    let outcome_jacobian = experiment(&world).jacobian(&by, &Reading::Huge).unwrap();
    let expected = [0.0, 0.0, 1e307, 0.0];
    assert_eq!(
        outcome_jacobian.jacobian.row(1).transpose().as_slice(),
        expected
    );
    assert_eq!(outcome_jacobian.jacobian.column(0).as_slice(), [0.0, 0.0]);
}

#[test]
fn the_check_has_infinite_errors_by_what_is_lost_and_compares_the_rest() {
    let world = world(Lost::Nowhere);
    let checked = |outcome| {
        let check = experiment(&world).difference_check(&[mass(), velocity()], &outcome);
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
    let batch = Batch::new(&plan());
    let samples = [[0.5, 0.0, 0.0], [0.0; 3], [0.0, 0.1, 0.0]];
    let slopes = batch.map(&samples, |job, sample| {
        job.experiment(drag.perturbed(&[velocity()], sample)?)
            .gradient(&[velocity()], &Reading::X)
    });
    let jacobians = batch.map(&samples, |job, sample| {
        job.experiment(drag.perturbed(&[velocity()], sample)?)
            .jacobian(&[velocity()], &final_position(&drag))
    });
    assert!(slopes[0].is_ok() && slopes[2].is_ok());
    assert!(jacobians[0].is_ok() && jacobians[2].is_ok());
    let errors = [slopes[1].clone().err(), jacobians[1].clone().err()];
    for error in errors {
        let (step, _, number, _) = lost_in_state(error.unwrap());
        assert_eq!((step, number.as_str()), (1, "InitialVelocity(\"ball\") x"));
    }
}

/// Returns a faceted ball of 100 mm that slides on a floor, with its center 70 mm above it. Two more bodies are far away, and the fixed one
/// of them has no friction.
fn sliding(ball_friction: f64, floor_friction: f64) -> World {
    let skin = |friction| Material::elastic(1e5).with_friction(friction);
    let floor = Arc::new(cuboid([1.0, 1.0, 0.2]));
    let at = |x: f64, z: f64| Pose::from_translation(vector![x, 0.0, z]);
    let fixed = |name, friction| Body::fixed(name, Arc::clone(&floor), skin(friction)).unwrap();
    let moving = ball("ball", skin(ball_friction)).with_pose(at(0.0, 0.07));
    World::new(vec![
        moving.with_velocity(vector![0.5, 0.2, 0.0]),
        fixed("floor", floor_friction).with_pose(at(0.0, -0.1)),
        ball("far", skin(0.2)).with_pose(at(9.0, 0.0)),
        fixed("wall", 0.0).with_pose(at(-9.0, 0.0)),
    ])
    .unwrap()
}

fn friction(name: &str) -> Parameter {
    Parameter::friction(name)
}

fn both() -> [Parameter; 2] {
    ["ball", "floor"].map(friction)
}

/// Returns the experiment and the position of the first body after 50 steps of a millisecond.
fn slide(world: &World) -> (Experiment, FinalPosition) {
    let outcome = FinalPosition::of_body(world, "ball").unwrap();
    (
        Experiment::new(world, &Plan::new(1e-3, 50).unwrap()),
        outcome,
    )
}

#[test]
fn two_bodies_without_friction_have_no_derivative_by_the_friction_of_both() {
    let world = sliding(0.0, 0.0);
    let (experiment, outcome) = slide(&world);
    let expected = GradientError::NoFriction {
        bodies: ["ball".into(), "floor".into()],
    };
    let [ball, floor] = both();
    for by in [both().to_vec(), vec![floor, velocity(), ball.clone(), ball]] {
        let jacobian = experiment.jacobian(&by, &outcome);
        let gradient = experiment.gradient(&by, &Reading::X);
        let check = experiment.difference_check(&by, &outcome);
        assert_eq!(jacobian.unwrap_err(), expected);
        assert_eq!(gradient.unwrap_err(), expected);
        assert_eq!(check.unwrap_err(), expected);
    }
    assert_eq!(
        expected.to_string(),
        "bodies \"ball\" and \"floor\" both have zero friction, so the friction of the pair has no derivative with respect to both: use one of them as a parameter, or start above zero"
    );
    // Along (1, 1) the slope differs from that of each parameter alone.
    let x = |change: [f64; 2]| {
        experiment
            .value_perturbed(&both(), &change, &outcome)
            .unwrap()[0]
    };
    let [still, by_first, by_second, both] = [[0.0; 2], [1e-3, 0.0], [0.0, 1e-3], [1e-3; 2]].map(x);
    assert!((by_first - still).abs() <= 0.0 && (by_second - still).abs() <= 0.0);
    assert!(still - both > 1e-6, "{:e}", still - both);
}

#[test]
fn the_derivative_by_one_friction_of_a_pair_that_has_none_is_zero() {
    let world = sliding(0.0, 0.0);
    let (experiment, outcome) = slide(&world);
    for by in both().map(|friction| [friction]) {
        let slopes = experiment.jacobian(&by, &outcome).unwrap();
        assert!(slopes.jacobian.amax() <= 0.0);
        let check = experiment.difference_check(&by, &outcome).unwrap();
        assert!(check.best() <= 0.0);
    }
}

#[test]
fn where_one_of_two_bodies_has_friction_there_are_derivatives_by_both() {
    for world in [sliding(0.3, 0.0), sliding(0.0, 0.3)] {
        let (experiment, outcome) = slide(&world);
        let check = experiment.difference_check(&both(), &outcome).unwrap();
        assert!(check.best() <= RUBBING, "{check}");
        let slopes = experiment.jacobian(&both(), &outcome).unwrap();
        assert!(slopes.jacobian.amax() > 1e-3);
    }
}

#[test]
fn bodies_without_friction_that_cannot_touch_have_derivatives_by_the_friction_of_both() {
    let fixed = sliding(0.2, 0.0);
    let (experiment, outcome) = slide(&fixed);
    let walls = ["floor", "wall"].map(friction);
    assert!(experiment.jacobian(&walls, &outcome).is_ok());
    let ignoring = sliding(0.0, 0.0).with_ignored("floor", "ball").unwrap();
    let (experiment, outcome) = slide(&ignoring);
    let slopes = experiment.jacobian(&both(), &outcome).unwrap();
    assert!(slopes.jacobian.amax() <= 0.0);
}

/// An outcome that does not depend on the trajectory.
struct Constants(&'static [f64]);

impl Outcome for Constants {
    fn of<T: Scalar>(&self, _: &Trajectory<T>) -> Vec<T> {
        self.0.iter().map(|&number| lift(number)).collect()
    }
}

fn assert_not_finite(error: &GradientError, row: usize, value: f64) {
    let text = format!("number {row} of the outcome, counted from 0, is {value}");
    assert!(
        matches!(error, GradientError::OutcomeNotFinite { row: failing_row, .. } if *failing_row == row),
        "{error}"
    );
    assert!(error.to_string().starts_with(&text), "{error}");
}

#[test]
fn an_outcome_that_is_not_finite_is_an_error_that_names_its_number() {
    let world = sliding(0.2, 0.4);
    let (experiment, _) = slide(&world);
    let (by, batch) = ([velocity()], Batch::new(experiment.plan()));
    for (value, numbers) in [
        (f64::NAN, &[1.0, f64::NAN]),
        (f64::INFINITY, &[1.0, f64::INFINITY]),
        (f64::NEG_INFINITY, &[1.0, f64::NEG_INFINITY]),
    ] {
        let (outcome, loss) = (Constants(numbers), Constants(&numbers[1..]));
        let changes = [[0.0; 3]];
        let errors = [
            experiment.value(&outcome).err(),
            experiment.value_perturbed(&by, &changes[0], &outcome).err(),
            experiment.jacobian(&by, &outcome).err(),
            experiment.jacobian(&[], &outcome).err(),
            batch.map(&changes, |job, sample| {
                job.experiment(world.perturbed(&by, sample)?)
                    .value(&outcome)
            })[0]
                .clone()
                .err(),
            batch.map(&changes, |job, sample| {
                job.experiment(world.perturbed(&by, sample)?)
                    .jacobian(&by, &outcome)
            })[0]
                .clone()
                .err(),
        ];
        for error in errors {
            assert_not_finite(&error.unwrap(), 1, value);
        }
        let errors = [
            experiment
                .gradient_with_mode(Mode::Forward, &by, &loss)
                .err(),
            experiment
                .gradient_with_mode(Mode::Reverse, &by, &loss)
                .err(),
            experiment.full_gradient(&loss).err(),
            batch.map(&changes, |job, sample| {
                job.experiment(world.perturbed(&by, sample)?)
                    .gradient(&by, &loss)
            })[0]
                .clone()
                .err(),
        ];
        for error in errors {
            assert_not_finite(&error.unwrap(), 0, value);
        }
    }
}

#[test]
fn a_covector_that_is_not_finite_is_an_error_that_names_its_body() {
    let world = sliding(0.2, 0.4);
    let (experiment, _) = slide(&world);
    for value in [f64::NAN, f64::INFINITY] {
        let shift = vector![value, 0.0, 0.0];
        for (record, step) in [(50, 51), (20, 21), (0, 1)] {
            let vjp = experiment.vjp(&[velocity()]).unwrap();
            let states = vjp.trajectory().states().iter();
            let mut by_states: Vec<_> = states.map(StateGradient::zero).collect();
            by_states[record].bodies[0].shift = shift;
            let result = vjp.pull_back(&by_states);
            let body = "ball".into();
            assert_eq!(result, Err(GradientError::BackwardNotFinite { step, body }));
        }
    }
}

#[test]
fn a_body_without_its_own_friction_has_no_derivative_by_friction() {
    let floor = |friction| Material {
        friction,
        ..Material::elastic(1e5)
    };
    let with = |friction| {
        let mut bodies = sliding(0.3, 0.0).bodies().to_vec();
        let shape = bodies[1].shape().clone();
        let pose = bodies[1].initial_state().pose;
        bodies[1] = Body::fixed("floor", shape, floor(friction))
            .unwrap()
            .with_pose(pose);
        World::new(bodies).unwrap()
    };
    let (borrowed, stated) = (with(None), with(Some(0.3)));
    let (experiment, outcome) = slide(&borrowed);
    let body = "floor".into();
    assert_eq!(
        experiment
            .jacobian(&[friction("floor")], &outcome)
            .unwrap_err(),
        GradientError::NoOwnFriction { body }
    );
    // The pair has the friction of the ball, as if the floor had an equal coefficient that changed with that of the ball.
    let by_ball = experiment.jacobian(&[friction("ball")], &outcome).unwrap();
    let swept = experiment
        .gradient_with_mode(Mode::Reverse, &[friction("ball")], &Reading::X)
        .unwrap();
    let by_both = slide(&stated).0.jacobian(&both(), &outcome).unwrap();
    assert_eq!(by_ball.value, by_both.value);
    let sum = by_both.jacobian.column_sum();
    assert!((by_ball.jacobian.column(0) - &sum).amax() <= RUBBING * sum.amax());
    assert!((swept.1[0] - sum[0]).abs() <= RUBBING * sum[0].abs());
    assert!(
        experiment
            .difference_check(&[friction("ball")], &outcome)
            .unwrap()
            .best()
            <= RUBBING
    );
}
