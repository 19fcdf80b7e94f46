//! Reverse-mode gradients against forward mode, with respect to every kind of parameter, through the steps of every integrator.

use crate::support::worlds::{
    EXPLICIT, IMPLICIT, cuboid, falling, fixed, icosphere, plan_of, sliding_at, turned,
};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Batch, Body, BodyState, BodyStateGradient, Control, Drag, Force, ForceContext,
    JointStateGradient, Mass, Material, Plan, Spring, State, StateGradient, Thruster, Trajectory,
    World, WrenchAccumulator,
};
use hydroelastic::gradient::{
    Experiment, GradientError, Integrand, Mode, Outcome, Parameter, TimeIntegral,
};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{DVector, Matrix3, Vector3, vector};

/// Rounding error of hundreds of substeps, relative to the largest entry of a parameter's gradient. In forward mode, a stage multiplies by
/// the inverse of its matrix; in reverse mode, it solves with the transposed factors. The largest observed difference is 1.1e-11, for a
/// ball that hits a floor.
pub const SAME: f64 = 2e-11;

/// A weighted sum of all components of some states, each with a different factor.
#[derive(Clone, Copy)]
pub struct Mixed {
    /// Interval of the recorded states in the sum, counted from the last state.
    pub every: usize,
}

impl Outcome for Mixed {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let mut sum = lift::<T>(0.0);
        let states = trajectory.states().iter().rev().step_by(self.every);
        for (index, state) in states.enumerate() {
            for (factor, number) in (1..).zip(numbers(state)) {
                let factor = (f64::from(factor) * 0.7 + index as f64).sin();
                sum += number * number * (0.5 * factor) + number * factor;
            }
        }
        vec![sum]
    }
}

fn numbers<T: Scalar>(state: &State<T>) -> Vec<T> {
    let of_body = |body: &BodyState<T>| {
        let pose = body.pose.translation().iter().chain(body.pose.rotation());
        let twist = body.twist.linear.iter().chain(&body.twist.angular);
        pose.chain(twist).copied().collect::<Vec<_>>()
    };
    state.bodies.iter().flat_map(of_body).collect()
}

/// Compares both modes parameter by parameter, and returns the reverse-mode gradient.
pub fn compare<F: Force>(
    world: &World<f64, F>,
    plan: &Plan,
    parameters: &[Parameter],
    outcome: &impl Outcome,
) -> DVector<f64> {
    let experiment = Experiment::new(world, plan);
    let [(value, forward), (same, reverse)] = [Mode::Forward, Mode::Reverse].map(|mode| {
        experiment
            .gradient_with_mode(mode, parameters, outcome)
            .unwrap()
    });
    assert!((value - same).abs() <= SAME * value.abs(), "{value} {same}");
    let mut row = 0;
    for parameter in parameters {
        let count = parameter.dimension();
        let [expected, actual] =
            [&forward, &reverse].map(|gradient| gradient.rows(row, count).into_owned());
        let error = (&actual - &expected).amax() / expected.amax();
        assert!(expected.amax() > 0.0, "{parameter} has no effect");
        assert!(
            error <= SAME,
            "{parameter}: {error:e}, {actual} for {expected}"
        );
        row += count;
    }
    reverse
}

/// Returns a body with different principal moments, whose origin is not its center of mass.
fn potato() -> Shape {
    let round = shapes::ellipsoid([0.1, 0.12, 0.08], 2).unwrap();
    let moved = round
        .mesh()
        .vertices()
        .iter()
        .map(|x| x + vector![0.02, -0.01, 0.03]);
    let mesh = TetMesh::new(moved.collect(), round.mesh().tets().to_vec()).unwrap();
    Shape::new(PressureField::new(mesh, round.extents().to_vec()).unwrap())
}

pub fn skin(modulus: f64, [dissipation, friction]: [f64; 2]) -> Material {
    Material {
        modulus: Some(modulus),
        dissipation,
        friction: Some(friction),
    }
}

/// Returns two potatoes that touch each other, a block, a floor and a plate that moves.
fn bodies(law: [f64; 2]) -> Vec<Body> {
    let block = cuboid([0.6, 0.6, 0.2]);
    let potato = std::sync::Arc::new(potato());
    let dynamic = |name, modulus| {
        let shape = std::sync::Arc::clone(&potato);
        Body::dynamic(name, shape, skin(modulus, law), Mass::Density(300.0)).unwrap()
    };
    let path = |time: f64| BodyState {
        pose: Pose::from_translation(vector![0.0, 0.28 - 0.4 * time, 0.1]),
        twist: sliding_at(vector![0.0, -0.4, 0.0]),
    };
    vec![
        dynamic("a", 1e5)
            .with_pose(turned([0.3, 0.2, 0.5], [0.02, 0.01, 0.22]))
            .with_velocity(vector![0.3, 0.4, -1.0])
            .with_angular_velocity(vector![3.0, -2.0, 1.0]),
        dynamic("b", 2e5)
            .with_pose(turned([-0.3, 0.8, 0.1], [0.13, 0.12, 0.37]))
            .with_velocity(vector![-0.2, -0.5, -1.5])
            .with_angular_velocity(vector![-1.0, 2.0, 1.5]),
        fixed("block", block, skin(4e5, law))
            .with_pose(turned([0.05, 0.02, 0.3], [0.0, 0.0, -0.02])),
        Body::kinematic(
            "plate",
            cuboid([0.5, 0.1, 0.5]),
            skin(3e5, law),
            std::sync::Arc::new(path),
        )
        .unwrap(),
        fixed("floor", HalfSpace::layer(0.05).unwrap(), skin(2e5, law))
            .with_pose(Pose::from_translation(vector![0.0, 0.0, 0.1])),
    ]
}

fn by_bodies(rubs: bool) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for name in ["a", "b"] {
        parameters.extend([
            Parameter::initial_position(name),
            Parameter::initial_orientation(name),
            Parameter::initial_velocity(name),
            Parameter::initial_angular_velocity(name),
            Parameter::mass(name),
            Parameter::radius_of_gyration(name),
        ]);
    }
    for name in ["a", "b", "block", "plate", "floor"] {
        parameters.push(Parameter::modulus(name));
        if rubs {
            parameters.push(Parameter::dissipation(name));
            parameters.push(Parameter::friction(name));
        }
    }
    for name in ["block", "floor"] {
        parameters.push(Parameter::initial_position(name));
        parameters.push(Parameter::initial_orientation(name));
    }
    parameters.push(Parameter::Gravity);
    parameters
}

fn world(law: [f64; 2]) -> World {
    let world = World::new(bodies(law)).unwrap();
    let world = world.with_gravity(vector![0.3, -0.2, -9.81]).unwrap();
    world.with_slip_tolerance(0.05).unwrap()
}

fn plan() -> Plan {
    Plan::new(5e-4, 300).unwrap()
}

pub const END: Mixed = Mixed { every: 1000 };

/// Returns plans of all integrators, whose implicit steps have this length (s) and number.
fn plans(implicit: (f64, usize)) -> impl Iterator<Item = Plan> {
    let explicit = EXPLICIT.map(|integrator| plan_of(integrator, 5e-4, 300));
    let implicit = IMPLICIT.map(|integrator| plan_of(integrator, implicit.0, implicit.1));
    let plans = explicit.into_iter().chain(implicit);
    plans.map(|plan| plan.recording_every(plan.steps()))
}

#[test]
fn elastic_and_rubbing() {
    for plan in plans((2.5e-3, 60)) {
        compare(&world([0.0; 2]), &plan, &by_bodies(false), &END);
        compare(&world([0.5, 0.4]), &plan, &by_bodies(true), &END);
    }
}

#[test]
fn outcomes_that_look_at_many_states() {
    for plan in plans((2.5e-3, 60)) {
        let (plan, outcome) = (plan.recording_every(7), Mixed { every: 3 });
        compare(&world([0.5, 0.4]), &plan, &by_bodies(true), &outcome);
    }
}

/// Sum of squared velocities and heights.
struct Haste;

impl Integrand for Haste {
    fn at<T: Scalar>(&self, state: &State<T>) -> T {
        let [a, b] = [0, 1].map(|body| &state.bodies[body]);
        a.velocity().dot(b.velocity()) + a.position().z * 3.0 + b.twist.angular.x
    }
}

#[test]
fn integrals_along_the_way() {
    let plan = plan().recording_every(7);
    let world = world([0.5, 0.4]);
    compare(&world, &plan, &by_bodies(true), &TimeIntegral(Haste));
    // With gravity alone: ∫ (v₀ + g t)² dt, by a rule that is exact for linear functions.
    let free = |spin: f64| {
        let ball = icosphere(0.1, 0);
        let body = |name| {
            let shape = std::sync::Arc::new(ball.clone());
            Body::dynamic(name, shape, Material::elastic(1e5), Mass::Total(1.0)).unwrap()
        };
        let far = Pose::from_translation(vector![9.0, 0.0, 0.0]);
        let spinning = body("b")
            .with_pose(far)
            .with_angular_velocity(vector![spin, 0.0, 0.0]);
        World::new(vec![
            body("a").with_velocity(vector![0.0, 0.0, 1.0]),
            spinning,
        ])
        .unwrap()
    };
    let experiment = Experiment::new(free(0.5), &Plan::new(1e-2, 100).unwrap());
    let by_spin = [Parameter::initial_angular_velocity("b")];
    let (value, by_spin) = experiment
        .gradient_with_mode(Mode::Reverse, &by_spin, &TimeIntegral(Haste))
        .unwrap();
    // ∫ 3 t dt + 0.5 over a second.
    assert!((value - 2.0).abs() <= 1e-12, "{value}");
    assert!((by_spin[0] - 1.0).abs() <= 1e-12, "{by_spin}");
}

/// A force that depends on contact wrenches, on gravity, and on the masses and materials of the bodies.
pub struct Odd;

impl Force for Odd {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let mass = now.bodies[1].inertia().unwrap().mass;
        let touch = now.contact[1].force * lift::<T>(0.1) + now.contact[1].torque;
        let material = now.bodies[2].material();
        let friction = material.friction.unwrap() * 0.3 + material.dissipation;
        let modulus = material.modulus.unwrap() * 1e-6;
        let weight = now.gravity * (mass * 0.1 + friction + modulus);
        wrenches.apply_force_at_com(0, &(touch + weight));
        let spin = now.states[0].twist.angular;
        wrenches.apply_force_at_point(1, &spin, now.states[2].position());
    }
}

/// Returns a world with a force of each kind and a control, and all their parameters.
pub fn with_forces_and_controls() -> (World<f64, impl Force>, Vec<Parameter>) {
    let spring = Spring {
        bodies: ["a".into(), "b".into()],
        points: [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0]],
        rest_length: 0.1.into(),
        stiffness: 30.0.into(),
        damping: 0.3.into(),
    };
    let drag = Drag {
        body: "b".into(),
        linear: 0.3.into(),
        angular: 1e-3.into(),
    };
    let thruster = Thruster {
        body: "a".into(),
        point: [0.0, 0.0, 0.1],
        force: [0.4, 0.2, 0.5],
    };
    let push = Wrench {
        torque: vector![1e-3, 2e-3, -1e-3],
        force: vector![0.5, -0.3, 0.2],
    };
    let control = Control::new("b", 0.03, vec![push; 5]).unwrap();
    let world = world([0.5, 0.4]).with_control(control).unwrap();
    let world = world.with_forces((spring, drag, thruster, Odd)).unwrap();
    let mut parameters = by_bodies(true);
    parameters.extend((0..5).map(|interval| Parameter::control("b", interval)));
    (world, parameters)
}

#[test]
fn forces_and_controls() {
    let (world, parameters) = with_forces_and_controls();
    for plan in plans((2.5e-3, 60)) {
        compare(&world, &plan, &parameters, &END);
    }
}

/// Returns a ball that rolls, and a symmetric top.
fn round_bodies() -> [(World, Vec<Parameter>); 2] {
    let top = Shape::new(shapes::cylinder(0.1, 0.1, 12).unwrap());
    let ball = icosphere(0.1, 2);
    [top, ball].map(|shape| {
        let body = Body::dynamic("body", shape, skin(1e5, [0.3, 0.5]), Mass::Total(1.0)).unwrap();
        let floor = fixed(
            "floor",
            HalfSpace::rigid(),
            Material::rigid().with_friction(0.5),
        );
        let start = turned([0.2, 0.1, 0.4], [0.0, 0.0, 0.12]);
        let world = falling(vec![
            body.with_pose(start)
                .with_velocity(vector![1.0, 0.2, 0.0])
                .with_angular_velocity(vector![0.0, 8.0, 3.0]),
            floor,
        ]);
        let world = world.with_slip_tolerance(0.05).unwrap();
        let parameters = vec![
            Parameter::initial_position("body"),
            Parameter::initial_orientation("body"),
            Parameter::initial_velocity("body"),
            Parameter::initial_angular_velocity("body"),
            Parameter::modulus("body"),
            Parameter::mass("body"),
            Parameter::dissipation("body"),
            Parameter::friction("floor"),
            Parameter::Gravity,
        ];
        (world, parameters)
    })
}

/// Returns the derivatives of [`Mixed`] with respect to the states, in closed form.
fn by_states(mixed: Mixed, trajectory: &Trajectory) -> Vec<StateGradient> {
    let states = trajectory.states();
    let mut covectors: Vec<_> = states.iter().map(StateGradient::zero).collect();
    let looked_at = covectors.iter_mut().zip(states).rev().step_by(mixed.every);
    for (index, (covectors_of_state, state)) in looked_at.enumerate() {
        let by = |(number, value): (usize, f64)| {
            (value + 1.0) * ((number + 1) as f64 * 0.7 + index as f64).sin()
        };
        let by_numbers: Vec<f64> = numbers(state).into_iter().enumerate().map(by).collect();
        let bodies = covectors_of_state.bodies.iter_mut().zip(&state.bodies);
        for ((covector, body), by) in bodies.zip(by_numbers.chunks(18)) {
            let by_twist = Twist {
                linear: Vector3::from_column_slice(&by[12..15]),
                angular: Vector3::from_column_slice(&by[15..18]),
            };
            *covector = BodyStateGradient::from_entries(
                body.pose.rotation(),
                &Matrix3::from_column_slice(&by[3..12]),
                Vector3::from_column_slice(&by[..3]),
                &by_twist,
            );
        }
    }
    covectors
}

#[test]
fn derivatives_by_states_that_are_given_are_those_of_the_outcome() {
    let world = world([0.5, 0.4]);
    let (parameters, mixed) = (by_bodies(true), Mixed { every: 3 });
    for every in [7, 300] {
        let plan = plan().recording_every(every);
        let experiment = Experiment::new(&world, &plan);
        let (_, expected) = experiment.gradient(&parameters, &mixed).unwrap();
        let vjp = experiment.vjp(&parameters).unwrap();
        let cotangents = by_states(mixed, vjp.trajectory());
        let actual = vjp.clone().pull_back(&cotangents).unwrap();
        assert!((&actual - &expected).amax() <= SAME * expected.amax());
        // A second product of the same rollout has the same bits.
        assert_eq!(vjp.pull_back(&cotangents), Ok(actual));
    }
}

#[test]
fn worlds_of_a_batch_have_the_bits_of_each() {
    let worlds = [0.1, 0.4].map(|friction| world([0.5, friction]));
    let (plan, parameters) = (plan().recording_every(100), by_bodies(true));
    // The second world has another stride.
    let mixed = |index: usize| Mixed { every: index + 1 };
    let items: Vec<_> = worlds.iter().enumerate().collect();
    let gradients = Batch::new(&plan).map(&items, |job, &(index, world)| {
        let vjp = job.experiment(world).vjp(&parameters)?;
        let cotangents = by_states(mixed(index), vjp.trajectory());
        vjp.pull_back(&cotangents)
    });
    assert_eq!(gradients.len(), 2);
    for (index, (world, actual)) in worlds.iter().zip(gradients).enumerate() {
        let experiment = Experiment::new(world, &plan);
        let vjp = experiment.vjp(&parameters).unwrap();
        let cotangents = by_states(mixed(index), vjp.trajectory());
        let expected = vjp.pull_back(&cotangents);
        assert_eq!(actual.unwrap(), expected.unwrap());
    }
}

#[test]
fn derivatives_by_states_that_do_not_fit_are_refused() {
    let (world, plan) = (world([0.5, 0.4]), plan().recording_every(150));
    let experiment = Experiment::new(&world, &plan);
    let refusal = |by_states: &[StateGradient]| {
        let vjp = experiment.vjp(&[Parameter::Gravity]).unwrap();
        vjp.pull_back(by_states).unwrap_err()
    };
    let zero = |bodies, joints| StateGradient {
        bodies: vec![BodyStateGradient::zero(); bodies],
        joints: vec![JointStateGradient::zero(); joints],
    };
    let expected = "expected derivatives with respect to 3 recorded states of 5 bodies and 0 joints each, but got derivatives with respect to ";
    for (by_states, message) in [
        (vec![], "no state"),
        (vec![zero(5, 0); 2], "2 states of 5 bodies and 0 joints"),
        (
            vec![zero(5, 0), zero(4, 0), zero(5, 0)],
            "3 states, of 5 bodies and 0 joints and of 4 bodies and 0 joints",
        ),
        (vec![zero(5, 1); 3], "3 states of 5 bodies and 1 joints"),
    ] {
        assert_eq!(
            refusal(&by_states).to_string(),
            format!("{expected}{message}")
        );
    }
    let mut lost = vec![zero(5, 0); 3];
    lost[1].bodies[0].spin.x = f64::NAN;
    let error = refusal(&lost);
    assert!(
        matches!(&error, GradientError::BackwardNotFinite { step: 151, body } if body == "a"),
        "{error}"
    );
}

#[test]
fn a_ball_that_rolls_and_a_symmetric_top() {
    for (world, parameters) in round_bodies() {
        for plan in plans((5e-3, 30)) {
            compare(&world, &plan, &parameters, &END);
        }
    }
}
