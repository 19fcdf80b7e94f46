//! Worlds with rigid bodies and half-spaces.

use crate::support::worlds::{at, cuboid, dynamic, icosphere, plan_of, rubbing, turned};
use approx::assert_relative_eq;
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape};
use hydroelastic::dynamics::{
    Body, BodyShape, Integrator, Mass, Material, Plan, RolloutError, RolloutFailure, World,
    WorldError,
};
use hydroelastic::gradient::{Experiment, FinalState, GradientError, Parameter};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::sync::Arc;

/// Error of differences of a rollout with the best of the checked steps, relative to the largest entry of a column.
const DIFFERENCES: f64 = 1e-6;

/// Remainder of a bounce after it has been damped.
const AT_REST: f64 = 1e-6;

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

fn skin() -> Material {
    rubbing(1e6, 1.0, 0.4)
}

fn cube() -> Arc<Shape> {
    Arc::new(cuboid([0.2; 3]))
}

fn rigid(field: &hydroelastic::mesh::PressureField) -> RigidShape {
    RigidShape::new(TriangleSurface::around(field.mesh()).unwrap())
}

/// Returns floors at z = 0: rigid, compliant, and the upper side of a rigid slab.
fn floors() -> Vec<Body> {
    let hard = Material::rigid().with_friction(0.6);
    let slab = rigid(&shapes::cuboid([2.0, 2.0, 0.1]).unwrap());
    vec![
        Body::fixed("floor", HalfSpace::rigid(), hard).unwrap(),
        Body::fixed("floor", HalfSpace::layer(0.05).unwrap(), skin()).unwrap(),
        Body::fixed("floor", slab, hard)
            .unwrap()
            .with_pose(at(0.1, -0.2, -0.05)),
    ]
}

fn thrown(floor: Body, shape: impl Into<BodyShape>, height: f64) -> World {
    let ball = dynamic("ball", shape, skin(), 2.0);
    let start = turned([0.1, 0.2, 0.3], [0.0, 0.0, height]);
    let ball = ball
        .with_pose(start)
        .with_velocity(vector![0.5, 0.1, -1.0])
        .with_angular_velocity(vector![1.0, 2.0, -0.5]);
    // The floor comes first, but it is B nevertheless.
    let world = World::new(vec![floor, ball]).unwrap();
    world.with_gravity(GRAVITY).unwrap()
}

#[test]
fn a_cube_comes_to_rest_where_its_weight_is_carried() {
    for floor in floors() {
        let kappa = 2.0 * 1e6 / 0.2;
        let modulus = floor.material().modulus;
        let below = modulus.map(|modulus| modulus / 0.05);
        let cube = dynamic("cube", cube(), skin(), 2.0);
        let start = at(0.0, 0.0, 0.1);
        let world = World::new(vec![floor, cube.with_pose(start)]).unwrap();
        let world = world.with_gravity(GRAVITY).unwrap();
        let plan = plan_of(Integrator::Sdirk3, 0.005, 400);
        let end = world.rollout(&plan).run().unwrap();
        let state = end.last();
        let depth = 0.1 - state.bodies[1].position().z;
        let indentation = below.map_or(depth, |k| k * depth / (kappa + k));
        let a: f64 = 0.2;
        let force = kappa
            * (a * a * indentation - 2.0 * a * indentation * indentation
                + 4.0 * indentation.powi(3) / 3.0);
        assert_relative_eq!(force, 2.0 * 9.81, max_relative = AT_REST);
        assert!(world.fully_submerged(state).unwrap().is_empty());
        let contacts = world.contacts(state).unwrap();
        assert_eq!(contacts[0].bodies, [1, 0], "A is the compliant body");
    }
}

/// Returns all parameters of a throw on a floor.
fn parameters(floor: &Body) -> Vec<Parameter> {
    let name = |name: &str| Arc::<str>::from(name);
    let mut parameters = vec![
        Parameter::InitialPosition(name("ball")),
        Parameter::InitialOrientation(name("ball")),
        Parameter::InitialVelocity(name("ball")),
        Parameter::InitialAngularVelocity(name("ball")),
        Parameter::Modulus(name("ball")),
        Parameter::Dissipation(name("ball")),
        Parameter::Friction(name("ball")),
        Parameter::Friction(name("floor")),
        Parameter::InitialPosition(name("floor")),
        Parameter::InitialOrientation(name("floor")),
        Parameter::Gravity,
    ];
    if floor.material().modulus.is_some() {
        parameters.push(Parameter::Modulus(name("floor")));
        parameters.push(Parameter::Dissipation(name("floor")));
    }
    parameters
}

/// Motions that map a plane to itself, so their derivatives are round-off.
const ALONG_ITSELF: [&str; 3] = [
    "InitialPosition(\"floor\") x",
    "InitialPosition(\"floor\") y",
    "InitialOrientation(\"floor\") z",
];

#[test]
fn derivatives_of_throws_in_explicit_steps_agree_with_differences() {
    check_throws(&plan_of(Integrator::default(), 2e-4, 600));
}

#[test]
fn derivatives_of_throws_in_implicit_steps_agree_with_differences() {
    check_throws(&plan_of(Integrator::Sdirk3, 2e-3, 40));
}

/// Compares the derivatives of throws on all floors with differences.
fn check_throws(plan: &Plan) {
    for floor in floors() {
        let ball = Shape::new(shapes::ellipsoid([0.1, 0.11, 0.09], 1).unwrap());
        let parameters = parameters(&floor);
        let world = thrown(floor, ball, 0.14);
        let outcome = FinalState::of_body(&world, "ball").unwrap();
        let experiment = Experiment::new(&world, plan);
        let check = experiment.difference_check(&parameters, &outcome).unwrap();
        println!("{check}");
        for (name, best) in check.numbers.iter().zip(check.best_by_parameter()) {
            let is_idle = ALONG_ITSELF.contains(&name.as_str());
            assert!(is_idle || best <= DIFFERENCES, "{name}: {best:.1e}");
        }
    }
}

#[test]
fn a_rigid_tool_pushes_a_soft_block() {
    let block = Arc::new(cuboid([0.3, 0.3, 0.1]));
    let block = dynamic("block", block, skin(), 1.0);
    let tool = rigid(&shapes::icosphere(0.05, 2).unwrap());
    let tool = Body::dynamic(
        "tool",
        tool,
        Material::rigid().with_friction(0.5),
        Mass::Density(2000.0),
    );
    let floor = Body::fixed(
        "floor",
        HalfSpace::rigid(),
        Material::rigid().with_friction(0.5),
    );
    let bodies = vec![
        block.with_pose(at(0.0, 0.0, 0.049)),
        tool.unwrap().with_pose(at(0.05, 0.0, 0.16)),
        floor.unwrap(),
    ];
    let refused = World::new(bodies.clone()).unwrap_err();
    let names = ["tool", "floor"].map(str::to_owned);
    assert_eq!(refused, WorldError::NoContact(names));
    let world = World::builder().bodies(bodies).ignore("tool", "floor");
    let world = world.gravity(GRAVITY).build().unwrap();
    let plan = plan_of(Integrator::Sdirk3, 0.002, 300);
    let recorded = world.rollout(&plan).run().unwrap();
    let state = recorded.last();
    let height = state.bodies[1].position().z;
    // The ball is on the block, slightly pressed in.
    assert!((0.13..0.15).contains(&height), "{height}");
    let contacts = world.contacts(state).unwrap();
    let pairs: Vec<_> = contacts.iter().map(|contact| contact.bodies).collect();
    assert_eq!(pairs, [[0, 1], [0, 2]]);
    assert!(world.topology(state).unwrap().touches(1, 0));
}

#[test]
fn what_no_body_can_be_is_refused() {
    let hard = Material::rigid();
    let body = |material, shape: BodyShape| Body::fixed("it", shape, material).map(|_| ());
    let name = || "it".to_owned();
    let soft_wall = HalfSpace::layer(0.1).unwrap();
    assert_eq!(
        body(hard, cube().into()),
        Err(WorldError::NoModulus(name()))
    );
    assert_eq!(
        body(hard, soft_wall.into()),
        Err(WorldError::NoModulus(name()))
    );
    let refused = Err(WorldError::RigidWithModulus(name()));
    assert_eq!(body(skin(), HalfSpace::rigid().into()), refused);
    let falling = Body::dynamic("it", HalfSpace::rigid(), hard, Mass::Total(1.0));
    assert_eq!(falling.map(|_| ()), Err(WorldError::Unbounded(name())));
    let steep = Material::elastic(1e152);
    let thin = HalfSpace::layer(1e-3).unwrap();
    assert_eq!(
        body(steep, thin.into()),
        Err(WorldError::Steep {
            body: name(),
            slope: 1e152 * (1.0 / 1e-3)
        })
    );
    for thickness in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-310] {
        assert!(HalfSpace::layer(thickness).is_err());
    }
}

#[test]
fn bodies_share_a_shape_of_any_kind() {
    let hard = Material::rigid();
    let surface = rigid(&shapes::cuboid([0.1; 3]).unwrap());
    let shapes: [(BodyShape, _); 3] = [
        (cube().into(), skin()),
        (Arc::new(surface).into(), hard),
        (Arc::new(HalfSpace::rigid()).into(), hard),
    ];
    for (shape, material) in &shapes {
        let bodies =
            ["one", "other"].map(|name| Body::fixed(name, shape.clone(), *material).unwrap());
        assert!(bodies[0].shape().is_same(bodies[1].shape()));
    }
    assert!(!shapes[1].0.is_same(&shapes[2].0));
}

#[test]
fn a_rigid_body_has_no_modulus_to_differentiate_by() {
    let floor = floors().remove(0);
    let world = thrown(floor, cube(), 0.3);
    let plan = Plan::new(1e-3, 2).unwrap();
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let modulus = Parameter::modulus("floor");
    let refused = Experiment::new(&world, &plan).jacobian(&[modulus], &outcome);
    let body = "floor".to_owned();
    assert_eq!(refused.unwrap_err(), GradientError::NoModulus { body });
}

#[test]
fn a_body_that_goes_through_a_floor_is_reported() {
    let floor = floors().remove(0);
    let soft = Material::elastic(1e2);
    let brick = dynamic("brick", cube(), soft, 50.0);
    let start = at(0.0, 0.0, 0.15);
    let world = World::new(vec![brick.with_pose(start), floor]).unwrap();
    let world = world.with_gravity(GRAVITY).unwrap();
    let recorded = world.rollout(&Plan::new(1e-3, 600).unwrap()).run().unwrap();
    let state = recorded.last();
    assert!(world.contacts(state).unwrap().is_empty());
    assert_eq!(world.fully_submerged(state).unwrap(), [[0, 1]]);
    assert!(
        world
            .fully_submerged(&world.initial_state())
            .unwrap()
            .is_empty()
    );
}

#[test]
fn the_largest_stable_step_on_a_half_space_is_that_of_its_stiffness() {
    let floor = floors().remove(0);
    let mass = 2.0;
    let body = dynamic("cube", cube(), Material::elastic(1e6), mass);
    let depth = 0.001;
    let start = at(0.0, 0.0, 0.1 - depth);
    let world = World::new(vec![body.with_pose(start), floor]).unwrap();
    let limit = world
        .largest_stable_step(&world.initial_state())
        .unwrap()
        .unwrap();
    // The stiffest mode is vertical motion or rocking about an edge, at most 3 times its stiffness over mass.
    let kappa = 2.0 * 1e6 / 0.2;
    let along = 2.0 / (kappa * (0.2_f64 - 2.0 * depth).powi(2) / mass).sqrt();
    assert!(
        limit <= along && limit >= along / 3.0_f64.sqrt(),
        "{limit} {along}"
    );
}

/// The pressure field of a box stores up to 5 kJ at a modulus of 2e4 Pa. A fall of 0.5 m releases at least as much energy.
#[test]
fn equal_boxes_that_pass_through_each_other_are_reported() {
    for (modulus, offset, passes) in [
        (2e4, [0.1, 0.05], true),
        (2e4, [0.3, 0.2], true),
        (1e4, [0.0, 0.013], true),
        (2e5, [0.1, 0.05], false),
    ] {
        let cube = shapes::cuboid([1.0; 3]).unwrap();
        let skin = rubbing(modulus, 1.0, 0.5);
        let soft = (BodyShape::from(Shape::new(cube.clone())), skin);
        let hard = (BodyShape::from(rigid(&cube)), Material::rigid());
        for [upper, lower] in [[&soft, &soft], [&soft, &hard], [&hard, &soft]] {
            let mass = Mass::Density(1000.0);
            let body = Body::dynamic("body", upper.0.clone(), upper.1, mass).unwrap();
            let [x, y] = offset;
            let start = at(x, y, 1.5);
            let below = Body::fixed("below", lower.0.clone(), lower.1).unwrap();
            let world = World::new(vec![body.with_pose(start), below]).unwrap();
            let world = world.with_gravity(GRAVITY).unwrap();
            let plan = plan_of(Integrator::Sdirk3, 1e-2, 100);
            let states = world.rollout(&plan).run().unwrap();
            let is_reported = |state| !world.fully_submerged(state).unwrap().is_empty();
            let reported = states.states().iter().filter(|state| is_reported(state));
            assert_eq!(reported.count() > 0, passes, "{modulus} Pa, {offset:?}");
        }
    }
}

/// A soft ball is at heights beside, in and on rigid bodies of different thickness. A thick body still pushes out a ball whose center it
/// contains.
#[test]
fn a_ball_that_passes_through_a_rigid_body_is_reported() {
    let ball = icosphere(0.1, 1);
    let surface = |edges| rigid(&shapes::cuboid(edges).unwrap());
    let (table, block) = (surface([2.0, 2.0, 0.02]), surface([2.0; 3]));
    let rod = surface([0.02, 0.02, 1.0]);
    for (name, body, top, depth, is_reported) in [
        ("on the table", &table, 0.01, 0.02, false),
        ("half in the table", &table, 0.01, 0.107, true),
        ("half in the block", &block, 1.0, 0.107, false),
        ("in the block", &block, 1.0, 0.25, true),
        ("on the tip of the rod", &rod, 0.5, 0.09, false),
        ("pierced by the rod", &rod, 0.5, 0.6, true),
    ] {
        let pose = at(0.003, 0.002, top + 0.1 - depth);
        let ball = ContactBody::new(&ball, pose, 1e5).unwrap();
        let pair = ContactPair::new(ball, Partner::rigid(body, Pose::identity()).unwrap());
        assert_eq!(pair.has_sunk_through(), is_reported, "{name}");
    }
}

/// A hard pebble wholly inside a soft block still has a contact surface.
#[test]
fn a_body_wholly_inside_another_has_sunk_through() {
    let block = cuboid([1.0; 3]);
    let pebble = shapes::icosphere(0.05, 1).unwrap();
    let hard = rigid(&pebble);
    let pebble = Shape::new(pebble);
    let block = ContactBody::new(&block, Pose::identity(), 1e4).unwrap();
    for (height, is_inside) in [(0.3, true), (0.44, true), (0.47, false), (0.6, false)] {
        let pose = at(0.1, 0.2, height);
        let soft = ContactBody::new(&pebble, pose, 1e7).unwrap();
        let pairs = [
            ContactPair::new(soft, block),
            ContactPair::new(block, soft),
            ContactPair::new(block, Partner::rigid(&hard, pose).unwrap()),
        ];
        for pair in pairs {
            assert_eq!(pair.has_sunk_through(), is_inside, "{height}");
        }
    }
}

/// A soft layer pushes up a body that is wholly below its surface, so rollouts may start there.
#[test]
fn a_rollout_may_start_below_a_soft_layer_that_pushes_the_body_out() {
    let layer = HalfSpace::layer(0.1).unwrap();
    let layer = Body::fixed("layer", layer, Material::elastic(3e4)).unwrap();
    let ball = Arc::new(icosphere(0.01, 2));
    let ball = dynamic("ball", ball, Material::elastic(1e6), 0.008);
    let plan = Plan::new(1e-4, 10).unwrap();
    for (height, is_lost) in [(-0.02, false), (-10.0, true)] {
        let start = at(0.0, 0.0, height);
        let world = World::new(vec![ball.clone().with_pose(start), layer.clone()]).unwrap();
        match world.rollout(&plan).run() {
            Ok(states) => assert!(!is_lost && states.last().bodies[0].twist.linear.z > 0.0),
            Err(RolloutFailure { error, .. }) => {
                assert!(is_lost && matches!(error, RolloutError::StartsBelow { .. }));
            }
        }
    }
}

#[test]
fn a_body_that_starts_below_a_floor_is_an_error() {
    for floor in floors() {
        let name = floor.name().to_owned();
        let fixed = floor.clone();
        for (height, is_below) in [(-0.11, true), (-0.09, false), (0.2, false)] {
            let brick = dynamic("brick", cube(), skin(), 1.0);
            let start = at(0.0, 0.0, height);
            let world = World::new(vec![brick.with_pose(start), fixed.clone()]).unwrap();
            for integrator in [Integrator::Leapfrog, Integrator::Sdirk3] {
                let plan = plan_of(integrator, 1e-4, 1);
                let started = world.rollout(&plan).run();
                let is_half_space = fixed.shape().bounds().is_none();
                match started {
                    Err(RolloutFailure {
                        error: RolloutError::StartsBelow { bodies },
                        ..
                    }) => {
                        assert!(is_below && is_half_space);
                        assert_eq!(bodies, ["brick".to_owned(), name.clone()]);
                    }
                    expected_error => assert!(!is_below || !is_half_space, "{expected_error:?}"),
                }
            }
            let passing = world.with_ignored("brick", &name).unwrap();
            assert!(
                passing
                    .step(&passing.initial_state(), &Plan::new(1e-4, 1).unwrap())
                    .is_ok()
            );
        }
    }
}

#[test]
fn a_body_without_friction_of_its_own_takes_that_of_its_partner() {
    let [rough, smooth, hard] = [skin(), skin().with_friction(0.0), Material::rigid()];
    for (material, partner, expected) in [
        (rough, hard, 0.4),
        (hard, rough, 0.4),
        (smooth, hard, 0.0),
        (hard, hard, 0.0),
        (rough, hard.with_friction(0.0), 0.0),
        (rough, hard.with_friction(0.6), 0.48),
    ] {
        let actual = material.combined_with(&partner, 1e-3).friction();
        assert_relative_eq!(actual, expected, max_relative = f64::EPSILON);
    }
}
