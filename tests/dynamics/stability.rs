//! The largest stable time step: against closed forms, against the eigenvalues of a step, and against
//! rollouts that blow up just above it and not just below.

use crate::support::balls::fine_ball;
use crate::support::scenes::Random;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Batch, Body, BodyState, Integrator, Mass, Material, Plan, RolloutError, State, World,
};
use hydroelastic::gradient::{Experiment, FinalPosition, FinalState, GradientError, Parameter};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3, vector};
use num_dual::Dual64;
use std::sync::Arc;

const GRAVITY: f64 = 9.81;

/// What the search for the stiffest motion leaves of a limit.
const FOUND: f64 = 1e-5;

/// The limit against where the eigenvalues of one step leave the unit circle by −1. What sliding friction
/// adds to the stiffness, which is no part of the limit, is what differs.
const EIGENVALUES: f64 = 2e-2;

/// The same without friction and at rest, of bodies that nothing keeps in balance: their torque turns
/// with them, which is no stiffness.
const EIGENVALUES_AT_REST: f64 = 2e-3;

/// Resolution of a limit found by blow-ups: 4,000 steps at 1.0005 of the limit multiply a disturbance
/// by exp(4,000·√(8·0.0005)) if it is elastic and by exp(4,000·0.001) = 55 if damping rules; at 0.9995 an elastic
/// one is multiplied by up to 1/√(1 − 0.9995²) = 32. Both are to be told apart by a factor of 50.
const RESOLUTION: f64 = 1e-3;
const STEPS: usize = 4_000;
const GROWTH: f64 = 50.0;

/// Disturbance (m/s, and rad/s by the size of a body): far below the slip tolerance and the
/// reciprocal of any dissipation here, so that the response is linear until it has grown.
const DISTURBANCE: f64 = 1e-8;

const EDGE: f64 = 0.2;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

fn cuboid(lengths: [f64; 3]) -> Arc<Shape> {
    Arc::new(Shape::new(shapes::cuboid(lengths).unwrap()))
}

fn cube(name: &str, edge: f64, skin: Material) -> Body {
    Body::dynamic(name, cuboid([edge; 3]), skin, Mass::Total(1.0)).unwrap()
}

fn slab_skin(skin: Material) -> Material {
    Material {
        modulus: 3e6,
        ..skin
    }
}

/// A slab whose top is z = 0, of the closed forms: modulus 3e6, half depth 0.5.
fn slab(skin: Material) -> Body {
    let slab = Body::fixed("slab", cuboid([2.0, 2.0, 1.0]), slab_skin(skin)).unwrap();
    slab.at(at(0.0, 0.0, -0.5))
}

/// A cube of 1 kg, pressed so deep (m) into a slab.
fn cube_on_slab(skin: Material, depth: f64) -> World {
    let cube = cube("cube", EDGE, skin).at(at(0.03, 0.05, EDGE / 2.0 - depth));
    with_gravity(World::new(vec![cube, slab(skin)]).unwrap())
}

fn with_gravity(world: World) -> World {
    world.with_gravity(vector![0.0, 0.0, -GRAVITY]).unwrap()
}

fn limit(world: &World) -> f64 {
    world
        .largest_stable_step(&world.initial_state())
        .unwrap()
        .unwrap()
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(error <= tolerance, "{found:e}, not {expected:e}: {error:e}");
}

/// κ(a − 2δ)² for a cube of edge a pressed x = 0.01 m deep: see the closed forms of the wrench.
const STIFFNESS_AT_A_CENTIMETRE: f64 = 138_960.937_5;

/// Depth (m) of a cube of 1 kg at rest.
const REST: f64 = 6.541_604_590_930e-5;

// Closed forms.

#[test]
fn a_flat_cube_on_a_flat_slab_has_the_limit_of_its_heave() {
    let skin = Material::elastic(1e6);
    let world = cube_on_slab(skin, 0.01);
    assert_close(limit(&world), 2.0 / STIFFNESS_AT_A_CENTIMETRE.sqrt(), FOUND);
    // ω = 387.203326 rad/s.
    assert_close(limit(&cube_on_slab(skin, REST)), 2.0 / 387.203_326, FOUND);
}

#[test]
fn two_free_bodies_of_equal_mass_have_half_the_effective_mass() {
    let skin = Material::elastic(1e6);
    let free = Body::dynamic(
        "slab",
        cuboid([2.0, 2.0, 1.0]),
        slab_skin(skin),
        Mass::Total(1.0),
    );
    let bodies = vec![
        cube("cube", EDGE, skin).at(at(0.0, 0.0, EDGE / 2.0 - 0.01)),
        free.unwrap().at(at(0.0, 0.0, -0.5)),
    ];
    let world = World::new(bodies).unwrap();
    assert_close(
        limit(&world),
        2.0 / (2.0 * STIFFNESS_AT_A_CENTIMETRE).sqrt(),
        FOUND,
    );
}

/// At the rim the cube's sides press too, on a bevel as wide as its depth, 7e-4 of its edge.
const BEVEL: f64 = 1e-3;

#[test]
fn dissipation_enters_with_the_force_and_beside_the_stiffness() {
    for dissipation in [0.01_f64, 1.0, 100.0] {
        let skin = Material::elastic(1e6).with_dissipation(dissipation);
        let (k, c) = (387.203_326_f64.powi(2), dissipation * GRAVITY);
        let expected = 4.0 / (c + (c * c + 4.0 * k).sqrt());
        assert_close(limit(&cube_on_slab(skin, REST)), expected, BEVEL);
    }
}

/// By hand the pressure of a ball and its moments are taken at one point: off by the depth over the
/// radius, a few parts in a hundred.
const BY_HAND: f64 = 3e-2;

#[test]
fn friction_of_a_ball_at_rest_enters_with_its_force_over_the_slip_tolerance() {
    let skin = Material::elastic(1e6).with_friction(0.5);
    let ball = Arc::new(fine_ball(0.1, 24, 12));
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(1.0)).unwrap();
    let bodies = vec![ball.at(at(0.0, 0.0, 0.098)), slab(skin)];
    for slip_tolerance in [1e-4, 1e-3] {
        let world = World::new(bodies.clone()).unwrap();
        let world = world.with_slip_tolerance(slip_tolerance).unwrap();
        let state = world.initial_state();
        let pair = world.contact_between(&state, "ball", "slab").unwrap();
        // A ball's surface gives way by its turning too: 1/m + r²/(0.4 m r²).
        let rate = 0.5 * pair.wrench().on_a.force.z / slip_tolerance * 3.5;
        assert_close(limit(&world), 2.0 / rate, BY_HAND);
    }
}

/// Blocks of falling width on a slab, each at rest under those above it.
fn stack(count: usize) -> World {
    let skin = Material::elastic(1e6);
    let (mut top, mut bodies) = (0.0, vec![slab(skin)]);
    for index in 0..count {
        let edge = EDGE - 0.02 * index as f64;
        let name = format!("block {index}");
        // Between equal moduli each gives way by half the overlap.
        top += edge - 1e-4;
        bodies.push(cube(&name, edge, skin).at(at(0.03, 0.05, top - edge / 2.0)));
    }
    World::new(bodies).unwrap()
}

/// The limit of a chain of unit masses on springs, of which the first is fixed to the ground.
fn limit_of_chain(springs: &[f64]) -> f64 {
    let mut stiffness = DMatrix::<f64>::zeros(springs.len(), springs.len());
    for (index, &spring) in springs.iter().enumerate() {
        stiffness[(index, index)] += spring;
        if index > 0 {
            stiffness[(index - 1, index - 1)] += spring;
            stiffness[(index - 1, index)] -= spring;
            stiffness[(index, index - 1)] -= spring;
        }
    }
    2.0 / stiffness.symmetric_eigenvalues().max().sqrt()
}

#[test]
fn a_stack_has_the_limit_of_a_chain_of_springs() {
    let mut before = f64::INFINITY;
    for count in 1..=6 {
        let world = stack(count);
        let state = world.initial_state();
        let spring = |index: usize| {
            let below = match index {
                0 => "slab".to_owned(),
                _ => format!("block {}", index - 1),
            };
            let pair = world.contact_between(&state, &format!("block {index}"), &below);
            -pair.unwrap().wrench_and_jacobian().1.on_a.by_pose_a[(5, 5)]
        };
        let springs: Vec<f64> = (0..count).map(spring).collect();
        assert_close(limit(&world), limit_of_chain(&springs), FOUND);
        assert!(limit(&world) < before, "{count}");
        before = limit(&world);
    }
}

// Against the eigenvalues of one step.

/// The derivative of a body's state after one step by its state before: position, rotation vector,
/// velocity, spin.
fn step_matrix(world: &World, body: &str, time_step: f64, integrator: Integrator) -> DMatrix<f64> {
    let by = [
        Parameter::InitialPosition(body.into()),
        Parameter::InitialOrientation(body.into()),
        Parameter::InitialVelocity(body.into()),
        Parameter::InitialSpin(body.into()),
    ];
    let plan = Plan::new(time_step, 1).unwrap();
    let experiment = Experiment::new(world, &plan.with_integrator(integrator));
    let outcome = FinalState::of_body(world, body).unwrap();
    let found = experiment.jacobian(&by, &outcome).unwrap();
    let rotation = Matrix3::from_column_slice(&found.value.as_slice()[3..12]);
    DMatrix::from_fn(12, 12, |row, column| {
        let slopes = found.jacobian.column(column);
        match row {
            0..3 => slopes[row],
            3..6 => {
                let turn = Matrix3::from_iterator(slopes.iter().skip(3).take(9).copied());
                let turn = turn * rotation.transpose();
                let (i, j) = ((row - 3 + 1) % 3, (row - 3 + 2) % 3);
                (turn[(j, i)] - turn[(i, j)]) / 2.0
            }
            _ => slopes[row + 6],
        }
    })
}

/// The time step at which the first mode of one step begins to change sign and grow: where an
/// eigenvalue μ of its matrix passes −1, the product of all 1 + μ changes sign.
fn flipping_step(world: &World, body: &str, guess: f64, integrator: Integrator) -> f64 {
    let has_flipped = |step: f64| {
        let matrix = step_matrix(world, body, step, integrator);
        (matrix + DMatrix::identity(12, 12)).determinant() < 0.0
    };
    let steps = (1..=100).map(|index| guess * (0.8 + 0.005 * f64::from(index)));
    assert!(!has_flipped(0.8 * guess));
    let beyond = steps.into_iter().find(|&step| has_flipped(step)).unwrap();
    bisected([beyond - 0.005 * guess, beyond], 1e-6, has_flipped)
}

/// Where a claim about the time step becomes true, between two steps.
fn bisected([mut low, mut high]: [f64; 2], resolution: f64, holds: impl Fn(f64) -> bool) -> f64 {
    assert!(!holds(low) && holds(high), "not between {low} and {high}");
    while high / low - 1.0 > resolution {
        let middle = (low * high).sqrt();
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    (low * high).sqrt()
}

/// An ellipsoid or a brick pressed askew into a slab: no two of its modes are alike, which would take the
/// sign of the product through zero twice at once.
fn askew(random: &mut Random, skin: Material) -> World {
    let fields = [
        shapes::ellipsoid([0.1, 0.15, 0.2], 2),
        shapes::cuboid([0.2, 0.25, 0.3]),
    ];
    let shape = Shape::new(fields[random.below(2)].clone().unwrap());
    let height = random.between(0.09, 0.13);
    let pose = Pose::from_rotation_vector(&random.rotation_vector(), vector![0.03, 0.05, height]);
    let body = Body::dynamic("body", shape, skin, Mass::Total(1.0)).unwrap();
    World::new(vec![body.at(pose), slab(skin)]).unwrap()
}

/// The largest of the relative differences of limits from where eigenvalues cross, of worlds that touch.
fn worst_of_eigenvalues(skin: Material, speed: f64, integrator: Integrator) -> [f64; 2] {
    let mut random = Random::new(7);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let mut compared = 0;
    while compared < 30 {
        let mut world = askew(&mut random, skin);
        let state = world.initial_state();
        let mut bodies = world.bodies().to_vec();
        bodies[0] = bodies[0]
            .clone()
            .with_velocity(random.vector() * speed)
            .with_spin(random.vector() * (speed / 0.15));
        if world.largest_stable_step(&state).unwrap().is_none() {
            continue;
        }
        world = World::new(bodies).unwrap();
        let found = limit(&world);
        let ratio = found / flipping_step(&world, "body", found, integrator) - 1.0;
        range = [range[0].min(ratio), range[1].max(ratio)];
        compared += 1;
    }
    println!("{skin:?} at {speed} m/s, {integrator:?}: {range:?}");
    range
}

#[test]
fn eigenvalues_of_an_elastic_step_cross_at_the_limit() {
    let skin = Material::elastic(1e6);
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        let [low, high] = worst_of_eigenvalues(skin, 0.0, integrator);
        assert!(low >= -EIGENVALUES_AT_REST && high <= EIGENVALUES_AT_REST);
    }
}

#[test]
fn eigenvalues_of_a_step_that_rubs_cross_near_the_limit() {
    for (dissipation, friction) in [(0.3, 0.0), (0.0, 0.5), (0.3, 0.5)] {
        let skin = Material::elastic(1e6)
            .with_dissipation(dissipation)
            .with_friction(friction);
        // Within the slip tolerance and far beyond.
        for speed in [0.0, 1e-4, 0.3] {
            let [low, high] = worst_of_eigenvalues(skin, speed, Integrator::SymplecticEuler);
            assert!(low >= -EIGENVALUES && high <= EIGENVALUES, "{low} {high}");
        }
    }
}

// Against rollouts.

/// The largest speed of a body (m/s, spin by 0.1 m).
fn speed(state: &State) -> f64 {
    let of_body = |body: &BodyState| body.twist.linear.norm() + 0.1 * body.twist.angular.norm();
    state.bodies.iter().map(of_body).fold(0.0, f64::max)
}

/// Whether a slight disturbance of a state at rest has grown after many steps.
fn blows_up(world: &World, time_step: f64) -> bool {
    let mut state = world.initial_state();
    for (body, number) in world.bodies().iter().zip(&mut state.bodies) {
        if body.inertia().is_some() {
            number.twist.linear = vector![0.4, -0.5, 0.7] * DISTURBANCE;
            number.twist.angular = vector![0.6, 0.3, -0.5] * (DISTURBANCE / EDGE);
        }
    }
    let start = speed(&state);
    let rollout = world.rollout(&Plan::new(time_step, STEPS).unwrap());
    let mut states = rollout.starting_from(state).unwrap().take(STEPS);
    states.any(|state| state.map_or(true, |state| speed(&state) > GROWTH * start))
}

fn assert_blows_up_at_the_limit(world: &World) {
    let found = limit(world);
    let range = [found / 2.0, found * 2.0];
    let blown = bisected(range, RESOLUTION / 10.0, |step| blows_up(world, step));
    println!("{found:e} {:e}", found / blown - 1.0);
    assert_close(found, blown, RESOLUTION);
}

#[test]
fn an_elastic_cube_blows_up_at_the_limit() {
    assert_blows_up_at_the_limit(&cube_on_slab(Material::elastic(1e6), REST));
}

#[test]
fn a_cube_ruled_by_dissipation_blows_up_at_the_limit() {
    let world = cube_on_slab(Material::elastic(1e6).with_dissipation(1e3), REST);
    let elastic = cube_on_slab(Material::elastic(1e6), REST);
    assert!(limit(&world) < 0.1 * limit(&elastic));
    assert_blows_up_at_the_limit(&world);
}

#[test]
fn a_cube_ruled_by_friction_blows_up_at_the_limit() {
    let world = cube_on_slab(Material::elastic(1e6).with_friction(0.5), REST);
    let elastic = cube_on_slab(Material::elastic(1e6), REST);
    assert!(limit(&world) < 0.1 * limit(&elastic));
    assert_blows_up_at_the_limit(&world);
}

#[test]
fn a_cube_ruled_by_nothing_alone_blows_up_at_the_limit() {
    let skin = Material::elastic(1e6).with_dissipation(30.0);
    assert_blows_up_at_the_limit(&cube_on_slab(skin.with_friction(0.01), REST));
}

/// Steps in which bodies of much dissipation come to rest to round-off. Not more: a stack without friction slides apart, 34 times as
/// fast every 5,000 steps.
const SETTLING: usize = 10_000;

/// A world of bodies where they come to rest.
fn at_rest(bodies: impl Fn(Material) -> Vec<Body>, skin: Material) -> World {
    let damped = Material::elastic(skin.modulus).with_dissipation(10.0);
    let world = with_gravity(World::new(bodies(damped)).unwrap());
    let plan = Plan::new(limit(&world) / 2.0, SETTLING + 1).unwrap();
    let rest = world.rollout(&plan).nth(SETTLING).unwrap().unwrap();
    assert!(speed(&rest) < 1e-3 * DISTURBANCE, "{:e}", speed(&rest));
    let bodies = bodies(skin).into_iter().zip(&rest.bodies);
    let placed = bodies.map(|(body, state)| body.at(state.pose));
    with_gravity(World::new(placed.collect()).unwrap())
}

/// A coarse ball that stands on a face, and a slab. It is so light that the face's stiffness keeps it
/// upright.
fn ball_on_slab(skin: Material) -> Vec<Body> {
    let field = shapes::icosphere(EDGE / 2.0, 1).unwrap();
    // A face in the middle of an icosahedron's: its normal goes through its centroid.
    let faces = field.mesh().surface_triangles().iter();
    let corners = faces.map(|face| face.map(|vertex| field.mesh().vertices()[vertex]));
    let (normal, distance) = corners
        .map(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a)).normalize();
            let off = (a + b + c).cross(&normal).norm();
            (off, normal, a.dot(&normal))
        })
        .min_by(|one, other| one.0.total_cmp(&other.0))
        .map(|(_, normal, distance)| (normal, distance))
        .unwrap();
    let turn = Rotation3::rotation_between(&normal, &-Vector3::z()).unwrap();
    let place = vector![0.03, 0.05, distance - 1e-5];
    let ball = Body::dynamic("ball", Shape::new(field), skin, Mass::Total(0.2)).unwrap();
    vec![
        ball.at(Pose::new(turn.into_inner(), place).unwrap()),
        slab(skin),
    ]
}

#[test]
fn a_ball_on_a_slab_blows_up_at_the_limit() {
    let elastic = Material::elastic(1e6);
    for skin in [
        elastic,
        elastic.with_dissipation(30.0),
        elastic.with_dissipation(30.0).with_friction(0.02),
        elastic.with_friction(0.5),
    ] {
        assert_blows_up_at_the_limit(&at_rest(ball_on_slab, skin));
    }
}

/// A cube on a larger one on a slab.
fn two_on_slab(skin: Material) -> Vec<Body> {
    let lower = cube("lower", EDGE, skin).at(at(0.03, 0.05, EDGE / 2.0 - 1e-4));
    let above = EDGE + 0.08 - 2e-4;
    let upper = cube("upper", 0.16, skin).at(at(0.03, 0.05, above));
    vec![lower, upper, slab(skin)]
}

#[test]
fn a_stack_of_two_blows_up_at_the_limit() {
    let elastic = Material::elastic(1e6);
    for skin in [
        elastic,
        elastic.with_dissipation(30.0),
        elastic.with_dissipation(30.0).with_friction(0.01),
        elastic.with_friction(0.5),
    ] {
        assert_blows_up_at_the_limit(&at_rest(two_on_slab, skin));
    }
}

// The check along a rollout.

/// A cube that falls 5 mm on a slab, to touch it after 32 ms.
fn falling() -> World {
    cube_on_slab(Material::elastic(1e6), -5e-3)
}

const TOO_LONG: f64 = 6e-3;
const SHORT_ENOUGH: f64 = 5e-3;

/// The step, the time and the limit at which a rollout was ended.
fn ended(error: &RolloutError) -> (usize, f64, f64) {
    let RolloutError::TimeStepTooLong {
        step,
        time,
        time_step,
        limit,
        bodies,
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(time_step.to_bits(), TOO_LONG.to_bits());
    assert_eq!(bodies, &["cube", "slab"]);
    (*step, *time, *limit)
}

#[test]
fn a_rollout_whose_step_is_too_long_ends_before_the_first_kick_that_shows_it() {
    let world = falling();
    let plan = Plan::new(TOO_LONG, 0).unwrap().with_stability_check(1);
    let mut rollout = world.rollout(&plan);
    let states: Vec<State> = rollout.by_ref().map_while(Result::ok).collect();
    let (step, time, limit) = ended(&rollout.advance().unwrap_err());
    // 5 mm take 31.9 ms: the middle of the sixth step is the first place in the slab where a kick acts.
    assert_eq!((states.len(), step), (5, 6));
    assert_eq!(time.to_bits(), rollout.state().time.to_bits());
    let mut there = rollout.state().clone();
    let fall = there.bodies[0].twist.linear * (TOO_LONG / 2.0);
    let pose = &mut there.bodies[0].pose;
    *pose = pose.with_translation(pose.translation() + fall);
    let expected = world.largest_stable_step(&there).unwrap().unwrap();
    assert!(
        (limit / expected - 1.0).abs() < 1e-12,
        "{limit:e} {expected:e}"
    );
    assert!(limit < TOO_LONG);
    assert!(rollout.next().is_none());
    let message = rollout.advance().unwrap_err().to_string();
    assert!(message.contains("6.000e-3 s is too long"), "{message}");
    assert!(message.contains("\"cube\" and \"slab\""), "{message}");
}

/// A light ball that hits the floor at 3 m/s in steps of 1 ms: the impact lasts two steps, one, or a part of one.
#[test]
fn impacts_that_would_make_energy_are_stopped() {
    /// At half the limit an undamped oscillation swings by a third of its energy, at the limit by any amount.
    const MOST: f64 = 1.5;
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()));
    let slab = Arc::new(Shape::new(shapes::cuboid([4.0, 4.0, 0.4]).unwrap()));
    for modulus in [1e6, 1e7, 1e8, 1e9, 1e10, 1e11] {
        let skin = Material::elastic(modulus);
        let (mut stopped, mut worst, mut unchecked) = (0, 0.0_f64, 0.0_f64);
        for phase in 0..100 {
            let height = 0.12 + 3e-5 * f64::from(phase);
            let ball = Body::dynamic("ball", Arc::clone(&ball), skin, Mass::Total(0.1)).unwrap();
            let slab = Body::fixed("slab", Arc::clone(&slab), skin).unwrap();
            let world = World::new(vec![
                ball.at(Pose::from_translation(vector![0.0, 0.0, height]))
                    .with_velocity(vector![0.0, 0.0, -3.0]),
                slab.at(Pose::from_translation(vector![0.013, 0.021, -0.2])),
            ])
            .unwrap();
            let plan = Plan::new(1e-3, 40).unwrap().recording_every(40);
            let energy = |end: &State| (end.bodies[0].twist.linear.norm() / 3.0).powi(2);
            unchecked = unchecked.max(energy(world.rollout(&plan).recorded().unwrap().last()));
            match world.rollout(&plan.with_stability_check(1)).recorded() {
                Ok(trajectory) => worst = worst.max(energy(trajectory.last())),
                Err(_) => stopped += 1,
            }
        }
        println!("{modulus:e} Pa: {stopped} stopped, energy {worst:.3}, unchecked {unchecked:.3}");
        assert!(worst < MOST, "{modulus:e} Pa: {worst}");
        assert_eq!(stopped > 0, unchecked > MOST, "{modulus:e} Pa: {stopped}");
    }
}

#[test]
fn what_was_recorded_before_is_kept() {
    let world = falling();
    let plan = Plan::new(TOO_LONG, 100).unwrap();
    for (every, checked, step) in [(1, 1, 6), (2, 1, 6), (1, 3, 7), (4, 6, 7)] {
        let plan = plan.recording_every(every).with_stability_check(checked);
        let interrupted = world.rollout(&plan).recorded().unwrap_err();
        assert_eq!(ended(&interrupted.error).0, step);
        let recorded = interrupted.trajectory.states().len();
        assert_eq!(recorded, 1 + (step - 1) / every);
    }
    // Between two checks nothing is looked at.
    let rollout = world.rollout(&plan.with_stability_check(100));
    assert!(rollout.recorded().is_ok());
}

#[test]
fn a_rollout_whose_step_is_short_enough_goes_on_with_the_same_states() {
    let world = falling();
    let plain = Plan::new(SHORT_ENOUGH, 200).unwrap();
    let checked = world.rollout(&plain.with_stability_check(1));
    let checked = checked.recorded().unwrap();
    let unchecked = world.rollout(&plain).recorded().unwrap();
    for (checked, unchecked) in checked.states().iter().zip(unchecked.states()) {
        let [a, b] = [checked, unchecked].map(|state| state.bodies[0].position().z);
        assert_eq!(a.to_bits(), b.to_bits());
    }
}

#[test]
fn batches_and_experiments_check_too_and_so_do_dual_numbers() {
    let world = falling();
    let lifted = world.lifted::<Dual64>();
    let plan = Plan::new(TOO_LONG, 100).unwrap();
    assert!(Batch::new(&plan).of_worlds(std::slice::from_ref(&world))[0].is_ok());
    let plan = plan.with_stability_check(1);
    let batch = Batch::new(&plan);
    let results = batch.of_worlds(std::slice::from_ref(&lifted));
    assert_eq!(ended(&results[0].as_ref().unwrap_err().error).0, 6);

    let outcome = FinalPosition::of_body(&world, "cube").unwrap();
    let by = [Parameter::InitialVelocity("cube".into())];
    let of_samples = batch.gradients_after(&world, &by, &[[0.0; 3]], &outcome);
    let experiment = Experiment::new(&world, &plan);
    let errors = [
        of_samples[0].as_ref().unwrap_err().clone(),
        experiment.jacobian(&by, &outcome).unwrap_err(),
        experiment.value(&outcome).unwrap_err(),
    ];
    for error in errors {
        let GradientError::Rollout(error) = error else {
            panic!("{error}")
        };
        assert_eq!(ended(&error).0, 6);
    }
}

// What counts.

#[test]
fn nothing_that_touches_is_no_limit() {
    let falling = falling();
    assert!(
        falling
            .largest_stable_step(&falling.initial_state())
            .unwrap()
            .is_none()
    );
    let pressed = cube_on_slab(Material::elastic(1e6), 0.01);
    let ignoring = pressed.ignoring("cube", "slab").unwrap();
    assert!(
        ignoring
            .largest_stable_step(&ignoring.initial_state())
            .unwrap()
            .is_none()
    );
    // Two bodies that forces do not move.
    let skin = Material::elastic(1e6);
    let fixed = Body::fixed("cube", cuboid([EDGE; 3]), skin).unwrap();
    let still = World::new(vec![fixed.at(at(0.0, 0.0, 0.09)), slab(skin)]).unwrap();
    assert!(
        still
            .largest_stable_step(&still.initial_state())
            .unwrap()
            .is_none()
    );
}

#[test]
fn the_limit_of_many_is_that_of_the_stiffest_contact_and_names_it() {
    let skin = Material::elastic(1e6);
    let beside = |name, x, depth, mass| {
        let body = Body::dynamic(name, cuboid([EDGE; 3]), skin, Mass::Total(mass)).unwrap();
        body.at(at(x, 0.05, EDGE / 2.0 - depth))
    };
    // The lightest is the stiffest; the one in the air is none.
    let bodies = vec![
        beside("heavy", -0.5, 0.001, 2.0),
        slab(skin),
        beside("light", 0.03, 0.001, 0.5),
        beside("in the air", 0.5, -0.1, 0.01),
    ];
    let world = World::new(bodies.clone()).unwrap();
    let alone = World::new(bodies[1..3].to_vec()).unwrap();
    assert_close(limit(&world), limit(&alone), FOUND);
    let plan = Plan::new(2.0 * limit(&world), 1).unwrap();
    let mut rollout = world.rollout(&plan.with_stability_check(10));
    let ended = rollout.next().unwrap();
    let Err(RolloutError::TimeStepTooLong { step, bodies, .. }) = ended else {
        panic!("{ended:?}")
    };
    assert_eq!((step, bodies), (1, ["slab".to_owned(), "light".to_owned()]));
}

#[test]
fn where_a_bodys_frame_has_its_origin_does_not_matter() {
    let skin = Material::elastic(1e6)
        .with_dissipation(0.3)
        .with_friction(0.5);
    let off = vector![0.3, -0.2, 0.5];
    let field = shapes::ellipsoid([0.1, 0.15, 0.2], 2).unwrap();
    let vertices = field.mesh().vertices().iter().map(|vertex| vertex - off);
    let mesh = TetMesh::new(vertices.collect(), field.mesh().tets().to_vec()).unwrap();
    let shifted = PressureField::new(mesh, field.extents().to_vec()).unwrap();
    let turn = vector![0.4, 0.3, 0.2];
    let limits = [(field, Vector3::zeros()), (shifted, off)].map(|(field, off)| {
        let body = Body::dynamic("body", Shape::new(field), skin, Mass::Total(1.0)).unwrap();
        let upright = Pose::from_rotation_vector(&turn, Vector3::zeros());
        let origin = vector![0.03, 0.05, 0.11] + upright.rotation() * off;
        let body = body
            .at(Pose::from_rotation_vector(&turn, origin))
            .with_velocity(vector![0.1, 0.2, -0.3]);
        limit(&World::new(vec![body, slab(skin)]).unwrap())
    });
    assert_close(limits[0], limits[1], FOUND);
}

#[test]
fn friction_beyond_its_limit_chatters_and_does_not_blow_up() {
    let world = cube_on_slab(Material::elastic(1e6).with_friction(0.5), REST);
    let time_step = 6.0 * limit(&world);
    let mut state = world.initial_state();
    state.bodies[0].twist.linear.x = DISTURBANCE;
    let rollout = world.rollout(&Plan::new(time_step, STEPS).unwrap());
    let states = rollout.starting_from(state).unwrap().take(STEPS);
    let fastest = states
        .map(|state| speed(&state.unwrap()))
        .fold(0.0, f64::max);
    // What the largest friction changes of the velocity in a step.
    let kick = 0.5 * GRAVITY * time_step;
    println!("{} of a kick", fastest / kick);
    assert!(fastest > 0.1 * kick && fastest < 3.0 * kick);
}
