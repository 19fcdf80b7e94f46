//! Poses, states, materials, trajectories, plans and whole worlds, saved and loaded by serde.
#![cfg(feature = "serde")]

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Body, BodyState, Control, Integrator, Mass, Material, Plan, Spring, State, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Matrix3, Vector3, vector};
use proptest::prelude::*;
use serde::Serialize;
use serde::de::value::{Error, MapDeserializer, SeqDeserializer};
use serde::de::{Deserialize, DeserializeOwned, Deserializer, IntoDeserializer, Visitor};
use std::sync::Arc;

/// A power of two, so that times are exact and a rollout may stop and go on between any two steps.
const TIME_STEP: f64 = 1.0 / 1024.0;

/// Rotations of a rollout are orthonormal to this; loading keeps the bits up to ten times as much.
const ORTHONORMAL: f64 = 1e-15;

fn saved(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap()
}

fn reloaded<V: Serialize + DeserializeOwned>(value: &V) -> V {
    serde_json::from_str(&saved(value)).unwrap()
}

/// Why the text is none of these.
fn refusal<V: DeserializeOwned>(text: &str) -> String {
    match serde_json::from_str::<V>(text) {
        Ok(_) => panic!("{text} was accepted"),
        Err(error) => error.to_string(),
    }
}

fn pose_bits(pose: &Pose) -> Vec<u64> {
    let numbers = pose.rotation().iter().chain(pose.translation());
    numbers.map(|number| number.to_bits()).collect()
}

fn twist_bits(twist: &Twist) -> Vec<u64> {
    let numbers = twist.angular.iter().chain(&twist.linear);
    numbers.map(|number| number.to_bits()).collect()
}

fn state_bits(state: &State) -> Vec<u64> {
    let of_body = |body: &BodyState| [pose_bits(&body.pose), twist_bits(&body.twist)].concat();
    let bodies = state.bodies.iter().flat_map(of_body);
    std::iter::once(state.time.to_bits())
        .chain(bodies)
        .collect()
}

fn trajectory_bits(trajectory: &Trajectory) -> Vec<Vec<u64>> {
    trajectory.states().iter().map(state_bits).collect()
}

/// A spinning block on a tilted floor that rubs, and a paddle on a path.
fn world() -> World {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.2)
        .with_friction(0.4);
    let block = Arc::new(Shape::new(shapes::cuboid([0.2, 0.15, 0.1]).unwrap()));
    let slab = Shape::new(shapes::cuboid([1.0, 1.0, 0.2]).unwrap());
    let path = |time: f64| BodyState {
        pose: Pose::from_rotation_vector(&vector![0.0, time, 0.0], vector![0.3, time, 0.5]),
        twist: Twist {
            angular: vector![0.0, 1.0, 0.0],
            linear: vector![0.0, 1.0, 0.0],
        },
    };
    let start = Pose::from_rotation_vector(&vector![0.3, 2.0, 0.1], vector![0.1, 0.0, 0.24]);
    let tilt = Pose::from_rotation_vector(&vector![0.1, 0.0, 0.0], Vector3::zeros());
    let world = World::new(vec![
        Body::dynamic("block", Arc::clone(&block), skin, Mass::Total(1.0))
            .unwrap()
            .at(start)
            .with_velocity(vector![1e-9, -0.1, 0.0])
            .with_spin(vector![1.0, 9.0, -3.0]),
        Body::fixed("floor", slab, skin).unwrap().at(tilt),
        Body::prescribed("paddle", block, skin, Arc::new(path)).unwrap(),
    ]);
    let world = world.unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

fn trajectory(integrator: Integrator) -> Trajectory {
    let world = world();
    let plan = Plan::new(TIME_STEP, 600).unwrap();
    let rollout = world.rollout(&plan.with_integrator(integrator));
    rollout.recorded().unwrap()
}

// Numbers come back as they were.

#[test]
fn the_layout_is_rows_and_names() {
    let rotation = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let pose = Pose::new(rotation, vector![1.0, 2.5, -0.0]).unwrap();
    let pose_text =
        r#"{"rotation":[[0.0,-1.0,0.0],[1.0,0.0,0.0],[0.0,0.0,1.0]],"translation":[1.0,2.5,-0.0]}"#;
    assert_eq!(saved(&pose), pose_text);
    let twist = Twist {
        angular: vector![1.0, 2.0, 3.0],
        linear: vector![4.0, 5.0, 6.0],
    };
    let twist_text = r#"{"angular":[1.0,2.0,3.0],"linear":[4.0,5.0,6.0]}"#;
    assert_eq!(saved(&twist), twist_text);
    let state = State {
        time: 0.5,
        bodies: vec![BodyState { pose, twist }],
    };
    let state_text =
        format!(r#"{{"time":0.5,"bodies":[{{"pose":{pose_text},"twist":{twist_text}}}]}}"#);
    assert_eq!(saved(&state), state_text);
    let trajectory_text = format!(r#"{{"states":[{state_text},{state_text}]}}"#);
    let trajectory: Trajectory = serde_json::from_str(&trajectory_text).unwrap();
    assert_eq!(saved(&trajectory), trajectory_text);
    let skin = Material::elastic(1e5)
        .with_dissipation(0.25)
        .with_friction(0.5);
    assert_eq!(
        saved(&skin),
        r#"{"modulus":100000.0,"dissipation":0.25,"friction":0.5}"#
    );
}

#[test]
fn a_trajectory_comes_back_bit_for_bit() {
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        let trajectory = trajectory(integrator);
        let loaded = reloaded(&trajectory);
        assert_eq!(trajectory_bits(&loaded), trajectory_bits(&trajectory));
        assert_eq!(state_bits(loaded.last()), state_bits(trajectory.last()));
    }
}

#[test]
fn a_rollout_goes_on_from_a_loaded_state_with_the_same_bits() {
    let world = world();
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        let plan = Plan::new(TIME_STEP, 600)
            .unwrap()
            .with_integrator(integrator);
        let uninterrupted = trajectory_bits(&trajectory(integrator));
        for stop in [0, 1, 137, 400] {
            let first = world.rollout(&plan.with_steps(stop)).recorded().unwrap();
            let loaded = reloaded(first.last());
            let rest = world.rollout(&plan.with_steps(600 - stop));
            let rest = rest.starting_from(loaded).unwrap();
            let rest = rest.recorded().unwrap();
            assert_eq!(trajectory_bits(&rest), uninterrupted[stop..]);
        }
    }
}

#[test]
fn rotations_of_a_rollout_are_a_tenth_of_what_loading_keeps() {
    let trajectory = trajectory(Integrator::Leapfrog);
    let bodies = trajectory.states().iter().flat_map(|state| &state.bodies);
    let deviations = bodies.map(|body| {
        let rotation = body.pose.rotation();
        (rotation.transpose() * rotation - Matrix3::identity()).amax()
    });
    let largest = deviations.fold(0.0, f64::max);
    assert!(largest > 0.0 && largest <= ORTHONORMAL, "{largest:e}");
}

#[test]
fn a_rotation_further_off_is_put_right_as_by_the_constructor() {
    let mut rotation = Matrix3::identity();
    rotation[(0, 1)] = 1e-10;
    let expected = Pose::new(rotation, Vector3::zeros()).unwrap();
    let text = r#"{"rotation":[[1,1e-10,0],[0,1,0],[0,0,1]],"translation":[0,0,0]}"#;
    let loaded: Pose = serde_json::from_str(text).unwrap();
    assert_eq!(pose_bits(&loaded), pose_bits(&expected));
    assert!((loaded.rotation()[(0, 1)] - 0.5e-10).abs() <= 1e-20);
}

proptest! {
    #[test]
    fn poses_twists_and_materials_come_back_bit_for_bit(
        numbers in prop::array::uniform9(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO),
        turn in prop::array::uniform3(-10.0..10.0),
    ) {
        let [x, y, z, a, b, c, d, e, f] = numbers;
        let pose = Pose::from_rotation_vector(&Vector3::from(turn), vector![x, y, z]);
        prop_assert_eq!(pose_bits(&reloaded(&pose)), pose_bits(&pose));
        let twist = Twist { angular: vector![a, b, c], linear: vector![d, e, f] };
        prop_assert_eq!(twist_bits(&reloaded(&twist)), twist_bits(&twist));
        let skin = Material { modulus: a.abs().max(f64::MIN_POSITIVE), dissipation: b.abs(), friction: c.abs() };
        let bits = |skin: &Material| [skin.modulus, skin.dissipation, skin.friction].map(f64::to_bits);
        prop_assert_eq!(bits(&reloaded(&skin)), bits(&skin));
    }
}

// Nothing invalid comes in.

const UPRIGHT: &str = r#""rotation":[[1,0,0],[0,1,0],[0,0,1]]"#;

#[test]
fn what_is_no_rotation_is_no_pose() {
    for (rotation, deviation) in [
        ("[[1,0,0],[0,1,0],[0,0,-1]]", "2e0"),
        ("[[0,0,0],[0,0,0],[0,0,0]]", "1e0"),
        ("[[1,0.125,0],[0,1,0],[0,0,1]]", "1.25e-1"),
    ] {
        let text = format!(r#"{{"rotation":{rotation},"translation":[0,0,0]}}"#);
        let expected = format!(
            "a rotation must be orthonormal with determinant 1 to 1e-9, but the matrix is {deviation} away from it"
        );
        assert!(refusal::<Pose>(&text).starts_with(&expected), "{text}");
        // As part of something larger too.
        let body = format!(r#"{{"pose":{text},"twist":{{"angular":[0,0,0],"linear":[0,0,0]}}}}"#);
        let states = format!(r#"{{"states":[{{"time":0,"bodies":[{body}]}}]}}"#);
        assert!(refusal::<Trajectory>(&states).starts_with(&expected));
    }
}

#[test]
fn missing_unknown_and_misshapen_fields_are_named() {
    for (text, expected) in [
        (format!("{{{UPRIGHT}}}"), "missing field `translation`"),
        (
            format!(r#"{{{UPRIGHT},"translation":[0,0]}}"#),
            "invalid length 2",
        ),
        (
            format!(r#"{{{UPRIGHT},"translation":[0,0,null]}}"#),
            "invalid type: null",
        ),
        (
            format!(r#"{{{UPRIGHT},"translation":[0,0,1e999]}}"#),
            "number out of range",
        ),
        (
            format!(r#"{{{UPRIGHT},"translation":[0,0,0],"scale":2}}"#),
            "unknown field `scale`",
        ),
    ] {
        let message = refusal::<Pose>(&text);
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn materials_out_of_range_are_refused() {
    for (text, expected) in [
        (
            r#"{"modulus":0,"dissipation":0,"friction":0}"#,
            "the hydroelastic modulus of a material is 0: a modulus must be positive, dissipation and friction not negative, and all finite",
        ),
        (
            r#"{"modulus":1,"dissipation":-0.5,"friction":0}"#,
            "the dissipation of a material is -0.5: ",
        ),
        (
            r#"{"modulus":1,"dissipation":0,"friction":-1}"#,
            "the friction of a material is -1: ",
        ),
        (
            r#"{"modulus":1,"friction":0}"#,
            "missing field `dissipation`",
        ),
    ] {
        let message = refusal::<Material>(text);
        assert!(message.starts_with(expected), "{message}");
    }
}

/// The states of so many bodies at these times, as a trajectory.
fn sequence(states: &[(f64, usize)]) -> String {
    let body = format!(
        r#"{{"pose":{{{UPRIGHT},"translation":[0,0,0]}},"twist":{{"angular":[0,0,0],"linear":[0,0,0]}}}}"#
    );
    let state = |(time, count): &(f64, usize)| {
        let bodies = vec![body.as_str(); *count].join(",");
        format!(r#"{{"time":{time},"bodies":[{bodies}]}}"#)
    };
    let states: Vec<String> = states.iter().map(state).collect();
    format!(r#"{{"states":[{}]}}"#, states.join(","))
}

#[test]
fn a_trajectory_has_a_state_and_the_same_bodies_in_each_in_the_order_of_time() {
    for (text, expected) in [
        (sequence(&[]), "a trajectory needs at least one state"),
        (
            sequence(&[(0.0, 2), (0.5, 2), (1.0, 1)]),
            "state 2 of a trajectory has 1 bodies, but the first has 2",
        ),
        (
            sequence(&[(0.0, 1), (0.5, 1), (0.25, 1)]),
            "state 2 of a trajectory is at 0.25 s, but the one before it at 0.5 s",
        ),
    ] {
        let message = refusal::<Trajectory>(&text);
        assert!(message.starts_with(expected), "{message}");
    }
    let loaded: Trajectory = serde_json::from_str(&sequence(&[(0.5, 1), (2.0, 1)])).unwrap();
    assert_eq!(loaded.last().time.to_bits(), 2.0_f64.to_bits());
}

/// What JSON cannot hold and other formats can: numbers that are not finite.
#[derive(Clone)]
enum Value {
    Number(f64),
    List(Vec<Value>),
    Fields(Vec<(&'static str, Value)>),
}

impl IntoDeserializer<'_> for Value {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Value {
    type Error = Error;
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Self::Number(number) => visitor.visit_f64(number),
            Self::List(values) => SeqDeserializer::new(values.into_iter()).deserialize_any(visitor),
            Self::Fields(fields) => {
                MapDeserializer::new(fields.into_iter()).deserialize_any(visitor)
            }
        }
    }
    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

fn list(numbers: [f64; 3]) -> Value {
    Value::List(numbers.map(Value::Number).to_vec())
}

/// A state whose numbers have the bad one at a place.
fn state_value(place: &str, bad: f64) -> Value {
    let at = |name: &str, good: f64| if name == place { bad } else { good };
    let rotation = vec![
        list([1.0, at("rotation", 0.0), 0.0]),
        list([0.0, 1.0, 0.0]),
        list([0.0, 0.0, 1.0]),
    ];
    let pose = Value::Fields(vec![
        ("rotation", Value::List(rotation)),
        ("translation", list([0.0, at("translation", 0.0), 0.0])),
    ]);
    let twist = Value::Fields(vec![
        ("angular", list([at("angular", 0.0), 0.0, 0.0])),
        ("linear", list([0.0, 0.0, at("linear", 0.0)])),
    ]);
    let body = Value::Fields(vec![("pose", pose), ("twist", twist)]);
    Value::Fields(vec![
        ("time", Value::Number(at("time", 0.0))),
        ("bodies", Value::List(vec![body])),
    ])
}

#[test]
fn numbers_that_are_not_finite_are_refused_in_any_format() {
    State::deserialize(state_value("nowhere", 0.0)).unwrap();
    let pose = "a pose must be finite, but a component of its rotation or translation is";
    let twist = |part| format!("a twist must be finite, but a component of its {part} part is");
    for (bad, name) in [
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (f64::NEG_INFINITY, "-inf"),
    ] {
        for (place, expected) in [
            ("rotation", format!("{pose} {name}")),
            ("translation", format!("{pose} {name}")),
            ("angular", format!("{} {name}", twist("angular"))),
            ("linear", format!("{} {name}", twist("linear"))),
            (
                "time",
                format!("the time of a state is {name} s, but must be finite"),
            ),
        ] {
            let error = State::deserialize(state_value(place, bad)).unwrap_err();
            assert_eq!(error.to_string(), expected);
        }
        let skin = Value::Fields(vec![
            ("modulus", Value::Number(bad)),
            ("dissipation", Value::Number(0.0)),
            ("friction", Value::Number(0.0)),
        ]);
        let error = Material::deserialize(skin).unwrap_err();
        let expected = format!("the hydroelastic modulus of a material is {name}: ");
        assert!(error.to_string().starts_with(&expected), "{error}");
    }
}

/// A ball and a brick of one material on a floor, with a spring, a control and an ignored pair.
fn furnished() -> World<f64, Spring> {
    let skin = Material::elastic(1e5)
        .with_friction(0.4)
        .with_dissipation(0.2);
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()));
    let brick = Shape::new(shapes::cuboid([0.1, 0.2, 0.3]).unwrap());
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.2]).unwrap());
    let at = |body: Body, x: f64, z: f64| {
        let turn = vector![0.1, x, -0.2];
        body.at(Pose::from_rotation_vector(&turn, vector![x, 0.0, z]))
    };
    let dynamic = |name, shape: Arc<Shape>| Body::dynamic(name, shape, skin, Mass::Total(1.3));
    let spring = Spring {
        bodies: ["ball".into(), "brick".into()],
        points: [[0.0; 3], [0.01, 0.02, 0.1]],
        rest_length: 0.3,
        stiffness: 40.0,
        damping: 0.1,
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
        Body::fixed("floor", floor, skin).unwrap(),
    ])
    .and_then(|world| world.with_gravity(vector![0.1, 0.0, -9.81]))
    .and_then(|world| world.with_slip_tolerance(2e-3))
    .and_then(|world| world.ignoring("ball", "other ball"))
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
    let checked = plan.with_stability_check(30);
    assert_eq!(reloaded(&checked), checked);
    assert_eq!(saved(&loaded), saved(&world));
    let [expected, found] = [&world, &loaded].map(|it| it.rollout(&loaded_plan).recorded());
    let expected = expected.unwrap();
    assert_eq!(trajectory_bits(&expected), trajectory_bits(&found.unwrap()));
    // Shapes that were shared are shared again.
    let shapes = loaded.bodies();
    assert!(Arc::ptr_eq(shapes[0].shape(), shapes[1].shape()));
    let parameters = [
        Parameter::Control("brick".into(), 1),
        Parameter::Mass("ball".into()),
    ];
    let jacobian = |world: &World<f64, Spring>| {
        let outcome = FinalPosition::of_body(world, "brick").unwrap();
        Experiment::new(world, &plan)
            .jacobian(&parameters, &outcome)
            .unwrap()
    };
    let jacobian = [&world, &loaded].map(jacobian);
    assert_eq!(jacobian[0], jacobian[1]);
    assert_eq!(reloaded(&jacobian[0]), jacobian[0]);
    // From the middle of a rollout too.
    let middle = world.starting_from(&expected.states()[3]).unwrap();
    let [one, other] = [&middle, &reloaded(&middle)].map(|it| it.rollout(&plan).recorded());
    assert_eq!(
        trajectory_bits(&one.unwrap()),
        trajectory_bits(&other.unwrap())
    );
}

/// What is changed in a saved world, and what is said of it.
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
    ("\"moments\":[", "\"moments\":[-", "inertia of body"),
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
fn plans_are_checked_and_paths_are_not_saved() {
    let plan = saved(&Plan::new(1e-3, 5).unwrap());
    let refused = refusal::<Plan>(&plan.replace("0.001", "-0.001"));
    assert!(refused.contains("time step"), "{refused}");
    let path = Arc::new(|_: f64| BodyState {
        pose: Pose::identity(),
        twist: Twist::zero(),
    });
    let shape = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
    let driven = Body::prescribed("driven", shape, Material::elastic(1e5), path).unwrap();
    let error = serde_json::to_string(&World::new(vec![driven]).unwrap()).unwrap_err();
    assert!(
        error.to_string().contains("\"driven\" follows a path"),
        "{error}"
    );
}
