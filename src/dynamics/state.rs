use super::{JointState, WorldError};
use crate::scalar::{Scalar, lift_vector};
use crate::spatial::{Pose, Twist};
use nalgebra::Vector3;

/// Pose and twist of a body, in the world frame.
#[derive(Debug, Clone, Copy)]
pub struct BodyState<T = f64> {
    /// Pose of the body frame.
    pub pose: Pose<T>,
    /// Spin (rad/s) and velocity of the **center of mass** (m/s), both in world axes.
    pub twist: Twist<T>,
}

/// States of all bodies at one time. Methods of a world that take a state expect the bodies of the world, in the same order.
#[derive(Debug, Clone)]
pub struct State<T = f64> {
    /// Time (s).
    pub time: f64,
    /// Body states, in the order of the bodies of the world.
    pub bodies: Vec<BodyState<T>>,
    /// States of the joints that are neither free nor fixed, in the order of their bodies. Bodies on joints follow them.
    pub joints: Vec<JointState<T>>,
}

impl<T: Scalar> BodyState<T> {
    /// Position (m) of the body's origin.
    #[must_use]
    pub fn position(&self) -> &Vector3<T> {
        self.pose.translation()
    }

    /// Velocity (m/s) of the center of mass.
    #[must_use]
    pub fn velocity(&self) -> &Vector3<T> {
        &self.twist.linear
    }

    /// Whether all components are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let real = self.real();
        let pose = real.pose.rotation().iter().chain(real.pose.translation());
        let twist = real.twist.angular.iter().chain(&real.twist.linear);
        pose.chain(twist).all(|value| value.is_finite())
    }

    /// Checks that the pose is rigid and the twist is finite. Errors name the body.
    pub(super) fn check(&self, body: &str) -> Result<(), WorldError> {
        let pose = self.pose.checked().map(|_| ());
        pose.map_err(|source| WorldError::Pose {
            body: body.to_owned(),
            source,
        })?;
        let twist = self.real().twist;
        for (quantity, vector) in [("velocity", twist.linear), ("spin", twist.angular)] {
            if let Some(&value) = vector.iter().find(|value| !value.is_finite()) {
                return Err(WorldError::Velocity {
                    body: body.to_owned(),
                    quantity,
                    value,
                });
            }
        }
        Ok(())
    }

    /// The state without its derivatives.
    #[must_use]
    pub fn real(&self) -> BodyState<f64> {
        BodyState {
            pose: self.pose.real(),
            twist: self.twist.real(),
        }
    }
}

impl BodyState<f64> {
    /// The state with zero derivatives.
    pub(super) fn lifted<T: Scalar>(&self) -> BodyState<T> {
        BodyState {
            pose: Pose::lifted(&self.pose),
            twist: Twist {
                angular: lift_vector(&self.twist.angular),
                linear: lift_vector(&self.twist.linear),
            },
        }
    }
}

impl<T: Scalar> State<T> {
    /// The state without its derivatives.
    #[must_use]
    pub fn real(&self) -> State<f64> {
        State {
            time: self.time,
            bodies: self.bodies.iter().map(BodyState::real).collect(),
            joints: self.joints.iter().map(JointState::real).collect(),
        }
    }
}

impl State {
    /// The state with zero derivatives.
    pub(crate) fn lifted<T: Scalar>(&self) -> State<T> {
        State {
            time: self.time,
            bodies: self.bodies.iter().map(BodyState::lifted).collect(),
            joints: self.joints.iter().map(JointState::lifted).collect(),
        }
    }
}
