//! Serde formats of plans, states, materials and trajectories.

use super::plan::SOLVER_TOLERANCE;
use super::{
    Accuracy, BodyState, Integrator, JointState, Material, Plan, State, Trajectory, WorldError,
};
use crate::spatial::{Pose, Twist};
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};
use std::borrow::Cow;

/// Saved form of a plan.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Plan", deny_unknown_fields)]
struct PlanLayout {
    time_step: f64,
    steps: usize,
    integrator: Integrator,
    record_every: usize,
    #[serde(default = "checks_stability")]
    checks_stability: bool,
    #[serde(default = "solver_tolerance")]
    solver_tolerance: f64,
    #[serde(default)]
    accuracy: Accuracy,
}

/// Saved form of an accuracy.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Accuracy", deny_unknown_fields)]
pub(super) struct AccuracyLayout {
    values: f64,
    slopes: f64,
    resting_speed: Option<f64>,
}

/// Default for plans that were saved without a solver tolerance.
fn solver_tolerance() -> f64 {
    SOLVER_TOLERANCE
}

/// Default for plans that were saved without this field.
fn checks_stability() -> bool {
    true
}

/// Saved form of a body state.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "BodyState", deny_unknown_fields)]
struct BodyStateLayout {
    pose: Pose,
    twist: Twist,
}

/// Saved form of a state.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "State", deny_unknown_fields)]
struct StateLayout<'a> {
    time: f64,
    bodies: Cow<'a, [BodyState]>,
    #[serde(default)]
    joints: Cow<'a, [JointState]>,
}

/// Saved form of a material.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Material", deny_unknown_fields)]
struct MaterialLayout {
    /// `None` for a rigid body.
    modulus: Option<f64>,
    dissipation: f64,
    /// `None` takes the friction of the partner.
    friction: Option<f64>,
}

/// Saved form of a trajectory.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Trajectory", deny_unknown_fields)]
struct TrajectoryLayout<'a> {
    states: Cow<'a, [State]>,
}

/// Error of a loaded state or material.
#[derive(Debug, thiserror::Error)]
enum LoadError {
    #[error("the time of a state is {0} s, but must be finite")]
    Time(f64),
    #[error(
        "the {quantity} of a material is {value}: a modulus must be positive, dissipation and friction not negative, and all finite"
    )]
    Material { quantity: &'static str, value: f64 },
}

impl Serialize for Plan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = PlanLayout {
            time_step: self.time_step(),
            steps: self.steps(),
            integrator: self.integrator(),
            // Zero means that only the ends are recorded. Unlike `usize::MAX`, zero does not depend
            // on the word size of the machine.
            record_every: match self.record_every() {
                usize::MAX => 0,
                every => every,
            },
            checks_stability: self.checks_stability(),
            solver_tolerance: self.solver_tolerance(),
            accuracy: self.accuracy(),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Plan {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = PlanLayout::deserialize(deserializer)?;
        let plan = Plan::new(layout.time_step, layout.steps).map_err(D::Error::custom)?;
        let plan = plan
            .with_integrator(layout.integrator)
            .with_accuracy(layout.accuracy);
        let plan = plan.recording_every(layout.record_every);
        let plan = plan.with_solver_tolerance(layout.solver_tolerance);
        let plan = plan.map_err(D::Error::custom)?;
        Ok(if layout.checks_stability {
            plan
        } else {
            plan.without_stability_check()
        })
    }
}

impl From<Accuracy> for AccuracyLayout {
    fn from(accuracy: Accuracy) -> Self {
        Self {
            values: accuracy.values(),
            slopes: accuracy.slopes(),
            resting_speed: accuracy.resting_speed(),
        }
    }
}

impl TryFrom<AccuracyLayout> for Accuracy {
    type Error = WorldError;

    fn try_from(layout: AccuracyLayout) -> Result<Self, WorldError> {
        let accuracy = Self::new(layout.values, layout.slopes)?;
        layout
            .resting_speed
            .map_or(Ok(accuracy), |speed| accuracy.with_resting_speed(speed))
    }
}

impl Serialize for BodyState {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { pose, twist } = *self;
        BodyStateLayout { pose, twist }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for BodyState {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let BodyStateLayout { pose, twist } = BodyStateLayout::deserialize(deserializer)?;
        Ok(Self { pose, twist })
    }
}

impl Serialize for State {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = StateLayout {
            time: self.time,
            bodies: Cow::Borrowed(&self.bodies),
            joints: Cow::Borrowed(&self.joints),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for State {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StateLayout {
            time,
            bodies,
            joints,
        } = StateLayout::deserialize(deserializer)?;
        if !time.is_finite() {
            return Err(D::Error::custom(LoadError::Time(time)));
        }
        Ok(Self {
            time,
            bodies: bodies.into_owned(),
            joints: joints.into_owned(),
        })
    }
}

impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = MaterialLayout {
            modulus: self.modulus,
            dissipation: self.dissipation,
            friction: self.friction,
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Material {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = MaterialLayout::deserialize(deserializer)?;
        let material = Self {
            modulus: layout.modulus,
            dissipation: layout.dissipation,
            friction: layout.friction,
        };
        match material.number_out_of_range() {
            None => Ok(material),
            Some((quantity, value)) => {
                Err(D::Error::custom(LoadError::Material { quantity, value }))
            }
        }
    }
}

impl Serialize for Trajectory {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let states = Cow::Borrowed(self.states());
        TrajectoryLayout { states }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Trajectory {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let TrajectoryLayout { states } = TrajectoryLayout::deserialize(deserializer)?;
        Self::new(states.into_owned()).map_err(D::Error::custom)
    }
}
