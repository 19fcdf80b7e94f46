//! Whole worlds and plans: loaded worlds behave identically bit for bit, and invalid ones are rejected.

use crate::support::worlds::{cuboid, fixed, icosphere};
use crate::text_and_bits::{TIME_STEP, refusal, reloaded, saved, trajectory_bits};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Body, BodyState, Control, JointKind, LoopJoint, Mass, Material, Plan, Spring, World,
};
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Matrix3, Unit, Vector3, vector};
use std::sync::Arc;

/// Returns a ball and a brick of one material on a floor, with a spring, a control and an ignored pair.
fn furnished() -> World<f64, Spring> {
    let skin = Material::elastic(1e5)
        .with_friction(0.4)
        .with_dissipation(0.2);
    let ball = Arc::new(icosphere(0.1, 1));
    let brick = cuboid([0.1, 0.2, 0.3]);
    let floor = cuboid([2.0, 2.0, 0.2]);
    let at = |body: Body, x: f64, z: f64| {
        let turn = vector![0.1, x, -0.2];
        body.with_pose(Pose::from_rotation_vector(&turn, vector![x, 0.0, z]))
    };
    let dynamic = |name, shape: Arc<Shape>| Body::dynamic(name, shape, skin, Mass::Total(1.3));
    let spring = Spring {
        bodies: ["ball".into(), "brick".into()],
        points: [[0.0; 3], [0.01, 0.02, 0.1]],
        rest_length: 0.3.into(),
        stiffness: 40.0.into(),
        damping: 0.1.into(),
    };
    let push = Wrench {
        torque: vector![0.01, 0.0, 0.1 / 3.0],
        force: vector![0.3, 0.0, -1.0],
    };
    let control = Control::new("brick", 0.01, vec![push, push.rotated(&turned(0.3))]).unwrap();
    World::new(vec![
        at(dynamic("ball", Arc::clone(&ball)).unwrap(), -0.4, 0.195),
        at(dynamic("other ball", ball).unwrap(), -0.3, 0.33),
        at(dynamic("brick", brick.into()).unwrap(), 0.3, 0.19),
        fixed("floor", floor, skin),
    ])
    .and_then(|world| world.with_gravity(vector![0.1, 0.0, -9.81]))
    .and_then(|world| world.with_slip_tolerance(2e-3))
    .and_then(|world| world.with_force_parameter("stiffness", 0.3))
    .and_then(|world| world.with_ignored("ball", "other ball"))
    .and_then(|world| world.with_control(control))
    .and_then(|world| world.with_forces(spring))
    .unwrap()
}

fn turned(angle: f64) -> Matrix3<f64> {
    *Pose::from_rotation_vector(&vector![0.0, angle, 0.1], Vector3::zeros()).rotation()
}

#[test]
fn loaded_worlds_have_the_same_rollouts_and_gradients_bit_for_bit() {
    let world = furnished();
    let plan = Plan::new(TIME_STEP, 60).unwrap().recording_every(7);
    let (loaded, loaded_plan) = (reloaded(&world), reloaded(&plan));
    assert_eq!(loaded_plan, plan);
    let checked = plan.without_stability_check();
    assert_eq!(reloaded(&checked), checked);
    assert_eq!(saved(&loaded), saved(&world));
    let [expected, actual] = [&world, &loaded].map(|world| world.rollout(&loaded_plan).run());
    let expected = expected.unwrap();
    assert_eq!(
        trajectory_bits(&expected),
        trajectory_bits(&actual.unwrap())
    );
    // Shared shapes are shared after loading, too.
    let shapes = loaded.bodies();
    assert!(Arc::ptr_eq(
        shapes[0].shape().compliant().unwrap(),
        shapes[1].shape().compliant().unwrap()
    ));
    let parameters = [Parameter::control("brick", 1), Parameter::mass("ball")];
    let jacobian = |world: &World<f64, Spring>| {
        let outcome = FinalPosition::of_body(world, "brick").unwrap();
        Experiment::new(world, &plan)
            .jacobian(&parameters, &outcome)
            .unwrap()
    };
    let jacobian = [&world, &loaded].map(jacobian);
    assert_eq!(jacobian[0], jacobian[1]);
    assert_eq!(reloaded(&jacobian[0]), jacobian[0]);
    // The same holds from the middle of a rollout.
    let middle = world.with_initial_state(&expected.states()[3]).unwrap();
    let [original, loaded_again] =
        [&middle, &reloaded(&middle)].map(|world| world.rollout(&plan).run());
    assert_eq!(
        trajectory_bits(&original.unwrap()),
        trajectory_bits(&loaded_again.unwrap())
    );
}

/// The change of a saved world, and the error message.
const REFUSED: [(&str, &str, &str); 13] = [
    (
        "\"name\":\"other ball\"",
        "\"name\":\"brick\"",
        "two bodies are named",
    ),
    (
        "\"shape\":2",
        "\"shape\":3",
        "has the shape 3, but there are 3",
    ),
    (
        "\"slip_tolerance\":0.002",
        "\"slip_tolerance\":0.0",
        "slip tolerance",
    ),
    (
        "\"interval\":0.01",
        "\"interval\":-0.01",
        "interval of a control",
    ),
    (
        "\"stiffness\":40.0",
        "\"stiffness\":-40.0",
        "stiffness of a spring",
    ),
    (
        "\"bodies\":[\"ball\",\"brick\"]",
        "\"bodies\":[\"ball\",\"stone\"]",
        "no body is named \"stone\"",
    ),
    ("\"mass\":1.3", "\"mass\":-1.3", "mass"),
    ("\"moments\":[", "\"moments\":[-", "moves no inertia"),
    (
        "\"body\":\"brick\"",
        "\"body\":\"floor\"",
        "fixed or follows a path",
    ),
    (
        "\"ignored\":[[\"ball\"",
        "\"ignored\":[[\"bell\"",
        "no body is named \"bell\"",
    ),
    ("\"tets\":[[", "\"tets\":[[99999,1,2,3],[", "shape 0"),
    ("\"extents\":[", "\"extents\":[1.0,", "shape 0"),
    ("\"gravity\":", "\"weight\":1,\"gravity\":", "unknown field"),
];

#[test]
fn what_is_no_world_is_refused() {
    let text = saved(&furnished());
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        refusal::<World<f64, Spring>>(&text.replacen(from, to, 1))
    };
    for (from, to, reason) in REFUSED {
        let refused = changed(from, to);
        assert!(refused.contains(reason), "{refused}");
    }
}

#[test]
fn loop_joints_are_saved_with_their_world() {
    let link = |name: &str| {
        Body::dynamic(
            name,
            icosphere(0.1, 0),
            Material::elastic(1e5),
            Mass::Total(1.0),
        )
        .unwrap()
    };
    let axis = Unit::new_normalize(vector![1.0, 2.0, 2.0]);
    let frames = [0.1, -0.2].map(|x| Pose::from_translation(vector![x, 0.0, 0.0]));
    let hinge = LoopJoint::new(
        "hinge",
        JointKind::Revolute(axis),
        ("one", frames[0]),
        ("other", frames[1]),
    );
    let world = World::builder()
        .body(link("one"))
        .body(link("other").with_pose(frames[0] * frames[1].inverse()))
        .loop_joint(hinge)
        .build()
        .unwrap();
    let text = saved(&world);
    assert_eq!(saved(&reloaded(&world)), text);
    let open = text.replace("[0.1,0.0,0.0]", "[0.2,0.0,0.0]");
    assert!(refusal::<World>(&open).contains("the frames of loop joint \"hinge\" are"));
    let unknown = text.replace("[\"one\",\"other\"]", "[\"one\",\"another\"]");
    assert!(refusal::<World>(&unknown).contains("no body is named \"another\""));
}

#[test]
fn plans_are_checked_and_paths_are_not_saved() {
    let plan = saved(&Plan::new(0.015, 5).unwrap());
    let refused = refusal::<Plan>(&plan.replace("0.015", "-0.015"));
    assert!(refused.contains("time step"), "{refused}");
    let refused = refusal::<Plan>(&plan.replace("0.002", "-0.002"));
    assert!(refused.contains("tolerance of slopes"), "{refused}");
    let path = Arc::new(|_: f64| BodyState {
        pose: Pose::identity(),
        twist: Twist::zero(),
    });
    let shape = cuboid([1.0; 3]);
    let driven = Body::kinematic("driven", shape, Material::elastic(1e5), path).unwrap();
    let error = serde_json::to_string(&World::new(vec![driven]).unwrap()).unwrap_err();
    assert!(
        error.to_string().contains("\"driven\" follows a path"),
        "{error}"
    );
}
