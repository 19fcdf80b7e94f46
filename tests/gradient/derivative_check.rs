//! The check of derivatives against the motion: functions with known verdicts, and motions that steps resolve or do not resolve.

use crate::converged::{TIME_STEP, at, ball, cuboid, falling, plan, rigid_floor};
use crate::support::worlds::{dynamic, icosphere, plan_of, rubbing, turned};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Accuracy, Integrator, Material, Plan, Trajectory, World, WorldError};
use hydroelastic::gradient::{
    Experiment, FinalPosition, GradientError, Outcome, Parameter, Verdict,
};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift, real_part};
use nalgebra::vector;

const WIDTH: f64 = 1e-3;

/// A function of the final position of a ball that starts at 0 at rest.
#[derive(Clone, Copy)]
enum Reading {
    /// x³ + 2 x.
    Smooth,
    /// The distance from the start.
    Distance,
    /// x plus a wave whose wavelength is far below the width of the check.
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
    let check = Experiment::new(world, plan).derivative_check(&by, outcome, WIDTH);
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
        experiment.derivative_check(&by, &outcome, WIDTH).unwrap()
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

/// A sliding block that was put down from 1 mm rattles, and the steps do not resolve the rattling.
#[test]
#[ignore = "takes half a minute"]
fn a_rattling_slide_is_unresolved() {
    let skin = rubbing(1e6, 0.5, 0.35);
    let body = cuboid([0.1, 0.1, 0.05], skin)
        .with_pose(turned([0.0, 0.0, 0.3], [0.0, 0.0, 0.026]))
        .with_velocity(vector![1.5, 0.2, 0.0]);
    let world = falling(vec![body, rigid_floor(0.5)]);
    let outcome = FinalPosition::of_body(&world, "body").unwrap();
    let by = [Parameter::friction("body")];
    let plan = plan(100).recording_every(1);
    let check = Experiment::new(&world, &plan).derivative_check(&by, &outcome, WIDTH);
    let check = check.unwrap();
    println!("{check}");
    assert_eq!(check.derivatives[0].verdict, Verdict::Unresolved);
}

#[test]
fn a_width_that_is_no_width_is_refused() {
    let skin = Material::elastic(1e5);
    let shape = icosphere(0.1, 0);
    let body = dynamic("body", shape, skin, 1.0);
    let world = World::new(vec![body]).unwrap();
    let by = [Parameter::initial_position("body")];
    for width in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let check =
            Experiment::new(&world, &plan(1)).derivative_check(&by, &Reading::Smooth, width);
        let refused = GradientError::World(WorldError::Setting {
            quantity: "width of a derivative check",
            value: width,
            expected: "positive and finite",
        });
        assert_eq!(format!("{:?}", check.unwrap_err()), format!("{refused:?}"));
    }
}

/// An outcome for which no derivative check is possible.
#[derive(Clone, Copy)]
enum Misread {
    /// Two numbers for x > 0, otherwise one.
    Length,
    /// √(x + 10⁻⁴) is NaN for x < −10⁻⁴.
    Root,
}

impl Outcome for Misread {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let x = trajectory.last().bodies[0].position().x;
        match self {
            Self::Length if x > lift::<T>(0.0) => vec![x, x],
            Self::Length => vec![x],
            Self::Root => vec![(x + 1e-4).sqrt()],
        }
    }
}

#[test]
fn outcomes_that_differences_cannot_use_are_refused() {
    let world = World::new(vec![ball(0.1, Material::elastic(1e5))]).unwrap();
    let by = [Parameter::initial_position("body")];
    let plan = plan(1);
    let refused = |outcome| {
        let check = Experiment::new(&world, &plan).derivative_check(&by, &outcome, WIDTH);
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
    let root = refused(Misread::Root);
    assert!(matches!(
        root,
        GradientError::OutcomeNotFinite { row: 0, .. }
    ));
}

#[test]
fn a_width_that_takes_the_mass_away_is_refused() {
    let world = World::new(vec![ball(0.1, Material::elastic(1e5))]).unwrap();
    let by = [Parameter::mass("body")];
    for width in [1.0, 10.0] {
        let check =
            Experiment::new(&world, &plan(1)).derivative_check(&by, &Reading::Smooth, width);
        let refused = check.unwrap_err();
        assert!(matches!(
            refused,
            GradientError::World(WorldError::Mass {
                quantity: "mass",
                ..
            })
        ));
    }
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
fn a_derivative_that_is_dropped_is_found_down_to_the_noise() {
    let world = World::new(vec![ball(0.1, Material::elastic(1e5))]).unwrap();
    let by = [Parameter::initial_position("body")];
    let verdict = |width| {
        let check = Experiment::new(&world, &plan(1)).derivative_check(&by, &Dropped, width);
        check.unwrap().derivatives[0].verdict
    };
    for width in [1e-3, 1e-6, 1e-9] {
        assert_eq!(verdict(width), Verdict::Chaotic, "{width}");
    }
    // Differences over this width are round-off.
    assert_eq!(verdict(1e-15), Verdict::Noisy);
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
        let check = Experiment::new(&world, &plan).derivative_check(&by, &outcome, WIDTH);
        let vertical = &check.unwrap().derivatives[2];
        assert_eq!(vertical.verdict, expected, "{vertical}");
    }
}
