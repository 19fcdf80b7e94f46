//! Clearances and times of first contact as outcomes.

use super::support::worlds::{GRAVITY, cuboid, dynamic, falling, fixed, icosphere, rigid_floor};
use hydroelastic::dynamics::{Body, Material, Plan, World, WorldError};
use hydroelastic::gradient::{
    Experiment, FirstContact, GradientError, Mode, Outcome, Parameter, RolloutClearance,
};
use hydroelastic::spatial::Pose;
use nalgebra::{DVector, Vector3, vector};

/// Rounding error of a rollout.
const EXACT: f64 = 1e-11;

/// Error of central differences of a rollout.
const DIFFERENCES: f64 = 1e-7;

/// Difference of forward and reverse mode: rounding errors of a rollout.
const MODES: f64 = 1e-10;

const SKIN: f64 = 1e5;

fn skin() -> Material {
    Material::elastic(SKIN)
        .with_dissipation(0.2)
        .with_friction(0.3)
}

/// Returns a tilted cube that is thrown at a wall, spins and falls.
fn thrown(velocity: Vector3<f64>) -> World {
    let cube = dynamic("cube", cuboid([0.1, 0.12, 0.14]), skin(), 1.0)
        .with_pose(Pose::from_rotation_vector(
            &vector![0.4, 0.3, 0.2],
            Vector3::zeros(),
        ))
        .with_velocity(velocity)
        .with_angular_velocity(vector![1.0, 2.0, -1.5]);
    let wall = fixed("wall", cuboid([0.2, 3.0, 3.0]), skin());
    let wall = wall.with_pose(Pose::from_rotation_vector(
        &vector![0.1, 0.2, 0.3],
        vector![0.6, 0.0, 0.0],
    ));
    falling(vec![cube, wall])
}

fn parameters() -> Vec<Parameter> {
    vec![
        Parameter::initial_position("cube"),
        Parameter::initial_orientation("cube"),
        Parameter::initial_velocity("cube"),
        Parameter::initial_angular_velocity("cube"),
    ]
}

fn assert_near(actual: &DVector<f64>, expected: &DVector<f64>, tolerance: f64) {
    let error = (actual - expected).amax();
    assert!(
        error <= tolerance * expected.amax(),
        "{error:e}: {actual} {expected}"
    );
}

/// Asserts that gradients in both modes agree with each other and with differences.
fn assert_gradient(experiment: &Experiment, loss: &impl Outcome) {
    let by = parameters();
    let of = |mode| experiment.gradient_with_mode(mode, &by, loss).unwrap();
    let (forward, reverse) = (of(Mode::Forward), of(Mode::Reverse));
    assert_near(&reverse.1, &forward.1, MODES);
    let check = experiment.difference_check(&by, loss).unwrap();
    println!("{check}");
    for error in check.best_by_parameter() {
        assert!(error <= DIFFERENCES, "{error:e}");
    }
}

#[test]
fn gradients_of_the_final_clearance_agree_with_differences_before_and_after_contact() {
    for (steps, is_touching) in [(60, false), (215, true)] {
        let world = thrown(vector![2.0, 0.1, 1.0]);
        let experiment = Experiment::new(&world, &Plan::new(1e-3, steps).unwrap());
        let clearance = RolloutClearance::between(&world, "wall", "cube").unwrap();
        let value = experiment.value(&clearance).unwrap()[0];
        assert_eq!(value < 0.0, is_touching, "{value}");
        assert_gradient(&experiment, &clearance);
    }
}

#[test]
fn gradients_of_the_least_clearance_agree_with_differences_if_the_bodies_pass_each_other() {
    // The cube falls before it reaches the wall.
    let world = thrown(vector![0.5, 0.1, 2.0]);
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 400).unwrap());
    let last = RolloutClearance::between(&world, "cube", "wall").unwrap();
    let least = last.clone().least();
    let [least_value, last_value] = [
        experiment.value(&least).unwrap()[0],
        experiment.value(&last).unwrap()[0],
    ];
    println!("least {least_value}, last {last_value}");
    assert!(0.0 < least_value && least_value <= last_value);
    assert_gradient(&experiment, &least);
}

#[test]
fn the_first_contact_of_a_falling_ball_is_at_the_time_in_closed_form() {
    let (height, speed) = (1.3, 0.7);
    let ball = dynamic("ball", icosphere(0.1, 2), skin(), 1.0)
        .with_pose(Pose::from_translation(vector![0.0, 0.0, height]))
        .with_velocity(vector![0.4, 0.0, speed]);
    // The ball falls through the floor, so that its path is a parabola.
    let world = falling(vec![ball, rigid_floor(0.0)])
        .with_ignored("ball", "floor")
        .unwrap();
    let by = [
        Parameter::initial_position("ball"),
        Parameter::initial_velocity("ball"),
    ];
    for every in [1, 10, 400] {
        let plan = Plan::new(2e-3, 800).unwrap().recording_every(every);
        let first = Experiment::new(&world, &plan).first_contact(&by, ["floor", "ball"]);
        let FirstContact::Touching { time, gradient } = first.unwrap() else {
            panic!("the ball reaches the floor");
        };
        let drop = height - 0.1;
        let expected = (speed + (speed * speed + 2.0 * GRAVITY * drop).sqrt()) / GRAVITY;
        assert!((time - expected).abs() <= EXACT, "{time} {expected}");
        let rate = GRAVITY * expected - speed;
        let slopes = [0.0, 0.0, 1.0 / rate, 0.0, 0.0, expected / rate];
        assert_near(&gradient, &DVector::from_row_slice(&slopes), EXACT);
    }
}

#[test]
fn derivatives_of_the_time_of_first_contact_agree_with_differences() {
    let world = thrown(vector![2.0, 0.1, 1.0]);
    for every in [1, 7] {
        let plan = Plan::new(1e-3, 280).unwrap().recording_every(every);
        let experiment = Experiment::new(&world, &plan);
        let time_of = |experiment: &Experiment| match experiment
            .first_contact(&parameters(), ["cube", "wall"])
            .unwrap()
        {
            FirstContact::Touching { time, gradient } => (time, gradient),
            apart @ FirstContact::Apart { .. } => panic!("{apart:?}"),
        };
        let (time, gradient) = time_of(&experiment);
        println!("first contact at {time} s");
        for number in 0..12 {
            let side = |step: f64| {
                let mut change = [0.0; 12];
                change[number] = step;
                time_of(&experiment.perturbed(&parameters(), &change).unwrap()).0
            };
            let errors = [1e-5, 1e-6].map(|step| {
                let difference = (side(step) - side(-step)) / (2.0 * step);
                (gradient[number] - difference).abs()
            });
            let least = errors[0].min(errors[1]);
            println!("{number}: {} off by {least:e}", gradient[number]);
            assert!(least <= DIFFERENCES * gradient.amax());
        }
    }
}

#[test]
fn a_rollout_without_contact_reports_the_least_clearance() {
    let world = thrown(vector![0.5, 0.1, 2.0]);
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 100).unwrap());
    let least = RolloutClearance::between(&world, "cube", "wall")
        .unwrap()
        .least();
    let expected = experiment.gradient(&parameters(), &least).unwrap();
    match experiment
        .first_contact(&parameters(), ["cube", "wall"])
        .unwrap()
    {
        FirstContact::Apart {
            least_clearance,
            time,
            gradient,
        } => {
            assert!((0.0..=0.1).contains(&time));
            assert!((least_clearance - expected.0).abs() <= EXACT);
            assert_near(&gradient, &expected.1, EXACT);
        }
        touching @ FirstContact::Touching { .. } => panic!("{touching:?}"),
    }
}

#[test]
fn bodies_without_a_clearance_are_refused() {
    let ghost = Body::fixed(
        "ghost",
        hydroelastic::dynamics::BodyShape::None,
        Material::rigid(),
    );
    let cube = dynamic("cube", cuboid([0.1; 3]), skin(), 1.0);
    let world = falling(vec![cube, rigid_floor(0.0), ghost.unwrap()]);
    let refused =
        |names: [&str; 2]| RolloutClearance::between(&world, names[0], names[1]).unwrap_err();
    assert!(matches!(refused(["cube", "cube"]), WorldError::SameBody(_)));
    assert!(matches!(
        refused(["cube", "cub"]),
        WorldError::UnknownBody { .. }
    ));
    assert!(matches!(
        refused(["cube", "ghost"]),
        WorldError::NoContact(_)
    ));
    assert!(matches!(
        refused(["floor", "ghost"]),
        WorldError::NoContact(_)
    ));
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 1).unwrap());
    let error = experiment
        .first_contact(&[], ["floor", "ghost"])
        .unwrap_err();
    assert!(matches!(
        error,
        GradientError::World(WorldError::NoContact(_))
    ));
}
