//! The check of derivatives against the motion: functions with known verdicts, and motions that steps resolve or do not resolve.

use crate::converged::{TIME_STEP, at, ball, cuboid, falling, head_on, plan, rigid_floor, throw};
use crate::support::scenes::Random;
use crate::support::worlds::{dynamic, plan_of, rubbing, turned};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Accuracy, Integrator, Material, Plan, Trajectory, World};
use hydroelastic::gradient::{
    Experiment, FinalPosition, GradientError, Outcome, Parameter, Verdict,
};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift, real_part};
use nalgebra::vector;

/// A function of the final position of a ball that starts at 0 at rest.
#[derive(Clone, Copy)]
enum Reading {
    /// x³ + 2 x.
    Smooth,
    /// The distance from the start.
    Distance,
    /// x plus a wave whose wavelength is about the narrowest width of the check.
    Ripple,
}

impl Outcome for Reading {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let x = trajectory.last().bodies[0].position().x;
        vec![match self {
            Self::Smooth => x * x * x + x * 2.0,
            Self::Distance if x < lift::<T>(0.0) => -x,
            Self::Distance => x,
            Self::Ripple => x + (x * 3e5).sin() * 1e-4,
        }]
    }
}

fn verdict(world: &World, plan: &Plan, outcome: &impl Outcome) -> (Verdict, f64) {
    let by = [Parameter::initial_position("body")];
    let check = Experiment::new(world, plan).derivative_check(&by, outcome);
    let first = check.unwrap().derivatives.swap_remove(0);
    (first.verdict, first.error)
}

#[test]
fn verdicts_of_functions_that_are_known() {
    let skin = Material::elastic(1e5);
    let world = World::new(vec![ball(0.1, skin)]).unwrap();
    for plan in [plan(4), Plan::new(TIME_STEP, 4).unwrap()] {
        let (smooth, error) = verdict(&world, &plan, &Reading::Smooth);
        assert_eq!(smooth, Verdict::Right);
        assert!(error < 1e-9, "{error}");
        // The slope is 1 on one side and −1 on the other side; the slope over both sides is 0.
        let kink = verdict(&world, &plan, &Reading::Distance);
        assert_eq!(kink, (Verdict::Kink, 1.0));
        let (ripple, error) = verdict(&world, &plan, &Reading::Ripple);
        // The slope is 31 instead of about 1.
        assert_eq!(ripple, Verdict::Chaotic);
        assert!((0.9..1.1).contains(&error), "{error}");
    }
}

/// The ball's impact is much shorter than the time step. Undivided steps give wrong derivatives, and the check detects the impact.
#[test]
fn undivided_steps_are_unresolved_from_the_impact_on() {
    let skin = rubbing(1e9, 0.3, 0.4);
    let body = ball(0.05, skin)
        .with_pose(at(0.013, 0.017, 0.25))
        .with_velocity(vector![0.3, 0.1, 0.0]);
    let world = falling(vec![body, rigid_floor(0.4)]);
    let outcome = FinalPosition::of_body(&world, "body").unwrap();
    let by = [Parameter::initial_velocity("body")];
    let resolved = plan(60).recording_every(1);
    let check = |plan: &Plan| {
        let experiment = Experiment::new(&world, plan);
        experiment.derivative_check(&by, &outcome).unwrap()
    };
    let right = check(&resolved);
    println!("{right}");
    assert!(right.is_right(), "{right}");
    let loose = Accuracy::new(1e9, 1e9).unwrap();
    let unresolved = check(&resolved.with_accuracy(loose));
    println!("{unresolved}");
    let vertical = &unresolved.derivatives[2];
    assert_eq!(vertical.verdict, Verdict::Unresolved);
    let (time, body) = vertical.first_mismatch.as_ref().unwrap();
    let damped = check(&resolved.with_integrator(Integrator::ImplicitEuler));
    println!("{damped}");
    assert_eq!(damped.derivatives[2].verdict, Verdict::Unresolved);
    // The ball falls by 0.2 m.
    let impact = (2.0_f64 * 0.2 / 9.81).sqrt();
    assert_eq!(body, "body");
    assert!((0.0..3.0 * TIME_STEP).contains(&(time - impact)), "{time}");
}

/// A sliding block that was put down from 1 mm rattles, and the rattling amplifies small changes. The slopes of its motion over changes of
/// the friction from 3.5e-3 to 1.4e-5 are from −0.07 m to −2.1 m, and at tighter tolerances almost the same. The derivative is −3.7 m.
#[test]
#[ignore = "takes minutes"]
fn a_rattling_slide_is_chaotic() {
    let skin = rubbing(1e6, 0.5, 0.35);
    let body = cuboid([0.1, 0.1, 0.05], skin)
        .with_pose(turned([0.0, 0.0, 0.3], [0.0, 0.0, 0.026]))
        .with_velocity(vector![1.5, 0.2, 0.0]);
    let world = falling(vec![body, rigid_floor(0.5)]);
    let outcome = FinalPosition::of_body(&world, "body").unwrap();
    let by = [Parameter::friction("body")];
    let plan = plan(100).recording_every(1);
    let check = Experiment::new(&world, &plan).derivative_check(&by, &outcome);
    let check = check.unwrap();
    println!("{check}");
    assert_eq!(check.derivatives[0].verdict, Verdict::Chaotic);
}

/// An outcome that is NaN or changes its length, so that some or all of its differences fail.
#[derive(Clone, Copy)]
enum Misread {
    /// Two numbers for x > 0, otherwise one.
    Length,
    /// √(x + 10⁻³) is NaN for x < −10⁻³.
    Root,
    /// √(x + 10⁻⁷) is NaN for x < −10⁻⁷.
    NarrowRoot,
}

impl Outcome for Misread {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let x = trajectory.last().bodies[0].position().x;
        match self {
            Self::Length if x > lift::<T>(0.0) => vec![x, x],
            Self::Length => vec![x],
            Self::Root => vec![(x + 1e-3).sqrt()],
            Self::NarrowRoot => vec![(x + 1e-7).sqrt()],
        }
    }
}

#[test]
fn outcomes_that_differences_cannot_use_are_refused() {
    let world = World::new(vec![ball(0.1, Material::elastic(1e5))]).unwrap();
    let by = [Parameter::initial_position("body")];
    let plan = plan(1);
    let refused = |outcome| {
        let check = Experiment::new(&world, &plan).derivative_check(&by, &outcome);
        check.unwrap_err()
    };
    let length = refused(Misread::Length);
    assert!(matches!(
        length,
        GradientError::OutcomeLength {
            found: 2,
            expected: 1
        }
    ));
    let root = refused(Misread::NarrowRoot);
    assert!(matches!(
        root,
        GradientError::OutcomeNotFinite { row: 0, .. }
    ));
    let check = Experiment::new(&world, &plan).derivative_check(&by, &Misread::Root);
    let along_x = &check.unwrap().derivatives[0];
    assert_eq!(along_x.verdict, Verdict::Right, "{along_x}");
    assert!(along_x.width < 1e-3, "{along_x:?}");
}

/// An outcome without its derivative.
#[derive(Clone, Copy)]
struct Dropped;

impl Outcome for Dropped {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let x = trajectory.last().bodies[0].position().x;
        vec![lift(0.1 + real_part(x))]
    }
}

#[test]
fn a_derivative_that_is_dropped_is_found() {
    let world = World::new(vec![ball(0.1, Material::elastic(1e5))]).unwrap();
    let (dropped, error) = verdict(&world, &plan(1), &Dropped);
    assert_eq!((dropped, error), (Verdict::Chaotic, 1.0));
}

/// The block is at rest on soft ground, and the steps damp its vibration.
#[test]
fn a_vibration_that_steps_damp_is_unresolved() {
    let shape = Shape::new(shapes::distance_cuboid([0.2, 0.2, 0.1]).unwrap());
    let skin = Material::elastic(2e4);
    let body = dynamic("body", shape, skin, 2.0);
    // Depth of the equilibrium.
    let depth = 2.0 * 9.81 * 0.05 / (2e4 * 0.04);
    let world = falling(vec![
        body.with_pose(at(0.0, 0.0, 0.05 - depth)),
        rigid_floor(0.5),
    ]);
    let outcome = FinalPosition::of_body(&world, "body").unwrap();
    let by = [Parameter::initial_velocity("body")];
    for (time_step, steps, expected) in
        [(1e-2, 20, Verdict::Unresolved), (1e-3, 200, Verdict::Right)]
    {
        let plan = plan_of(Integrator::Sdirk3, time_step, steps).recording_every(steps);
        let check = Experiment::new(&world, &plan).derivative_check(&by, &outcome);
        let vertical = &check.unwrap().derivatives[2];
        assert_eq!(vertical.verdict, expected, "{vertical}");
    }
}

/// Checks that a derivative of the final position is called right if and only if its error is small. The last argument is its row, its
/// column and its exact value.
fn check_verdicts(
    label: &str,
    world: &World,
    plan: &Plan,
    by: &[Parameter],
    (row, column, exact): (usize, usize, f64),
) {
    let outcome = FinalPosition::of_body(world, "body").unwrap();
    let experiment = Experiment::new(world, plan);
    let found = experiment.jacobian(by, &outcome).unwrap().jacobian;
    let check = experiment.derivative_check(by, &outcome).unwrap();
    let (error, derivative) = (found[(row, column)] - exact, &check.derivatives[column]);
    println!(
        "{label}: {} instead of {exact}, {derivative}",
        found[(row, column)]
    );
    // Verdicts are relative to the largest entry of the column. Errors near the limit of 3 % may have either verdict.
    let share = error.abs() / found.column(column).amax().max(exact.abs());
    let is_right = derivative.verdict == Verdict::Right;
    assert!(is_right || share > 0.02, "{label}: {derivative}");
    assert!(!is_right || share < 0.06, "{label}: {derivative}");
}

/// Three plans: the first resolves an impact, the second does not, and the third uses implicit Euler steps.
fn plans_of_impacts(steps: usize) -> [Plan; 3] {
    let undivided = Accuracy::new(1e9, 1e9).unwrap();
    let resolved = plan(steps);
    [
        resolved,
        resolved.with_accuracy(undivided),
        resolved.with_integrator(Integrator::ImplicitEuler),
    ]
}

#[test]
#[ignore = "takes minutes"]
fn derivatives_of_throws_are_right_only_if_the_impact_is_resolved() {
    // Slopes at tight tolerances: `python3 docs/guide/printed.py 6` prints them.
    for (rise, exact) in [
        (0.0, -0.0430),
        (0.002, -0.0445),
        (0.004, -0.0459),
        (0.006, -0.0474),
    ] {
        let world = throw(rise);
        let by = [Parameter::initial_velocity("body")];
        for (index, plan) in plans_of_impacts(60).iter().enumerate() {
            let label = format!("throw from {rise}, plan {index}");
            check_verdicts(&label, &world, plan, &by, (2, 2, exact));
        }
    }
}

#[test]
fn derivatives_of_collisions_are_right_only_if_the_impact_is_resolved() {
    let world = head_on(0.37);
    let by = [Parameter::initial_velocity("left")];
    let mut state = world.initial_state();
    // The balls overlap by 5 mm, which is more than the impact compresses them.
    state.bodies[0].pose = at(0.175, 0.0, 0.0);
    let step = 0.4 * world.largest_stable_step(&state).unwrap().unwrap();
    let steps = (1..1_000_000).find(|&steps| f64::from(steps) * step >= 0.4);
    let steps: u32 = steps.unwrap();
    let steps = steps as usize;
    let leapfrog = Plan::new(step, steps).unwrap();
    let plans = plans_of_impacts(80)
        .into_iter()
        .chain([leapfrog.recording_every(steps)]);
    for (index, plan) in plans.enumerate() {
        let label = format!("collision, plan {index}");
        let end = plan.time_step() * plan.steps() as f64;
        // Bodies of equal mass exchange their velocities.
        check_verdicts(&label, &world, &plan, &by, (0, 0, end));
    }
}

/// Checks derivatives of random throws of balls at the default accuracy.
fn check_random_throws(count: usize) {
    let mut random = Random::new(8);
    let by = [
        Parameter::initial_velocity("body"),
        Parameter::modulus("body"),
        Parameter::friction("body"),
    ];
    let mut noisy = 0;
    for scene in 0..count {
        let mut between = |low: f64, high: f64| random.between(low, high);
        let skin = rubbing(
            10_f64.powf(between(6.0, 9.0)),
            between(0.1, 1.0),
            between(0.1, 0.8),
        );
        let position = [between(-0.1, 0.1), between(-0.1, 0.1), between(0.1, 0.4)];
        let velocity = vector![between(-1.0, 1.0), between(-1.0, 1.0), between(-2.0, 1.0)];
        let body = ball(0.05, skin).with_pose(at(position[0], position[1], position[2]));
        let world = falling(vec![body.with_velocity(velocity), rigid_floor(0.4)]);
        let outcome = FinalPosition::of_body(&world, "body").unwrap();
        let check = Experiment::new(&world, &plan(60))
            .derivative_check(&by, &outcome)
            .unwrap();
        for derivative in &check.derivatives {
            let verdict = derivative.verdict;
            noisy += usize::from(verdict == Verdict::Noisy);
            assert!(
                matches!(verdict, Verdict::Right | Verdict::Noisy),
                "scene {scene}: {derivative}"
            );
        }
    }
    println!("{noisy} of {} derivatives are noisy", 5 * count);
    assert!(noisy < 2 * count);
}

#[test]
fn derivatives_of_random_throws_are_right() {
    check_random_throws(1);
}

#[test]
#[ignore = "takes minutes"]
fn derivatives_of_many_random_throws_are_right() {
    check_random_throws(40);
}
