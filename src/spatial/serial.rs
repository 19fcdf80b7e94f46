//! Serialization of poses and twists with serde.

use super::{Pose, PoseError, Twist};
use nalgebra::{Matrix3, RowVector3};
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

/// Serialized form of a pose.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Pose", deny_unknown_fields)]
struct PoseLayout {
    /// Rows of the matrix.
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

/// Serialized form of a twist.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Twist", deny_unknown_fields)]
struct TwistLayout {
    angular: [f64; 3],
    linear: [f64; 3],
}

/// Error for a loaded twist that is not finite.
#[derive(Debug, thiserror::Error)]
#[error("a twist must be finite, but a component of its {part} part is {value}")]
struct TwistNotFinite {
    part: &'static str,
    value: f64,
}

impl Serialize for Pose {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows = self.rotation().transpose();
        let layout = PoseLayout {
            rotation: rows.into(),
            translation: (*self.translation()).into(),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Pose {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = PoseLayout::deserialize(deserializer)?;
        layout.pose().map_err(D::Error::custom)
    }
}

impl PoseLayout {
    /// Checks the numbers and returns the pose.
    fn pose(self) -> Result<Pose, PoseError> {
        let rotation = Matrix3::from_rows(&self.rotation.map(RowVector3::from));
        Pose::restored(rotation, self.translation.into())
    }
}

impl Serialize for Twist {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let layout = TwistLayout {
            angular: self.angular.into(),
            linear: self.linear.into(),
        };
        layout.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Twist {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = TwistLayout::deserialize(deserializer)?;
        layout.twist().map_err(D::Error::custom)
    }
}

impl TwistLayout {
    fn twist(self) -> Result<Twist, TwistNotFinite> {
        for (part, vector) in [("angular", self.angular), ("linear", self.linear)] {
            if let Some(value) = vector.into_iter().find(|value| !value.is_finite()) {
                return Err(TwistNotFinite { part, value });
            }
        }
        Ok(Twist {
            angular: self.angular.into(),
            linear: self.linear.into(),
        })
    }
}
