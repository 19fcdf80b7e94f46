//! Joints that close loops of bodies.

use super::WorldError;
use super::joint::JointKind;
use super::rigid_motion::turn_between;
use crate::scalar::portable::atan2;
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Largest distance (m) and largest angle (rad) between the joint frames of a loop joint in the initial state.
pub(super) const INITIAL_TOLERANCE: f64 = 1e-3;

/// The same for a state from which a motion continues. It exceeds the position errors of steps, so that any state of a rollout can be the first
/// state of another rollout.
pub(super) const LATER_TOLERANCE: f64 = 0.05;

/// Joint that closes a loop of bodies, such as the last joint of a four-bar linkage. It can also connect two free bodies.
///
/// A [`Joint`](super::Joint) gives a body its coordinates. A loop joint is a set of constraints on bodies that already have coordinates.
/// The constraint forces do no work. Redundant constraints are allowed: for example, all joints of a planar linkage can be revolute joints.
/// The two bodies pass through each other. Only implicit integrators support loop joints.
///
/// Each step enforces the constraints on velocities. Position errors decay within about one time step, and stay as small as the integration
/// error of one step. If initial velocities violate the constraints, the velocities change in the first step, as in an inelastic impact.
///
/// ```
/// use hydroelastic::dynamics::{JointKind, LoopJoint};
/// use hydroelastic::spatial::Pose;
/// use nalgebra::{Vector3, vector};
///
/// let pin = LoopJoint::new(
///     "pin",
///     JointKind::Revolute(Vector3::y_axis()),
///     ("coupler", Pose::from_translation(vector![0.4, 0.0, 0.0])),
///     ("rocker", Pose::from_translation(vector![0.0, 0.0, 0.3])),
/// );
/// assert_eq!(pin.bodies(), ["coupler", "rocker"]);
/// ```
#[derive(Debug, Clone)]
pub struct LoopJoint {
    name: String,
    kind: JointKind,
    bodies: [String; 2],
    frames: [Pose; 2],
}

/// Condition on the joint frames A and B of two bodies.
#[derive(Debug, Clone, Copy)]
pub(super) enum Constraint {
    /// The origins of A and B have the same coordinate along an axis of A.
    Translation(Vector3<f64>),
    /// An axis of A is perpendicular to an axis of B.
    Rotation([Vector3<f64>; 2]),
}

impl LoopJoint {
    /// Creates a loop joint. Each body comes with the pose of the joint frame in its body frame. The joint allows the motions of `kind` from
    /// a state in which both joint frames coincide. Axes are in the joint frame.
    #[must_use]
    pub fn new(
        name: &str,
        kind: JointKind,
        (first, first_frame): (&str, Pose),
        (second, second_frame): (&str, Pose),
    ) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            bodies: [first, second].map(str::to_owned),
            frames: [first_frame, second_frame],
        }
    }

    /// Name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Motions that the joint allows.
    #[must_use]
    pub fn kind(&self) -> &JointKind {
        &self.kind
    }

    /// Names of the two bodies.
    #[must_use]
    pub fn bodies(&self) -> [&str; 2] {
        [&self.bodies[0], &self.bodies[1]]
    }

    /// Pose of the joint frame in the body frame of each body.
    #[must_use]
    pub fn frames(&self) -> &[Pose; 2] {
        &self.frames
    }

    /// Checks the kind and the numbers.
    ///
    /// # Errors
    /// If the kind is free, an axis does not have length 1, a frame is not rigid, or a number is not finite.
    pub fn check(&self) -> Result<(), WorldError> {
        if self.kind == JointKind::Free {
            return Err(WorldError::FreeLoop(self.name.clone()));
        }
        self.kind.check_axis(&self.name)?;
        let mut frames = self.frames.iter();
        frames.try_for_each(|frame| {
            let checked = frame.checked().map(|_| ());
            checked.map_err(|source| WorldError::LoopFrame {
                joint: self.name.clone(),
                source,
            })
        })
    }

    /// Conditions that the joint imposes.
    pub(super) fn constraints(&self) -> Vec<Constraint> {
        let [x, y, z] = match self.kind {
            JointKind::Revolute(axis) | JointKind::Prismatic(axis) => orthonormal_basis(&axis),
            _ => [Vector3::x(), Vector3::y(), Vector3::z()],
        };
        let translations = [x, y, z].map(Constraint::Translation);
        let rotations = [[x, y], [y, z], [z, x]].map(Constraint::Rotation);
        match self.kind {
            JointKind::Free => Vec::new(),
            JointKind::Ball => translations.to_vec(),
            JointKind::Revolute(_) => {
                let aligned = [[x, z], [y, z]].map(Constraint::Rotation);
                [&translations[..], &aligned].concat()
            }
            JointKind::Prismatic(_) => [&translations[..2], &rotations].concat(),
            JointKind::Fixed => [translations, rotations].concat(),
        }
    }

    /// Copy with frames without the round-off that [`Self::check`] allows.
    pub(super) fn orthonormalized(&self) -> Self {
        let frames = self.frames.map(Pose::orthonormalized);
        Self {
            frames,
            ..self.clone()
        }
    }

    /// Checks that the joint is closed at the poses of its bodies, with a tolerance (m and rad).
    pub(super) fn check_closed(&self, poses: [Pose; 2], tolerance: f64) -> Result<(), WorldError> {
        let [a, b] = [0, 1].map(|side| poses[side] * self.frames[side]);
        let between = a.inverse() * b;
        let mut shift = *between.translation();
        let turn = match self.kind {
            JointKind::Ball | JointKind::Free => 0.0,
            JointKind::Revolute(axis) => {
                let turned = between.rotation() * *axis;
                atan2(turned.cross(&axis).norm(), turned.dot(&axis))
            }
            JointKind::Prismatic(_) | JointKind::Fixed => {
                turn_between(a.rotation(), b.rotation()).norm()
            }
        };
        if let JointKind::Prismatic(axis) = self.kind {
            shift -= *axis * axis.dot(&shift);
        }
        if shift.norm() <= tolerance && turn <= tolerance {
            return Ok(());
        }
        Err(WorldError::OpenLoop {
            joint: self.name.clone(),
            distance: shift.norm(),
            angle: turn,
            tolerance,
        })
    }
}

/// Completes an axis z to an orthonormal basis.
fn orthonormal_basis(z: &Vector3<f64>) -> [Vector3<f64>; 3] {
    let mut other = Vector3::zeros();
    other[z.iamin()] = 1.0;
    let x = other.cross(z).normalize();
    [x, z.cross(&x), *z]
}
