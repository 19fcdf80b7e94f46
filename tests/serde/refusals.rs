//! Invalid poses, materials, states and trajectories are rejected when they are loaded.

use crate::text_and_bits::refusal;
use hydroelastic::dynamics::{Material, State, Trajectory};
use hydroelastic::spatial::Pose;
use serde::de::value::{Error, MapDeserializer, SeqDeserializer};
use serde::de::{Deserialize, Deserializer, IntoDeserializer, Visitor};

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
        // The same holds inside a larger value.
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

/// Returns a trajectory of states at these times with these numbers of bodies.
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

/// Numbers that are not finite, which other formats can store and JSON cannot.
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

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

fn list(numbers: [f64; 3]) -> Value {
    Value::List(numbers.map(Value::Number).to_vec())
}

/// Returns a state with the bad number in a field.
fn state_value(field: &str, bad: f64) -> Value {
    let at = |name: &str, good: f64| if name == field { bad } else { good };
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
        for (field, expected) in [
            ("rotation", format!("{pose} {name}")),
            ("translation", format!("{pose} {name}")),
            ("angular", format!("{} {name}", twist("angular"))),
            ("linear", format!("{} {name}", twist("linear"))),
            (
                "time",
                format!("the time of a state is {name} s, but must be finite"),
            ),
        ] {
            let error = State::deserialize(state_value(field, bad)).unwrap_err();
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
