//! Gradients of rollouts of stacked, rolling and spinning bodies with respect to every parameter, against central differences.
//!
//! Boxes that start exactly flush are flush only up to round-off some steps later. Friction has a kink there, |y| of a side's offset y, and
//! its derivative is the mean of both sides, like a central difference. The error of the central difference, however, is of first order in
//! the step (from y|y|). Therefore differences at two steps are extrapolated to zero if one alone is not accurate enough.
//!
//! From the third box on, boxes are not flush across the direction of sliding. The braking floor tilts them one after the other, so they
//! are offset from their neighbors by 1e-11 to 1e-7 m. Differences straddle the kink although the derivative is correct
//! (`tests/contact/flush_motion.rs` tests such states with suitable steps).

use crate::support::worlds::{at, cuboid, falling, fixed, rubbing};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, FinalState, Outcome, Parameter};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{DVector, Vector3, vector};
use std::f64::consts::FRAC_PI_2;

/// Time step (s) of all rollouts.
const TIME_STEP: f64 = 2e-4;

/// Depth (m) by which neighbors in a stack are pressed into each other.
const PRESSED: f64 = 5e-4;

/// Names of stacked boxes, from the lowest box.
const NAMES: [&str; 5] = ["first", "second", "third", "fourth", "fifth"];

/// Materials of the floor and of all other bodies: modulus (Pa), dissipation (s/m), friction.
const FLOOR: [f64; 3] = [2e5, 0.3, 0.5];
const SKIN: [f64; 3] = [1e5, 0.3, 0.4];

/// Agreement with finite differences, relative to the largest entry of a column: without a kink, and at a kink. At a kink, the step sizes
/// are 1e-8 to 1e-6, and the differences contain the rounding errors of the states.
const SMOOTH: f64 = 2e-7;
const AT_KINKS: f64 = 1e-6;

/// Smallest scale of errors: a change of the state (SI units) for a full change of the parameter. Parameters with little effect, for
/// example the friction of a stack at rest (1e-5), drown in the rounding errors of the states.
const LEAST: f64 = 1e-4;

/// Step sizes of finite differences at kinks, and for parameters with little effect. They are relative to the parameter or to 1 SI unit.
const STEPS: [f64; 8] = [3e-3, 1e-6, 3e-7, 1e-7, 5e-8, 3e-8, 2e-8, 1e-8];

fn material([modulus, dissipation, friction]: [f64; 3]) -> Material {
    rubbing(modulus, dissipation, friction)
}

fn dynamic(name: &str, field: PressureField, skin: [f64; 3], mass: f64) -> Body {
    Body::dynamic(name, Shape::new(field), material(skin), Mass::Total(mass)).unwrap()
}

fn floor(stage: Pose, skin: [f64; 3]) -> Body {
    let shape = cuboid([2.0, 2.0, 0.2]);
    let floor = fixed("floor", shape, material(skin));
    floor.with_pose(stage * at(0.0, 0.0, -0.1))
}

fn world(bodies: Vec<Body>) -> World {
    let heavy = falling(bodies);
    heavy.with_slip_tolerance(0.02).unwrap()
}

/// Boxes on top of each other, flush or each offset along x from the box below.
#[derive(Clone, Copy)]
struct Stack<'a> {
    sizes: &'a [[f64; 3]],
    stagger: f64,
    stage: Pose,
}

impl Stack<'_> {
    fn of(sizes: &[[f64; 3]]) -> Stack<'_> {
        Stack {
            sizes,
            stagger: 0.0,
            stage: Pose::identity(),
        }
    }

    /// Returns a world in which all boxes have the same velocity in the frame of the stage.
    fn moving(&self, velocity: [f64; 3]) -> World {
        let mut bodies = vec![floor(self.stage, FLOOR)];
        let mut top = 0.0;
        for (number, (size, name)) in self.sizes.iter().zip(NAMES).enumerate() {
            let [modulus, dissipation, friction] = SKIN;
            let skin = [modulus * (1.0 + 0.3 * number as f64), dissipation, friction];
            let field = shapes::cuboid(*size).unwrap();
            let body = dynamic(name, field, skin, 1.0 - 0.15 * number as f64);
            let along = self.stagger * number as f64;
            let height = top + size[2] / 2.0 - PRESSED;
            let place = self.stage * at(along, 0.0, height);
            let velocity = self.stage.rotation() * Vector3::from(velocity);
            bodies.push(body.with_pose(place).with_velocity(velocity));
            top = height + size[2] / 2.0;
        }
        world(bodies)
    }
}

const BOX: [f64; 3] = [0.2, 0.2, 0.1];

/// Positions, rotations, velocities and angular velocities of all bodies in all recorded states except the first.
struct Everything;

impl Outcome for Everything {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let bodies = trajectory.states()[1..]
            .iter()
            .flat_map(|state| &state.bodies);
        let numbers = bodies.flat_map(|body| {
            let pose = body.pose.translation().iter().chain(body.pose.rotation());
            let twist = body.twist.linear.iter().chain(&body.twist.angular);
            pose.chain(twist).copied().collect::<Vec<_>>()
        });
        numbers.collect()
    }
}

/// A parameter, and the scale of its differences.
struct Column {
    parameter: Parameter,
    scale: f64,
}

/// Returns the parameters of a body.
fn columns_of(body: &Body) -> Vec<Column> {
    let (name, skin) = (body.name(), body.material());
    let column = |parameter, scale| Column { parameter, scale };
    let mut all = vec![
        column(Parameter::modulus(name), skin.modulus.unwrap()),
        column(Parameter::dissipation(name), skin.dissipation),
        column(Parameter::friction(name), skin.friction.unwrap()),
    ];
    if let Some(inertia) = body.inertia() {
        all.extend([
            column(Parameter::mass(name), inertia.mass),
            column(Parameter::initial_position(name), 1.0),
            column(Parameter::initial_orientation(name), 1.0),
            column(Parameter::initial_velocity(name), 1.0),
            column(Parameter::initial_angular_velocity(name), 1.0),
        ]);
    }
    all
}

/// Returns all parameters of a world.
fn all_columns(world: &World) -> Vec<Column> {
    let bodies = world.bodies().iter().flat_map(columns_of);
    let gravity = Column {
        parameter: Parameter::Gravity,
        scale: 1.0,
    };
    bodies.chain([gravity]).collect()
}

/// Returns the smallest error of a derivative with respect to one component, against central differences and differences extrapolated from
/// neighboring steps.
fn error_at_kink(experiment: &Experiment, column: &Column, number: usize) -> f64 {
    let parameters = [column.parameter.clone()];
    let beside = |step: f64| {
        let mut change = vec![0.0; column.parameter.dimension()];
        change[number] = step * column.scale;
        let value = experiment.value_perturbed(&parameters, &change, &Everything);
        DVector::from_vec(value.unwrap())
    };
    let differences =
        STEPS.map(|step| (beside(step) - beside(-step)) / (2.0 * step * column.scale));
    let neighbors = differences.windows(2).zip(STEPS.windows(2));
    let extrapolated = neighbors.map(|(d, h)| (&d[1] * h[0] - &d[0] * h[1]) / (h[0] - h[1]));
    let found = experiment.jacobian(&parameters, &Everything).unwrap();
    let derivative = found.jacobian.column(number);
    let largest = derivative.amax().max(LEAST / column.scale);
    let errors = extrapolated
        .chain(differences.clone())
        .map(|expected| (expected - derivative).amax() / largest);
    errors.fold(f64::INFINITY, f64::min)
}

/// Asserts that all derivatives of a rollout equal finite differences. Returns the number of parameter components for which the step sizes
/// of [`Experiment::difference_check`] are not enough.
fn assert_gradients(what: &str, world: &World, steps: usize) -> usize {
    let plan = Plan::new(TIME_STEP, steps).unwrap();
    let experiment = Experiment::new(world, &plan.recording_every(steps / 2));
    let columns = all_columns(world);
    let parameters: Vec<Parameter> = columns
        .iter()
        .map(|column| column.parameter.clone())
        .collect();
    let check = experiment
        .difference_check(&parameters, &Everything)
        .unwrap();
    let dimensions = columns
        .iter()
        .map(|column| (column, column.parameter.dimension()));
    let numbers = dimensions.flat_map(|(column, count)| (0..count).map(move |n| (column, n)));
    let (mut smooth, mut at_kinks, mut kinks) = (0.0_f64, 0.0_f64, 0);
    for ((column, number), (name, best)) in
        numbers.zip(check.numbers.iter().zip(check.best_by_parameter()))
    {
        if best <= SMOOTH {
            smooth = smooth.max(best);
            continue;
        }
        let error = best.min(error_at_kink(&experiment, column, number));
        assert!(error <= AT_KINKS, "{what}, {name}: {error:e}");
        at_kinks = at_kinks.max(error);
        kinks += 1;
    }
    let count = check.numbers.len();
    println!("{what}: by {count} numbers, worst {smooth:.1e}; at kinks by {kinks}, {at_kinks:.1e}");
    kinks
}

/// Numbers of steps of long rollouts, and of the longest rollouts on a slope.
const LONG: usize = 250;
const SLOPING: usize = 100;

const SLIDING: [f64; 3] = [0.5, 0.0, 0.0];
const DIAGONAL: [f64; 3] = [0.5, 0.5, 0.0];

/// The boxes stop after about 30 steps.
const BRAKING: [f64; 3] = [0.02, 0.0, 0.0];

fn slope() -> Pose {
    Pose::from_rotation_vector(&vector![0.0, 0.3, 0.0], vector![0.1, 0.2, 0.3])
}

/// Checks scenes of two flush boxes for `steps` steps. Braking boxes are flush only along their direction of motion. Across it, a change of
/// 1e-7 m moves them past the kink, and shorter differences have rounding errors of 1e-6.
fn assert_gradients_of_two(steps: usize) {
    let two = Stack::of(&[BOX; 2]);
    assert_gradients("sliding", &two.moving(SLIDING), steps);
    assert_gradients("sliding along the diagonal", &two.moving(DIAGONAL), steps);
    assert_gradients("at rest", &two.moving([0.0; 3]), steps);
    let staggered = Stack {
        stagger: 0.001,
        ..two
    };
    assert_gradients("braking", &staggered.moving(BRAKING), steps);
    let sloping = Stack {
        stage: slope(),
        ..two
    };
    // A change of gravity by 1e-6 moves the boxes past a kink at later times.
    let steps = steps.min(SLOPING);
    assert_gradients("on a slope", &sloping.moving([0.1, 0.0, 0.0]), steps);
}

/// Checks stacks of three to five boxes for `steps` steps. Sliding boxes are flush only along their direction of motion.
fn assert_gradients_of_stacks(steps: usize) {
    for count in 3..=5 {
        let sizes = [BOX; 5];
        let staggered = Stack {
            stagger: 0.001,
            ..Stack::of(&sizes[..count])
        };
        assert_gradients(
            &format!("{count} sliding"),
            &staggered.moving(SLIDING),
            steps,
        );
    }
    assert_gradients("3 at rest", &Stack::of(&[BOX; 3]).moving([0.0; 3]), steps);
}

/// Checks boxes of unequal size. One of them is flush with the lower box along y and has a kink.
fn assert_gradients_of_unequal(steps: usize) {
    for (upper, has_kinks) in [
        ([0.15, 0.18, 0.1], false),
        ([0.15, 0.2, 0.1], true),
        ([0.3, 0.25, 0.05], false),
    ] {
        let world = Stack::of(&[BOX, upper]).moving(SLIDING);
        let kinks = assert_gradients(&format!("{upper:?} above"), &world, steps);
        assert_eq!(kinks > 0, has_kinks);
    }
}

#[test]
fn two_flush_boxes_have_the_gradients_of_differences_by_every_parameter() {
    assert_gradients_of_two(50);
}

#[test]
fn stacks_of_up_to_five_boxes_have_the_gradients_of_differences() {
    assert_gradients_of_stacks(20);
}

#[test]
fn unequal_boxes_have_the_gradients_of_differences() {
    assert_gradients_of_unequal(50);
}

/// Returns a world with the body on a floor, slightly pressed in.
fn on_floor(body: Body) -> World {
    world(vec![floor(Pose::identity(), FLOOR), body])
}

fn ball() -> World {
    let ball = dynamic("ball", shapes::icosphere(0.1, 2).unwrap(), SKIN, 1.0);
    on_floor(
        ball.with_pose(at(0.2, 0.1, 0.098))
            .with_velocity(SLIDING.into())
            .with_angular_velocity(vector![0.0, 5.0, 0.0]),
    )
}

/// Returns a world with a cylinder whose axis is exactly along y.
fn cylinder() -> World {
    let cylinder = dynamic(
        "cylinder",
        shapes::cylinder(0.1, 0.3, 16).unwrap(),
        SKIN,
        1.0,
    );
    let lying =
        Pose::from_rotation_vector(&vector![-FRAC_PI_2, 0.0, 0.0], vector![0.2, 0.1, 0.098]);
    let turned = Pose::from_rotation_vector(&vector![0.0, 0.0, 0.1], Vector3::zeros());
    on_floor(
        cylinder
            .with_pose(lying * turned)
            .with_velocity(SLIDING.into())
            .with_angular_velocity(vector![0.0, 5.0, 0.0]),
    )
}

/// Returns a brick that is rotated, away from the floor's middle, and spins about its own middle.
fn brick(field: PressureField) -> World {
    let place = vector![0.3, 0.2, 0.02 - PRESSED];
    let turned = Pose::from_rotation_vector(&vector![0.0, 0.0, 0.3], place);
    let brick = dynamic("brick", field, SKIN, 1.0).with_pose(turned);
    on_floor(brick.with_angular_velocity(vector![0.0, 0.0, 10.0]))
}

fn assert_gradients_of_round_and_spinning(steps: usize) {
    let size = [0.2, 0.2, 0.04];
    let (whole, layers) = (shapes::cuboid(size), shapes::distance_cuboid(size));
    let worlds = [
        ("ball", ball()),
        ("cylinder", cylinder()),
        ("brick", brick(whole.unwrap())),
        ("brick of layers", brick(layers.unwrap())),
    ];
    for (what, world) in worlds {
        assert_eq!(assert_gradients(what, &world, steps), 0);
    }
}

#[test]
fn rolling_and_spinning_bodies_have_the_gradients_of_differences() {
    assert_gradients_of_round_and_spinning(80);
}

#[test]
#[ignore = "minutes: cargo test --release --test gradient stacks:: -- --ignored --nocapture"]
fn longer_rollouts_have_the_gradients_of_differences() {
    assert_gradients_of_two(LONG);
    assert_gradients_of_stacks(LONG / 2);
    assert_gradients_of_unequal(LONG);
    assert_gradients_of_round_and_spinning(2 * LONG);
}

/// Slides two flush boxes for 0.1 s. Returns the derivatives of the upper box's velocity along y with respect to that of the lower box.
fn sideways(dissipation: f64, friction: f64) -> [f64; 2] {
    let skin = |modulus| [modulus, dissipation, friction];
    let sliding = |name, modulus, mass, height| {
        let body = dynamic(name, shapes::cuboid(BOX).unwrap(), skin(modulus), mass);
        body.with_pose(at(0.0, 0.0, height))
            .with_velocity(SLIDING.into())
    };
    let world = world(vec![
        sliding("first", 1e5, 1.0, 0.0495),
        floor(Pose::identity(), skin(2e5)),
        sliding("second", 1.3e5, 0.5, 0.149),
    ]);
    let plan = Plan::new(TIME_STEP, 500).unwrap().recording_every(500);
    let experiment = Experiment::new(&world, &plan);
    let outcome = FinalState::of_body(&world, "second").unwrap();
    let parameters = [Parameter::initial_velocity("first")];
    // The rows are position, rotation, velocity.
    let row = 13;
    let derivative = experiment.jacobian(&parameters, &outcome).unwrap().jacobian[(row, 1)];
    let beside = |step| {
        experiment
            .value_perturbed(&parameters, &[0.0, step, 0.0], &outcome)
            .unwrap()[row]
    };
    let difference = |step: f64| (beside(step) - beside(-step)) / (2.0 * step);
    let [coarse, fine] = KINK_STEPS.map(difference);
    let limit = (fine * KINK_STEPS[0] - coarse * KINK_STEPS[1]) / (KINK_STEPS[0] - KINK_STEPS[1]);
    let error = (derivative - limit).abs() / derivative.abs();
    println!("d {dissipation}, mu {friction}: {derivative:.8}, off by {error:.1e}");
    [derivative, error]
}

/// Steps (m/s) for the extrapolation of differences.
const KINK_STEPS: [f64; 2] = [1e-6, 1e-7];

/// Half a unit of the last digit.
const ROUNDED: f64 = 5e-6;

#[test]
fn a_flush_box_follows_the_one_below_it_sideways_as_differences_do() {
    for (dissipation, friction, expected) in [
        (0.3, 0.4, 0.298_476),
        (0.0, 0.4, 0.277_869),
        (0.3, 0.0, -1.150_83),
    ] {
        let [derivative, error] = sideways(dissipation, friction);
        assert!(error <= AT_KINKS, "{error:e}");
        assert!((derivative - expected).abs() <= ROUNDED, "{derivative}");
    }
}
