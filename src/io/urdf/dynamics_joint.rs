//! Conversion of the joints of a robot to joints of the dynamics.

use super::UrdfError;
use super::joint::{Joint, JointKind};
use crate::dynamics;

/// Options of [`Joint::dynamics_joint`]. URDF files have neither a law of stops nor a slip tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointOptions {
    /// Law of the stops of revolute joints, or `None` for no stops. The default is 1,000 N m/rad and 1 s/rad.
    pub revolute_stops: Option<StopLaw>,
    /// Law of the stops of prismatic joints, or `None` for no stops. The default is 100,000 N/m and 10 s/m.
    pub prismatic_stops: Option<StopLaw>,
    /// Velocity (rad/s or m/s) at which joint friction has 71 % of its value. The default is 1e-3.
    /// See [`dynamics::Joint::with_friction`].
    pub slip_tolerance: f64,
}

/// Law of a stop: see [`dynamics::Stops`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopLaw {
    /// Stiffness (N m/rad or N/m).
    pub stiffness: f64,
    /// Dissipation (s/rad or s/m).
    pub dissipation: f64,
}

impl Default for JointOptions {
    fn default() -> Self {
        Self {
            revolute_stops: Some(StopLaw {
                stiffness: 1e3,
                dissipation: 1.0,
            }),
            prismatic_stops: Some(StopLaw {
                stiffness: 1e5,
                dissipation: 10.0,
            }),
            slip_tolerance: 1e-3,
        }
    }
}

impl Joint {
    /// Converts the joint to a joint of the dynamics. The name of its parent body is the name of the parent link.
    ///
    /// The result has the origin, the damping and the friction of this joint. A revolute or prismatic joint with a range has stops. The
    /// largest effort limits the torque of the actuator. An effort of zero is ignored, because many files write zero for an unknown effort.
    /// The largest velocity is ignored.
    ///
    /// # Errors
    /// If the joint is floating or planar.
    pub fn dynamics_joint(&self, options: &JointOptions) -> Result<dynamics::Joint, UrdfError> {
        self.prefixed("", options)
    }

    /// [`Self::dynamics_joint`] with a prefix before the names of the joint, the leader and the parent body.
    pub(super) fn prefixed(
        &self,
        prefix: &str,
        options: &JointOptions,
    ) -> Result<dynamics::Joint, UrdfError> {
        let [name, parent] = [&self.name, &self.parent].map(|name| format!("{prefix}{name}"));
        let name = name.as_str();
        let (joint, stop_law) = match self.kind {
            JointKind::Fixed => (dynamics::Joint::fixed(name), None),
            JointKind::Continuous(axis) => (dynamics::Joint::revolute(name, axis), None),
            JointKind::Revolute(axis) => (
                dynamics::Joint::revolute(name, axis),
                options.revolute_stops,
            ),
            JointKind::Prismatic(axis) => (
                dynamics::Joint::prismatic(name, axis),
                options.prismatic_stops,
            ),
            JointKind::Floating | JointKind::Planar(_) => {
                return Err(UrdfError::UnsupportedJoint {
                    at: self.at.clone(),
                    found: self.kind.name(),
                });
            }
        };
        let mut joint = joint
            .with_parent(&parent)
            .with_origin(self.origin)
            .with_damping(self.damping)
            .with_friction(self.friction, options.slip_tolerance);
        if let Some(stops) = stop_law.and_then(|law| self.stops(law)) {
            joint = joint.with_stops(stops);
        }
        if let Some(mimic) = &self.mimic {
            let leader = format!("{prefix}{}", mimic.joint);
            joint = joint.with_mimic(&leader, mimic.multiplier, mimic.offset);
        }
        let effort = self.limit.and_then(|limit| limit.effort);
        if let Some(effort) = effort.filter(|&effort| effort > 0.0 && effort.is_finite()) {
            joint = joint.with_torque_limit(effort);
        }
        Ok(joint)
    }

    /// Stops at the ends of the range, or `None` if the range is missing or both ends are infinite.
    fn stops(&self, law: StopLaw) -> Option<dynamics::Stops> {
        let range = self.limit?.range?;
        let finite = range.map(|end| end.clamp(f64::MIN, f64::MAX));
        let stops = dynamics::Stops::new(finite, law.stiffness, law.dissipation);
        let is_limited = range.iter().any(|end| end.is_finite());
        is_limited.then_some(stops)
    }
}
