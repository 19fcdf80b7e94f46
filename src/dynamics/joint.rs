//! Joints between bodies.

use super::{Schedule, WorldError};
use crate::contact::SLIP_TOLERANCES;
use crate::scalar::{DenseDual, Scalar, lift, real_part};
use crate::spatial::{Pose, turned_by};
use nalgebra::{Matrix3, UnitVector3, Vector3};

/// Largest error of the length of an axis.
const UNIT: f64 = 1e-12;

/// Slip tolerance (rad/s or m/s) of a new joint.
const SLIP_TOLERANCE: f64 = 1e-3;

/// Motions that a joint allows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum JointKind {
    /// All motions in the world. A free body has no parent.
    Free,
    /// Rotation about the origin of the joint frame.
    Ball,
    /// Rotation about an axis through the origin of the joint frame.
    Revolute(UnitVector3<f64>),
    /// Translation along an axis of the joint frame.
    Prismatic(UnitVector3<f64>),
    /// No motion: the body is welded to its parent.
    Fixed,
}

/// Connection of a dynamic body to its parent: another body, or the world.
///
/// [`Self::with_origin`] sets the pose of the joint frame in the body frame of the parent. At position zero, the joint frame coincides with
/// the body frame. A body without a joint is free.
///
/// ```
/// use hydroelastic::dynamics::Joint;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::Vector3;
///
/// let elbow = Joint::revolute("elbow", Vector3::y_axis())
///     .with_parent("upper arm")
///     .with_origin(Pose::from_translation(Vector3::new(0.0, 0.0, 0.4)))
///     .with_damping(0.1)
///     .with_position(0.5);
/// assert_eq!(elbow.name(), "elbow");
/// ```
#[derive(Debug, Clone)]
pub struct Joint<T = f64> {
    pub(super) name: String,
    /// Name of the parent body, or `None` for the world.
    pub(super) parent: Option<String>,
    pub(super) origin: Pose,
    pub(super) kind: JointKind,
    pub(crate) law: JointLaw<T>,
    /// Schedule of torques that are added to the torque of the law.
    pub(crate) torques: Option<Schedule<T>>,
    /// Schedule of target positions, which replace the target of the law.
    pub(crate) targets: Option<Schedule<T>>,
    pub(super) mimic: Option<Mimic>,
    pub(crate) initial: JointState<T>,
}

/// Proportional motion of a revolute or prismatic joint and its leader, as in a gear: position = multiplier · leader position + offset.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Mimic {
    /// Name of the leader.
    pub joint: String,
    /// Multiplier of the position of the leader.
    pub multiplier: f64,
    /// Offset (rad or m).
    pub offset: f64,
}

/// Forces of a revolute or prismatic joint, and its armature. The units are written for a revolute joint. For a prismatic joint, replace
/// rad by m, N m by N, and kg m² by kg.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointLaw<T = f64> {
    /// Reflected inertia of the rotor (kg m²): the rotor inertia times the square of the gear ratio.
    pub armature: T,
    /// Viscous damping (N m s/rad).
    pub damping: T,
    /// Coulomb friction (N m).
    pub friction: T,
    /// Velocity (rad/s) at which friction has 71 % of its value: see [`Joint::with_friction`].
    pub slip_tolerance: f64,
    /// Stops, or `None` for a joint without limits.
    pub stops: Option<Stops>,
    /// Actuator.
    pub actuator: Actuator<T>,
}

/// Actuator of a joint: a torque plus a proportional–derivative servo.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Actuator<T = f64> {
    /// Torque (N m).
    pub torque: T,
    /// Stiffness of the servo (N m/rad).
    pub stiffness: T,
    /// Damping of the servo (N m s/rad).
    pub damping: T,
    /// Target position (rad) at the target time.
    pub target_position: T,
    /// Velocity of the target (rad/s). The target position changes at this rate.
    pub target_velocity: T,
    /// Time (s) at which the target is at the target position.
    #[cfg_attr(feature = "serde", serde(default))]
    pub target_time: f64,
    /// Largest magnitude of the torque of the actuator (N m), or `None` without a limit.
    pub limit: Option<f64>,
}

/// Compliant stops at the ends of the range of a joint. The force of a stop at the depth d beyond the range is k·d·max(0, 1 + c·ḋ).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Stops {
    /// Smallest and largest position (rad).
    pub range: [f64; 2],
    /// Stiffness k (N m/rad).
    pub stiffness: f64,
    /// Dissipation c (s/rad).
    pub dissipation: f64,
}

/// State of a joint that is neither free nor fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum JointState<T = f64> {
    /// Revolute or prismatic joint.
    Scalar {
        /// Angle (rad), including full turns, or displacement (m).
        position: T,
        /// Velocity (rad/s or m/s).
        velocity: T,
    },
    /// Ball joint.
    Ball {
        /// Rotation from the body frame to the joint frame.
        rotation: Matrix3<T>,
        /// Angular velocity (rad/s), in the axes of the joint frame.
        angular_velocity: Vector3<T>,
    },
}

/// Position of a joint.
#[derive(Debug, Clone, Copy)]
pub(super) enum JointPosition<T = f64> {
    /// Angle (rad) or displacement (m).
    Scalar(T),
    Rotation(Matrix3<T>),
    /// Pose of a free body in the world.
    Pose(Pose<T>),
    Fixed,
}

impl<T: Scalar> JointPosition<T> {
    /// The position without its derivatives.
    pub(super) fn real(&self) -> JointPosition {
        match self {
            Self::Scalar(number) => JointPosition::Scalar(real_part(*number)),
            Self::Rotation(rotation) => JointPosition::Rotation(rotation.map(real_part)),
            Self::Pose(pose) => JointPosition::Pose(pose.real()),
            Self::Fixed => JointPosition::Fixed,
        }
    }
}

impl JointPosition {
    /// The position with zero derivatives.
    pub(super) fn lifted<T: Scalar>(&self) -> JointPosition<T> {
        match self {
            Self::Scalar(number) => JointPosition::Scalar(lift(*number)),
            Self::Rotation(rotation) => JointPosition::Rotation(rotation.map(lift)),
            Self::Pose(pose) => JointPosition::Pose(Pose::lifted(pose)),
            Self::Fixed => JointPosition::Fixed,
        }
    }
}

impl JointKind {
    /// Number of degrees of freedom.
    #[must_use]
    pub fn width(&self) -> usize {
        match self {
            Self::Free => 6,
            Self::Ball => 3,
            Self::Revolute(_) | Self::Prismatic(_) => 1,
            Self::Fixed => 0,
        }
    }

    /// Checks the length of the axis of a joint with this name.
    pub(super) fn check_axis(&self, joint: &str) -> Result<(), WorldError> {
        let (Self::Revolute(axis) | Self::Prismatic(axis)) = self else {
            return Ok(());
        };
        let length = axis.norm();
        let is_unit = (length - 1.0).abs() <= UNIT;
        check(joint, "length of the axis", length, is_unit, "1")
    }
}

impl Joint {
    /// Joint that rotates about an axis of the joint frame. It starts at angle zero, at rest.
    #[must_use]
    pub fn revolute(name: &str, axis: UnitVector3<f64>) -> Self {
        Self::new(name, JointKind::Revolute(axis))
    }

    /// Joint that slides along an axis of the joint frame. It starts at displacement zero, at rest.
    #[must_use]
    pub fn prismatic(name: &str, axis: UnitVector3<f64>) -> Self {
        Self::new(name, JointKind::Prismatic(axis))
    }

    /// Joint that rotates about all axes. It starts at the orientation of the joint frame, at rest.
    #[must_use]
    pub fn ball(name: &str) -> Self {
        Self::new(name, JointKind::Ball)
    }

    /// Joint without motion: welds a body to its parent.
    #[must_use]
    pub fn fixed(name: &str) -> Self {
        Self::new(name, JointKind::Fixed)
    }

    /// Joint of a free body.
    pub(super) fn free() -> Self {
        Self::new("", JointKind::Free)
    }

    pub(super) fn new(name: &str, kind: JointKind) -> Self {
        let initial = match kind {
            JointKind::Ball => JointState::Ball {
                rotation: Matrix3::identity(),
                angular_velocity: Vector3::zeros(),
            },
            _ => JointState::Scalar {
                position: 0.0,
                velocity: 0.0,
            },
        };
        Self {
            name: name.to_owned(),
            parent: None,
            origin: Pose::identity(),
            kind,
            law: JointLaw::default(),
            torques: None,
            targets: None,
            mimic: None,
            initial,
        }
    }

    /// Sets the parent body. Without a parent, the joint connects the body to the world.
    #[must_use]
    pub fn with_parent(mut self, body: &str) -> Self {
        self.parent = Some(body.to_owned());
        self
    }

    /// Sets the pose of the joint frame in the body frame of the parent, or in the world.
    #[must_use]
    pub fn with_origin(mut self, origin: Pose) -> Self {
        self.origin = origin;
        self
    }

    /// Sets the initial state.
    #[must_use]
    pub fn with_initial_state(mut self, state: JointState) -> Self {
        self.initial = state;
        self
    }

    /// Sets the forces and the armature.
    #[must_use]
    pub fn with_law(mut self, law: JointLaw) -> Self {
        self.law = law;
        self
    }

    /// Sets the initial position (rad or m) of a revolute or prismatic joint.
    #[must_use]
    pub fn with_position(mut self, value: f64) -> Self {
        if let JointState::Scalar { position, .. } = &mut self.initial {
            *position = value;
        }
        self
    }

    /// Sets the initial velocity (rad/s or m/s) of a revolute or prismatic joint.
    #[must_use]
    pub fn with_velocity(mut self, value: f64) -> Self {
        if let JointState::Scalar { velocity, .. } = &mut self.initial {
            *velocity = value;
        }
        self
    }

    /// Sets the armature (kg m² or kg).
    #[must_use]
    pub fn with_armature(mut self, armature: f64) -> Self {
        self.law.armature = armature;
        self
    }

    /// Sets viscous damping (N m s/rad or N s/m).
    #[must_use]
    pub fn with_damping(mut self, damping: f64) -> Self {
        self.law.damping = damping;
        self
    }

    /// Sets Coulomb friction f (N m or N). At the velocity u, the resisting force is f·u/√(u² + s²), with the slip tolerance s (rad/s or
    /// m/s). The friction of contacts has the same form. The joint creeps at the velocity s·r/√(1 − r²) under a steady force r·f with r <
    /// 1.
    #[must_use]
    pub fn with_friction(mut self, friction: f64, slip_tolerance: f64) -> Self {
        self.law.friction = friction;
        self.law.slip_tolerance = slip_tolerance;
        self
    }

    /// Sets compliant stops.
    #[must_use]
    pub fn with_stops(mut self, stops: Stops) -> Self {
        self.law.stops = Some(stops);
        self
    }

    /// Sets the stiffness (N m/rad or N/m) and the damping (N m s/rad or N s/m) of the servo.
    #[must_use]
    pub fn with_servo(mut self, stiffness: f64, damping: f64) -> Self {
        self.law.actuator.stiffness = stiffness;
        self.law.actuator.damping = damping;
        self
    }

    /// Sets the target of the servo: its position (rad or m) at time 0, and its velocity (rad/s or m/s).
    #[must_use]
    pub fn with_target(mut self, position: f64, velocity: f64) -> Self {
        self.law.actuator.target_position = position;
        self.law.actuator.target_velocity = velocity;
        self
    }

    /// Sets the torque (N m) or force (N) that the actuator applies in addition to the servo.
    #[must_use]
    pub fn with_torque(mut self, torque: f64) -> Self {
        self.law.actuator.torque = torque;
        self
    }

    /// Sets a schedule of torques (N m) or forces (N) that are added to the torque of the actuator. Each value acts during one interval
    /// (s). The first interval begins at time 0. After the last interval, the added torque is zero. Each time step uses the mean over the
    /// step.
    #[must_use]
    pub fn with_torques(mut self, interval: f64, values: Vec<f64>) -> Self {
        self.torques = Some(Schedule { interval, values });
        self
    }

    /// Sets target positions (rad or m) of the servo at the times 0, `interval`, 2·`interval` and so on (s). The target moves at constant
    /// velocity between these times, and rests after the last time. Each time step uses the mean velocity over the step. These targets
    /// replace the target of [`Self::with_target`].
    #[must_use]
    pub fn with_targets(mut self, interval: f64, values: Vec<f64>) -> Self {
        self.targets = Some(Schedule { interval, values });
        self
    }

    /// Sets the largest magnitude of the torque (N m) or force (N) of the actuator.
    #[must_use]
    pub fn with_torque_limit(mut self, limit: f64) -> Self {
        self.law.actuator.limit = Some(limit);
        self
    }

    /// Couples a revolute or prismatic joint to another revolute or prismatic joint, its leader: position = multiplier · leader position +
    /// offset. The joint has no state of its own. The force of its law, times the multiplier, acts on the leader.
    #[must_use]
    pub fn with_mimic(mut self, leader: &str, multiplier: f64, offset: f64) -> Self {
        self.mimic = Some(Mimic {
            joint: leader.to_owned(),
            multiplier,
            offset,
        });
        self
    }

    /// Checks the joint. The constructors of a world also check all joints.
    ///
    /// # Errors
    /// - If a number is out of range.
    /// - If the initial state does not fit the kind of the joint.
    /// - If a ball joint has damping, friction, stops or an actuator.
    /// - If a joint that is neither revolute nor prismatic has a leader.
    pub fn check(&self) -> Result<(), WorldError> {
        self.law.check(&self.name)?;
        if let Some(mimic) = &self.mimic {
            if !self.kind.is_scalar() {
                return Err(WorldError::Mimic {
                    joint: self.name.clone(),
                    leader: mimic.joint.clone(),
                });
            }
            for (quantity, value) in [("multiplier", mimic.multiplier), ("offset", mimic.offset)] {
                check(&self.name, quantity, value, true, "finite")?;
            }
        }
        for schedule in self.torques.iter().chain(&self.targets) {
            self.check_schedule(schedule)?;
        }
        self.kind.check_axis(&self.name)?;
        let is_scheduled = self.torques.is_some() || self.targets.is_some();
        if self.kind == JointKind::Ball && (is_scheduled || !self.law.is_passive()) {
            return Err(WorldError::BallJointForce(self.name.clone()));
        }
        let origin = self.origin.checked().map(|_| ());
        origin.map_err(|source| WorldError::Pose {
            body: self.name.clone(),
            source,
        })?;
        self.initial.check(&self.name, &self.kind)
    }

    /// Checks that a schedule has values, and that its numbers are in range.
    fn check_schedule(&self, schedule: &Schedule) -> Result<(), WorldError> {
        let check = |quantity, value: f64, is_in_range, expected| {
            check(&self.name, quantity, value, is_in_range, expected)
        };
        let Schedule { interval, values } = schedule;
        check(
            "interval of a schedule",
            *interval,
            *interval > 0.0,
            "positive and finite",
        )?;
        let count = values.len();
        check(
            "number of values of a schedule",
            count as f64,
            count > 0,
            "positive",
        )?;
        let mut values = values.iter();
        values.try_for_each(|value| check("value of a schedule", *value, true, "finite"))
    }

    /// The joint with zero derivatives.
    pub(super) fn lifted<T: Scalar>(&self) -> Joint<T> {
        self.with_numbers(self.law.lifted(), self.initial.lifted(), |value| {
            lift(*value)
        })
    }
}

impl<T: Scalar> Joint<T> {
    /// The joint without derivatives.
    pub(super) fn real(&self) -> Joint {
        self.with_numbers(self.law.real(), self.initial.real(), |value| {
            real_part(*value)
        })
    }
}

impl<T> Joint<T> {
    fn with_numbers<U>(
        &self,
        law: JointLaw<U>,
        initial: JointState<U>,
        convert: impl Fn(&T) -> U,
    ) -> Joint<U> {
        let converted = |schedule: &Option<Schedule<T>>| {
            let schedule = schedule.as_ref();
            schedule.map(|schedule| schedule.map(&convert))
        };
        Joint {
            name: self.name.clone(),
            parent: self.parent.clone(),
            origin: self.origin,
            kind: self.kind,
            law,
            torques: converted(&self.torques),
            targets: converted(&self.targets),
            mimic: self.mimic.clone(),
            initial,
        }
    }
}

/// Count of the numbers of a joint law that can be parameters.
pub(crate) const NUMBER_COUNT: usize = 8;

impl<T> JointLaw<T> {
    /// Numbers that can be parameters, in the order of [`JointQuantity`](crate::gradient::JointQuantity).
    pub(crate) fn numbers_mut(&mut self) -> [&mut T; NUMBER_COUNT] {
        let Actuator {
            torque,
            stiffness,
            damping,
            target_position,
            target_velocity,
            ..
        } = &mut self.actuator;
        [
            torque,
            target_position,
            target_velocity,
            stiffness,
            damping,
            &mut self.damping,
            &mut self.friction,
            &mut self.armature,
        ]
    }

    fn map<U>(&self, convert: impl Fn(&T) -> U) -> JointLaw<U> {
        let Actuator {
            torque,
            stiffness,
            damping,
            target_position,
            target_velocity,
            target_time,
            limit,
        } = &self.actuator;
        JointLaw {
            armature: convert(&self.armature),
            damping: convert(&self.damping),
            friction: convert(&self.friction),
            slip_tolerance: self.slip_tolerance,
            stops: self.stops,
            actuator: Actuator {
                torque: convert(torque),
                stiffness: convert(stiffness),
                damping: convert(damping),
                target_position: convert(target_position),
                target_velocity: convert(target_velocity),
                target_time: *target_time,
                limit: *limit,
            },
        }
    }
}

/// Returns an error that names a joint and a number, unless the number is finite and in range.
fn check(
    joint: &str,
    quantity: &'static str,
    value: f64,
    is_in_range: bool,
    expected: &'static str,
) -> Result<(), WorldError> {
    if is_in_range && value.is_finite() {
        return Ok(());
    }
    Err(WorldError::Joint {
        joint: joint.to_owned(),
        quantity,
        value,
        expected,
    })
}

impl JointLaw {
    /// Whether the joint has no force. It may have armature.
    fn is_passive(&self) -> bool {
        let Actuator {
            torque,
            stiffness,
            damping,
            ..
        } = self.actuator;
        let forces = [self.damping, self.friction, torque, stiffness, damping];
        self.stops.is_none() && forces.iter().all(|force| *force == 0.0)
    }

    /// Checks that all numbers are in range.
    fn check(&self, joint: &str) -> Result<(), WorldError> {
        let check = |quantity, value: f64, is_in_range: bool, expected| {
            check(joint, quantity, value, is_in_range, expected)
        };
        let Actuator {
            torque,
            stiffness,
            damping,
            target_position,
            target_velocity,
            target_time,
            limit,
        } = self.actuator;
        let [low, high] = self.stops.map_or([0.0; 2], |stops| stops.range);
        for (quantity, value) in [
            ("torque", torque),
            ("target position", target_position),
            ("target velocity", target_velocity),
            ("target time", target_time),
            ("lower end of the range", low),
        ] {
            check(quantity, value, true, "finite")?;
        }
        for (quantity, value) in [
            ("armature", self.armature),
            ("damping", self.damping),
            ("friction", self.friction),
            ("stiffness of the servo", stiffness),
            ("damping of the servo", damping),
            ("torque limit", limit.unwrap_or_default()),
            (
                "stiffness of the stops",
                self.stops.map_or(0.0, |stops| stops.stiffness),
            ),
            (
                "dissipation of the stops",
                self.stops.map_or(0.0, |stops| stops.dissipation),
            ),
        ] {
            check(quantity, value, value >= 0.0, "not negative and finite")?;
        }
        let slip = self.slip_tolerance;
        let is_slip = SLIP_TOLERANCES.contains(&slip);
        check("slip tolerance", slip, is_slip, "from 1e-100 to 1e100")?;
        check(
            "upper end of the range",
            high,
            high >= low,
            "finite and at least the lower end",
        )
    }

    pub(super) fn lifted<T: Scalar>(&self) -> JointLaw<T> {
        self.map(|number| lift(*number))
    }
}

impl Default for JointLaw {
    fn default() -> Self {
        Self {
            armature: 0.0,
            damping: 0.0,
            friction: 0.0,
            slip_tolerance: SLIP_TOLERANCE,
            stops: None,
            actuator: Actuator::default(),
        }
    }
}

impl Default for Actuator {
    fn default() -> Self {
        Self {
            torque: 0.0,
            stiffness: 0.0,
            damping: 0.0,
            target_position: 0.0,
            target_velocity: 0.0,
            target_time: 0.0,
            limit: None,
        }
    }
}

impl<T: Scalar> JointState<T> {
    /// Position (rad or m) of a revolute or prismatic joint.
    #[must_use]
    pub fn position(&self) -> Option<T> {
        match self {
            Self::Scalar { position, .. } => Some(*position),
            Self::Ball { .. } => None,
        }
    }

    /// Velocity (rad/s or m/s) of a revolute or prismatic joint.
    #[must_use]
    pub fn velocity(&self) -> Option<T> {
        match self {
            Self::Scalar { velocity, .. } => Some(*velocity),
            Self::Ball { .. } => None,
        }
    }

    /// Adds a rotation vector and a change of the angular velocity. A revolute or prismatic joint uses only the first component of each
    /// vector.
    pub(crate) fn displace(&mut self, turn: &Vector3<T>, spin: &Vector3<T>) {
        match self {
            Self::Scalar { position, velocity } => {
                *position += turn.x;
                *velocity += spin.x;
            }
            Self::Ball {
                rotation,
                angular_velocity,
            } => {
                *rotation = turned_by(rotation, turn);
                *angular_velocity += spin;
            }
        }
    }

    /// Checks that the state fits the kind of the joint, and that its numbers are finite.
    pub(super) fn check(&self, joint: &str, kind: &JointKind) -> Result<(), WorldError> {
        let (fits, numbers) = match self.real() {
            JointState::Scalar { position, velocity } => {
                (*kind != JointKind::Ball, vec![position, velocity])
            }
            JointState::Ball {
                rotation,
                angular_velocity,
            } => {
                let rigid = Pose::from_parts(rotation, angular_velocity).checked();
                rigid.map_err(|source| WorldError::Pose {
                    body: joint.to_owned(),
                    source,
                })?;
                (
                    *kind == JointKind::Ball,
                    angular_velocity.iter().copied().collect(),
                )
            }
        };
        if !fits {
            return Err(WorldError::JointState(joint.to_owned()));
        }
        match numbers.into_iter().find(|number| !number.is_finite()) {
            None => Ok(()),
            Some(value) => Err(WorldError::Joint {
                joint: joint.to_owned(),
                quantity: "state",
                value,
                expected: "finite",
            }),
        }
    }

    /// The state without its derivatives.
    #[must_use]
    pub fn real(&self) -> JointState {
        self.map(real_part)
    }

    fn map<U: Scalar>(&self, convert: impl Fn(T) -> U) -> JointState<U> {
        match self {
            Self::Scalar { position, velocity } => JointState::Scalar {
                position: convert(*position),
                velocity: convert(*velocity),
            },
            Self::Ball {
                rotation,
                angular_velocity,
            } => JointState::Ball {
                rotation: rotation.map(&convert),
                angular_velocity: angular_velocity.map(&convert),
            },
        }
    }
}

impl JointState {
    /// The state with zero derivatives.
    pub(super) fn lifted<T: Scalar>(&self) -> JointState<T> {
        self.map(lift)
    }
}

impl<T> Joint<T> {
    /// Name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the parent body, or `None` for the world.
    #[must_use]
    pub fn parent(&self) -> Option<&str> {
        self.parent.as_deref()
    }

    /// Pose of the joint frame in the body frame of the parent, or in the world.
    #[must_use]
    pub fn origin(&self) -> &Pose {
        &self.origin
    }

    /// Kind.
    #[must_use]
    pub fn kind(&self) -> &JointKind {
        &self.kind
    }

    /// Forces and armature.
    #[must_use]
    pub fn law(&self) -> &JointLaw<T> {
        &self.law
    }

    /// Scheduled torques: see [`Joint::with_torques`].
    #[must_use]
    pub fn torques(&self) -> Option<&Schedule<T>> {
        self.torques.as_ref()
    }

    /// Scheduled target positions of the servo: see [`Joint::with_targets`].
    #[must_use]
    pub fn targets(&self) -> Option<&Schedule<T>> {
        self.targets.as_ref()
    }

    /// Coupling to a leader, or `None`.
    #[must_use]
    pub fn mimic(&self) -> Option<&Mimic> {
        self.mimic.as_ref()
    }

    /// Initial state, or `None` for a free, fixed or mimicking joint.
    #[must_use]
    pub fn initial_state(&self) -> Option<&JointState<T>> {
        self.has_state().then_some(&self.initial)
    }

    /// Whether the joint has a `JointState`. The coordinates of a free joint are in the state of its body. A fixed joint has no
    /// coordinates, and the coordinates of a mimicking joint are those of its leader.
    pub(super) fn has_state(&self) -> bool {
        self.mimic.is_none() && !matches!(self.kind, JointKind::Free | JointKind::Fixed)
    }
}

impl JointKind {
    /// Whether the joint is revolute or prismatic.
    pub(super) fn is_scalar(&self) -> bool {
        matches!(self, Self::Revolute(_) | Self::Prismatic(_))
    }
}

impl<T: Scalar> JointLaw<T> {
    /// The law without derivatives.
    fn real(&self) -> JointLaw {
        self.map(|number| real_part(*number))
    }

    /// Force of the joint (N m) at a position (rad), a velocity (rad/s) and a time (s).
    pub(super) fn force(&self, position: T, velocity: T, time: f64) -> T {
        let slip = (velocity * velocity + self.slip_tolerance * self.slip_tolerance).sqrt();
        let passive = self.damping * velocity + self.friction * velocity / slip;
        let actuator = self.actuator.torque_at(position, velocity, time);
        let stops = self
            .stops
            .map_or(lift(0.0), |stops| stops.force(position, velocity));
        actuator + stops - passive
    }
}

impl JointLaw {
    /// Derivatives of the force with respect to [`Self::numbers_mut`], without the armature.
    pub(super) fn slopes_by_numbers(
        &self,
        [position, velocity]: [f64; 2],
        time: f64,
    ) -> [f64; NUMBER_COUNT] {
        type Dual = DenseDual<NUMBER_COUNT>;
        let mut law = self.lifted::<Dual>();
        for (i, number) in law.numbers_mut().into_iter().enumerate() {
            *number += Dual::variable(0.0, i);
        }
        law.force(lift(position), lift(velocity), time).eps
    }

    /// Derivatives of the force with respect to position and velocity.
    pub(super) fn slopes(&self, position: f64, velocity: f64, time: f64) -> [f64; 2] {
        type Dual = DenseDual<2>;
        let [position, velocity] = [Dual::variable(position, 0), Dual::variable(velocity, 1)];
        let force = self.lifted::<Dual>().force(position, velocity, time);
        [force.eps[0], force.eps[1]]
    }
}

impl<T: Scalar> Actuator<T> {
    fn torque_at(&self, position: T, velocity: T, time: f64) -> T {
        let target = self.target_position + self.target_velocity * (time - self.target_time);
        let servo =
            self.stiffness * (target - position) + self.damping * (self.target_velocity - velocity);
        let torque = self.torque + servo;
        match self.limit {
            Some(limit) if real_part(torque).abs() > limit => {
                lift(limit.copysign(real_part(torque)))
            }
            _ => torque,
        }
    }
}

impl Stops {
    /// Stops at the ends of a range (rad or m), with a stiffness (N m/rad or N/m) and a dissipation (s/rad or s/m).
    #[must_use]
    pub fn new(range: [f64; 2], stiffness: f64, dissipation: f64) -> Self {
        Self {
            range,
            stiffness,
            dissipation,
        }
    }

    fn force<T: Scalar>(&self, position: T, velocity: T) -> T {
        let [low, high] = self.range;
        let push = |depth: T, rate: T| -> T {
            let damped = rate * self.dissipation + 1.0;
            if real_part(depth) <= 0.0 || real_part(damped) <= 0.0 {
                return lift(0.0);
            }
            depth * damped * self.stiffness
        };
        push(-position + low, -velocity) - push(position - high, velocity)
    }
}
