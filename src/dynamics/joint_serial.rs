//! Serde formats of joints, loop joints and the states of joints.

use super::joint::{Joint, JointKind, JointLaw, JointState, Mimic};
use super::{LoopJoint, Schedule};
use crate::spatial::Pose;
use nalgebra::{Matrix3, Unit, Vector3};
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Error as _, Serialize, Serializer};

/// Relative tolerance of the length of a saved axis.
const UNIT: f64 = 1e-12;

/// Saved form of a joint.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Joint", deny_unknown_fields)]
struct JointLayout {
    name: String,
    parent: Option<String>,
    origin: Pose,
    kind: KindLayout,
    law: JointLaw,
    #[serde(default)]
    torques: Option<Schedule>,
    #[serde(default)]
    targets: Option<Schedule>,
    #[serde(default)]
    mimic: Option<Mimic>,
    initial: Option<JointState>,
}

/// Saved form of a kind of joint.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "JointKind")]
enum KindLayout {
    Ball,
    Revolute([f64; 3]),
    Prismatic([f64; 3]),
    Fixed,
}

/// Saved form of a loop joint.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "LoopJoint", deny_unknown_fields)]
struct LoopLayout {
    name: String,
    kind: KindLayout,
    bodies: [String; 2],
    frames: [Pose; 2],
}

/// Saved form of the state of a joint.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "JointState", deny_unknown_fields)]
enum StateLayout {
    Scalar {
        position: f64,
        velocity: f64,
    },
    Ball {
        rotation: [[f64; 3]; 3],
        angular_velocity: [f64; 3],
    },
}

/// Error of a loaded joint.
#[derive(Debug, thiserror::Error)]
enum LoadError {
    #[error("the axis of joint {joint:?} has the length {length}, but must have length 1")]
    Axis { joint: String, length: f64 },
    #[error("a free body has no joint that can be saved")]
    Free,
    #[error("the state of a joint has the number {0}, but all numbers must be finite")]
    State(f64),
}

impl Serialize for Joint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = JointLayout {
            name: self.name.clone(),
            parent: self.parent.clone(),
            origin: self.origin,
            kind: KindLayout::of(&self.kind).map_err(S::Error::custom)?,
            law: self.law,
            torques: self.torques.clone(),
            targets: self.targets.clone(),
            mimic: self.mimic.clone(),
            initial: self.initial_state().copied(),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Joint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = JointLayout::deserialize(deserializer)?;
        layout.joint().map_err(D::Error::custom)
    }
}

impl Serialize for LoopJoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = LoopLayout {
            name: self.name().to_owned(),
            kind: KindLayout::of(self.kind()).map_err(S::Error::custom)?,
            bodies: self.bodies().map(str::to_owned),
            frames: *self.frames(),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for LoopJoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = LoopLayout::deserialize(deserializer)?;
        let kind = layout.kind.kind(&layout.name).map_err(D::Error::custom)?;
        let [first, second] = &layout.bodies;
        let [on_first, on_second] = layout.frames;
        Ok(Self::new(
            &layout.name,
            kind,
            (first, on_first),
            (second, on_second),
        ))
    }
}

impl KindLayout {
    fn of(kind: &JointKind) -> Result<Self, LoadError> {
        Ok(match kind {
            JointKind::Free => return Err(LoadError::Free),
            JointKind::Ball => Self::Ball,
            JointKind::Revolute(axis) => Self::Revolute((**axis).into()),
            JointKind::Prismatic(axis) => Self::Prismatic((**axis).into()),
            JointKind::Fixed => Self::Fixed,
        })
    }

    /// Kind of the joint with this name.
    fn kind(&self, joint: &str) -> Result<JointKind, LoadError> {
        let unit = |axis: [f64; 3]| {
            let axis = Vector3::from(axis);
            let length = axis.norm();
            if (length - 1.0).abs() <= UNIT {
                return Ok(Unit::new_unchecked(axis));
            }
            let joint = joint.to_owned();
            Err(LoadError::Axis { joint, length })
        };
        Ok(match *self {
            Self::Ball => JointKind::Ball,
            Self::Revolute(axis) => JointKind::Revolute(unit(axis)?),
            Self::Prismatic(axis) => JointKind::Prismatic(unit(axis)?),
            Self::Fixed => JointKind::Fixed,
        })
    }
}

impl JointLayout {
    fn joint(self) -> Result<Joint, LoadError> {
        let kind = self.kind.kind(&self.name)?;
        let mut joint = Joint::new(&self.name, kind)
            .with_origin(self.origin)
            .with_law(self.law);
        joint.parent = self.parent;
        (joint.torques, joint.targets) = (self.torques, self.targets);
        joint.mimic = self.mimic;
        if let Some(initial) = self.initial {
            joint.initial = initial;
        }
        Ok(joint)
    }
}

impl Serialize for JointState {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = match *self {
            Self::Scalar { position, velocity } => StateLayout::Scalar { position, velocity },
            Self::Ball {
                rotation,
                angular_velocity,
            } => StateLayout::Ball {
                rotation: rotation.into(),
                angular_velocity: angular_velocity.into(),
            },
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for JointState {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (state, numbers) = match StateLayout::deserialize(deserializer)? {
            StateLayout::Scalar { position, velocity } => (
                Self::Scalar { position, velocity },
                vec![position, velocity],
            ),
            StateLayout::Ball {
                rotation,
                angular_velocity,
            } => {
                let rotation = Matrix3::from(rotation);
                let angular_velocity = Vector3::from(angular_velocity);
                let numbers = rotation.iter().chain(&angular_velocity).copied();
                let numbers = numbers.collect();
                (
                    Self::Ball {
                        rotation,
                        angular_velocity,
                    },
                    numbers,
                )
            }
        };
        match numbers.into_iter().find(|number| !number.is_finite()) {
            Some(number) => Err(D::Error::custom(LoadError::State(number))),
            None => Ok(state),
        }
    }
}
