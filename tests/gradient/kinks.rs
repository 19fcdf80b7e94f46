//! The kinks of a rollout are counted completely, without false positives.

use crate::support::worlds::{dynamic, fixed, icosphere};
use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{
    Body, BodyShape, Integrator, Kink, KinkSummary, Mass, Material, Plan, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, Outcome};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Height (m) of the first body.
struct Height;

impl Outcome for Height {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        vec![trajectory.last().bodies[0].position().z]
    }
}

/// Returns the kinks of a rollout, with bodies, number of steps, first and last step. Checks that a gradient finds the same kinks.
fn kinks(world: &World, plan: &Plan) -> Vec<(Kink, Vec<usize>, usize, [usize; 2])> {
    let experiment = Experiment::new(world, plan);
    let found = experiment.kinks().unwrap();
    let gradient = experiment.full_gradient(&Height).unwrap();
    assert_eq!(gradient.kinks(), found);
    let parts = |met: KinkSummary| (met.kink, met.bodies, met.count, met.steps);
    found.into_iter().map(parts).collect()
}

fn cuboid(edges: [f64; 3]) -> Shape {
    Shape::new(shapes::cuboid(edges).unwrap())
}

fn at(shape: Shape, skin: Material, place: Vector3<f64>) -> Body {
    let body = dynamic("body", shape, skin, 1.0);
    body.with_pose(Pose::from_translation(place))
}

fn steps(count: usize) -> Plan {
    Plan::new(1e-4, count).unwrap()
}

/// Two sides of a brick and of the block below it are coplanar throughout. Near these sides, both pressures are those of the distance to
/// the common plane and therefore equal.
#[test]
fn flush_faces() {
    let skin = Material::elastic(1e5).with_friction(0.3);
    let brick = at(cuboid([0.2, 0.1, 0.1]), skin, vector![0.0, 0.0, 0.0995]);
    let block = fixed("block", cuboid([0.4, 0.1, 0.1]), skin);
    let sliding = brick.with_velocity(vector![0.2, 0.0, 0.0]);
    let world = World::new(vec![sliding, block.clone()]).unwrap();
    let all = kinks(&world, &steps(20));
    let met = |kink| (kink, vec![0, 1], 20, [1, 20]);
    assert_eq!(all, [met(Kink::Flush), met(Kink::EqualFields)]);
    // If the brick is rotated, there is no kink.
    let turned = Pose::from_rotation_vector(&vector![0.01, 0.02, 0.3], vector![0.01, 0.02, 0.0995]);
    let brick = at(cuboid([0.2, 0.1, 0.1]), skin, Vector3::zeros()).with_pose(turned);
    let world = World::new(vec![brick, block]).unwrap();
    assert_eq!(kinks(&world, &steps(20)), []);
}

/// A ball that is pulled out of a floor leaves it faster than its skin recovers.
#[test]
fn clamped_pressure() {
    let skin = Material::elastic(1e5).with_dissipation(2.0);
    let ball = || icosphere(0.1, 1);
    let floor = fixed("floor", HalfSpace::rigid(), Material::rigid());
    let leaving = |speed: f64| {
        let ball = at(ball(), skin, vector![0.01, 0.02, 0.09]);
        let ball = ball.with_velocity(vector![0.0, 0.0, speed]);
        World::new(vec![ball, floor.clone()]).unwrap()
    };
    let all = kinks(&leaving(1.0), &steps(10));
    assert_eq!(all, [(Kink::Clamped, vec![0, 1], 10, [1, 10])]);
    assert_eq!(kinks(&leaving(-1.0), &steps(10)), []);
}

#[test]
fn equal_fields() {
    let skin = Material::elastic(1e5);
    let edges = [0.2, 0.15, 0.1];
    let beside = |place| {
        let block = fixed("block", cuboid(edges), skin);
        let body = at(cuboid(edges), skin, place);
        let world = World::new(vec![body, block]).unwrap();
        let all = kinks(&world, &steps(5));
        all.into_iter()
            .filter(|met| met.0 == Kink::EqualFields)
            .collect::<Vec<_>>()
    };
    // Two bodies have the same position.
    let inside = beside(Vector3::zeros());
    assert_eq!(inside, [(Kink::EqualFields, vec![0, 1], 5, [1, 5])]);
    // The bodies are displaced along their long sides. Their fields are equal in a part of the volume, because both grow at the same rate
    // below the upper face.
    let shifted = beside(vector![0.05, 0.0, 0.0]);
    assert_eq!(shifted, [(Kink::EqualFields, vec![0, 1], 5, [1, 5])]);
    // If the bodies touch beside or above each other, their fields may have equal gradients, but no common volume.
    for apart in [
        vector![0.2, 0.0, 0.0],
        vector![0.0, 0.15, 0.0],
        vector![0.0, 0.0, 0.1],
    ] {
        assert_eq!(beside(apart), []);
    }
}

/// The skin of a half-space and that of a block below its surface grow at the same rate.
#[test]
fn equal_fields_in_a_layer() {
    let floor = HalfSpace::layer(0.1).unwrap();
    let skin = Material::elastic(1e5);
    let floor = fixed("floor", floor, skin);
    let world = |height: f64| {
        let cube = at(cuboid([0.2; 3]), skin, vector![0.0, 0.0, height]);
        World::new(vec![cube, floor.clone()]).unwrap()
    };
    let all = kinks(&world(-0.1), &steps(3));
    let equal = |all: &[(Kink, Vec<usize>, usize, [usize; 2])]| {
        all.iter().any(|met| met.0 == Kink::EqualFields)
    };
    assert!(equal(&all), "{all:?}");
    let all = kinks(&world(0.099), &steps(3));
    assert!(!equal(&all), "{all:?}");
}

/// A step in which balls hit a floor is unresolved if its budget of substeps is too small for the impact.
#[test]
fn unresolved_steps() {
    let skin = Material::elastic(1e6).with_dissipation(1.0);
    let floor = fixed("floor", HalfSpace::rigid(), Material::rigid());
    let world = |count: usize, height: f64, speed: f64| {
        let mut bodies = vec![floor.clone()];
        for number in 0..count {
            let shape = icosphere(0.1, 2);
            // Neighbors overlap slightly, so all balls are one island.
            let place = vector![0.1995 * number as f64, 0.0, height];
            let ball = Body::dynamic(&format!("ball {number}"), shape, skin, Mass::Total(1.0));
            let ball = ball.unwrap().with_pose(Pose::from_translation(place));
            bodies.push(ball.with_velocity(vector![0.0, 0.0, speed]));
        }
        World::new(bodies).unwrap()
    };
    let plan = Plan::new(5e-3, 5).unwrap();
    let by = |integrator| plan.with_integrator(integrator);
    let (sdirk3, euler) = (by(Integrator::Sdirk3), by(Integrator::ImplicitEuler));
    let unresolved = |world: &World, plan| {
        let all = kinks(world, plan).into_iter();
        all.filter(|met| met.0 == Kink::Unresolved)
            .collect::<Vec<_>>()
    };
    // The facets are slightly more than 20 mm above the floor, two steps away.
    let expected = |ball| (Kink::Unresolved, vec![ball], 3, [3, 5]);
    let expected: Vec<_> = (1..=20).map(expected).collect();
    assert_eq!(unresolved(&world(20, 0.12, -2.0), &sdirk3), expected);
    assert_eq!(unresolved(&world(20, 0.12, -2.0), &euler), []);
    assert_eq!(unresolved(&world(20, 0.3, 0.0), &sdirk3), []);
    assert_eq!(kinks(&world(1, 0.12, -2.0), &sdirk3), []);
}

/// A whole face of a brick just touches a floor. The floor pushes the brick back if it moves down, but not if it moves up.
#[test]
fn the_first_touch_of_parallel_faces_is_a_kink() {
    let skin = Material::elastic(1e5);
    let floors = [
        (HalfSpace::rigid().into(), Material::rigid(), 0.0),
        (HalfSpace::layer(0.1).unwrap().into(), skin, 0.0),
        (BodyShape::from(cuboid([1.0, 1.0, 0.2])), skin, -0.1),
        (
            RigidShape::new(
                TriangleSurface::around(cuboid([1.0, 1.0, 0.2]).field().mesh()).unwrap(),
            )
            .into(),
            Material::rigid(),
            -0.1,
        ),
    ];
    for (floor, material, place) in floors {
        for (dissipation, friction) in [(0.0, 0.0), (1.0, 0.0), (0.0, 0.5), (1.0, 0.5)] {
            for speed in [0.0, -0.1, 0.1] {
                let skin = skin.with_dissipation(dissipation).with_friction(friction);
                let brick = at(cuboid([0.2, 0.1, 0.1]), skin, vector![0.01, 0.02, 0.05]);
                let brick = brick.with_velocity(vector![0.0, 0.0, speed]);
                let floor = Body::fixed("floor", floor.clone(), material.with_friction(friction));
                let floor = floor
                    .unwrap()
                    .with_pose(Pose::from_translation(vector![0.0, 0.0, place]));
                let world = World::new(vec![brick, floor]).unwrap();
                // The first kick of this integrator acts at the initial state.
                let plan = steps(1).with_integrator(Integrator::SymplecticEuler);
                let all = kinks(&world, &plan);
                assert_eq!(
                    all,
                    [(Kink::Flush, vec![0, 1], 1, [1, 1])],
                    "{place} {dissipation} {friction} {speed}"
                );
                let world = lifted(&world, 1e-6);
                assert_eq!(kinks(&world, &plan), []);
            }
        }
    }
}

/// Returns the world with its dynamic body raised by a height (m).
fn lifted(world: &World, height: f64) -> World {
    let mut state = world.initial_state();
    let pose = &mut state.bodies[0].pose;
    *pose = pose.with_translation(pose.translation() + vector![0.0, 0.0, height]);
    world.clone().with_initial_state(&state).unwrap()
}
