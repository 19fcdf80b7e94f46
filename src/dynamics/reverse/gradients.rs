use crate::contact::{Kinks, ShapeGradient};
use crate::dynamics::joint::NUMBER_COUNT;
use crate::dynamics::model::Model;
use crate::dynamics::{Body, Control, Joint, STATE_DIM, Schedule, State};
use crate::spatial::Twist;
use nalgebra::{Matrix3, SVector, Vector3, Vector6};
use std::collections::BTreeMap;
use std::fmt;

/// Gradient of a number with respect to a [`State`].
#[derive(Debug, Clone, PartialEq)]
pub struct StateGradient {
    /// Gradients with respect to the states of the bodies, in the order of [`State::bodies`].
    pub bodies: Vec<BodyStateGradient>,
    /// Gradients with respect to the states of the joints, in the order of [`State::joints`].
    pub joints: Vec<JointStateGradient>,
}

impl StateGradient {
    /// Zero gradient with respect to a state.
    #[must_use]
    pub fn zero(state: &State) -> Self {
        Self {
            bodies: vec![BodyStateGradient::zero(); state.bodies.len()],
            joints: vec![JointStateGradient::zero(); state.joints.len()],
        }
    }
}

/// Gradient of a number with respect to the state of a body, in tangent-space coordinates (see
/// [`World::difference`](crate::dynamics::World::difference)), along the axes of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyStateGradient {
    /// Gradient with respect to a turn of the body about its origin (unit of the number per rad).
    pub turn: Vector3<f64>,
    /// Gradient with respect to a shift of the origin (unit of the number per m).
    pub shift: Vector3<f64>,
    /// Gradient with respect to the spin (unit of the number per rad/s).
    pub spin: Vector3<f64>,
    /// Gradient with respect to the velocity of the center of mass (unit of the number per m/s).
    pub velocity: Vector3<f64>,
}

impl BodyStateGradient {
    /// Zero gradient, for a number that does not depend on the state.
    #[must_use]
    pub fn zero() -> Self {
        Self::from_vector(&SVector::zeros())
    }

    /// Gradient from a vector (turn, shift, spin, velocity).
    #[must_use]
    pub fn from_vector(vector: &SVector<f64, STATE_DIM>) -> Self {
        let part = |row: usize| vector.fixed_rows::<3>(row).into_owned();
        Self {
            turn: part(0),
            shift: part(3),
            spin: part(6),
            velocity: part(9),
        }
    }

    /// Gradient from the derivatives with respect to the entries of the rotation matrix and of the
    /// position, and to spin and velocity (`by_twist`). Programs for automatic differentiation
    /// return derivatives in this form. `rotation` is the orientation of the body. Only three
    /// combinations of the nine entries matter, because a small turn θ changes the rotation R by θ
    /// × R.
    #[must_use]
    pub fn from_entries(
        rotation: &Matrix3<f64>,
        by_rotation: &Matrix3<f64>,
        by_position: Vector3<f64>,
        by_twist: &Twist,
    ) -> Self {
        Self {
            turn: by_turn(rotation, by_rotation),
            shift: by_position,
            spin: by_twist.angular,
            velocity: by_twist.linear,
        }
    }

    /// Gradient from its parts: with respect to the motion of the pose (angular, linear), and to the twist.
    pub(crate) fn from_parts([by_pose, by_twist]: [Vector6<f64>; 2]) -> Self {
        let number = |i: usize| if i < 6 { by_pose[i] } else { by_twist[i - 6] };
        Self::from_vector(&SVector::from_fn(|i, _| number(i)))
    }

    /// The inverse of [`Self::from_parts`].
    pub(crate) fn parts(&self) -> [Vector6<f64>; 2] {
        let six = |angular, linear| Twist { angular, linear }.to_vector();
        [six(self.turn, self.shift), six(self.spin, self.velocity)]
    }

    /// Gradient with respect to the motion of another point that is fixed to the body. `arm` (m, world axes) points from the current
    /// reference point to the other point.
    pub(crate) fn about(&self, arm: &Vector3<f64>) -> Self {
        let mut about = *self;
        about.add_by_arm(arm, &-self.shift);
        about
    }

    pub(crate) fn is_finite(&self) -> bool {
        let parts = [&self.turn, &self.shift, &self.spin, &self.velocity];
        parts.into_iter().flatten().all(|number| number.is_finite())
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.turn += other.turn;
        self.shift += other.shift;
        self.spin += other.spin;
        self.velocity += other.velocity;
    }

    /// Adds the gradient with respect to the arm (m, world axes) from the origin of the body to its center of mass. The arm turns with the
    /// body.
    pub(crate) fn add_by_arm(&mut self, arm: &Vector3<f64>, by_arm: &Vector3<f64>) {
        self.turn += arm.cross(by_arm);
    }
}

/// Gradient of a number with respect to the state of a joint. A revolute or prismatic joint uses only the first component of each vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointStateGradient {
    /// Gradient with respect to the position (unit of the number per rad or m). For a ball joint, it is with respect to a small rotation in
    /// the axes of the joint frame.
    pub position: Vector3<f64>,
    /// Gradient with respect to the velocity (unit of the number per rad/s or m/s).
    pub velocity: Vector3<f64>,
}

impl JointStateGradient {
    /// Zero gradient, for a number that does not depend on the state.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
        }
    }

    /// Gradient with respect to the state of a revolute or prismatic joint, from the derivatives with respect to its position and
    /// velocity.
    #[must_use]
    pub fn scalar(by_position: f64, by_velocity: f64) -> Self {
        Self {
            position: Vector3::new(by_position, 0.0, 0.0),
            velocity: Vector3::new(by_velocity, 0.0, 0.0),
        }
    }

    /// Gradient with respect to the state of a ball joint, from the derivatives with respect to the entries of its rotation matrix and to
    /// its angular velocity. `rotation` is the rotation of the joint.
    #[must_use]
    pub fn from_entries(
        rotation: &Matrix3<f64>,
        by_rotation: &Matrix3<f64>,
        by_angular_velocity: Vector3<f64>,
    ) -> Self {
        Self {
            position: by_turn(rotation, by_rotation),
            velocity: by_angular_velocity,
        }
    }

    /// Gradient with `position` in `turn` and `velocity` in `spin`.
    pub(crate) fn as_body(&self) -> BodyStateGradient {
        BodyStateGradient {
            turn: self.position,
            spin: self.velocity,
            ..BodyStateGradient::zero()
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        let mut numbers = self.position.iter().chain(&self.velocity);
        numbers.all(|number| number.is_finite())
    }
}

/// Gradient with respect to a small rotation, from the derivatives with respect to the entries of the rotation matrix.
fn by_turn(rotation: &Matrix3<f64>, by_rotation: &Matrix3<f64>) -> Vector3<f64> {
    let columns = rotation.column_iter().zip(by_rotation.column_iter());
    columns.map(|(axis, by_axis)| axis.cross(&by_axis)).sum()
}

/// Gradient of a number with respect to the initial state and all other inputs of a rollout.
#[derive(Debug, Clone)]
pub(crate) struct ModelGradient {
    /// Gradient with respect to the numbers of each body.
    pub bodies: Vec<BodyGradient>,
    /// Gradient with respect to the initial state of each joint.
    pub joints: Vec<JointStateGradient>,
    /// Gradient with respect to gravity (unit of the number per m/s²).
    pub gravity: Vector3<f64>,
    /// Gradient with respect to the wrench (torque, force) of each interval of each control.
    pub controls: Vec<Vec<Vector6<f64>>>,
    /// Derivative with respect to each force parameter.
    pub force_parameters: Vec<f64>,
    /// Gradient with respect to the shape of each body, at constant pose and mass properties. The
    /// list is empty if shapes were not requested.
    pub shapes: Vec<ShapeGradient>,
    kinks: BTreeMap<(Kink, Vec<usize>), KinkSummary>,
}

/// Kind of nonsmooth point: the rollout has no derivative there, or one of several derivatives was used. See [`Kinks`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Kink {
    /// Faces of two bodies coincide or touch: [`Kinks::are_flush`].
    Flush,
    /// The pressure between two bodies is clamped somewhere: [`Kinks::are_clamped`].
    Clamped,
    /// Two bodies have equal pressures over a volume: [`Kinks::are_equal`].
    EqualFields,
    /// An implicit step has substeps in which an error of the body exceeds a tolerance of [`Accuracy`](crate::dynamics::Accuracy). The
    /// derivative of the numerical solution may differ from the derivative of the motion.
    Unresolved,
}

impl fmt::Display for Kink {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Flush => "flush faces",
            Self::Clamped => "clamped pressure",
            Self::EqualFields => "equal fields",
            Self::Unresolved => "unresolved step",
        })
    }
}

/// All kinks of one kind in a rollout that involve the same bodies.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct KinkSummary {
    /// Indices of the bodies in the world, in increasing order.
    pub bodies: Vec<usize>,
    /// Kind of the kinks.
    pub kink: Kink,
    /// Number of steps with this kink.
    pub count: usize,
    /// First and last of these steps, counted from 1.
    pub steps: [usize; 2],
}

/// Gradient of a number with respect to the initial state and the properties of a body.
#[derive(Debug, Clone)]
pub(crate) struct BodyGradient {
    pub initial: BodyStateGradient,
    pub modulus: f64,
    pub dissipation: f64,
    pub friction: f64,
    /// Derivative with respect to the mass, to which the inertia is proportional.
    pub mass: f64,
    /// Gradient with respect to the center of mass, in the axes of the body frame (per m). It
    /// excludes the effect of the center of mass on forces other than contact.
    pub center: Vector3<f64>,
    /// Gradient with respect to the inertia per mass about the center of mass, in the axes of the
    /// body frame (per m²). It is symmetric.
    pub inertia: Matrix3<f64>,
    /// Gradient with respect to the numbers of the law of the joint.
    pub joint_law: [f64; NUMBER_COUNT],
    /// Gradient with respect to the scheduled torques of the joint.
    pub torques: Vec<f64>,
    /// Gradient with respect to the scheduled targets of the joint.
    pub targets: Vec<f64>,
}

impl BodyGradient {
    fn zero(body: &Body) -> Self {
        let zeros = |schedule: Option<&Schedule>| {
            schedule.map_or_else(Vec::new, |schedule| vec![0.0; schedule.values().len()])
        };
        Self {
            initial: BodyStateGradient::zero(),
            modulus: 0.0,
            dissipation: 0.0,
            friction: 0.0,
            mass: 0.0,
            center: Vector3::zeros(),
            inertia: Matrix3::zeros(),
            joint_law: [0.0; NUMBER_COUNT],
            torques: zeros(body.joint().and_then(Joint::torques)),
            targets: zeros(body.joint().and_then(Joint::targets)),
        }
    }
}

impl ModelGradient {
    pub fn zero(model: &Model) -> Self {
        let intervals = |control: &Control| vec![Vector6::zeros(); control.wrenches().len()];
        Self {
            bodies: model.bodies.iter().map(BodyGradient::zero).collect(),
            joints: vec![JointStateGradient::zero(); model.joint_count()],
            gravity: Vector3::zeros(),
            controls: model.controls.iter().map(intervals).collect(),
            force_parameters: vec![0.0; model.force_parameters.len()],
            shapes: Vec::new(),
            kinks: BTreeMap::new(),
        }
    }

    /// Records the kinks of a contact in a step.
    pub fn record_contact_kinks(&mut self, [a, b]: [usize; 2], kinks: Kinks, step: usize) {
        let Kinks {
            are_flush,
            are_clamped,
            are_equal,
        } = kinks;
        for (is_met, kink) in [
            (are_flush, Kink::Flush),
            (are_clamped, Kink::Clamped),
            (are_equal, Kink::EqualFields),
        ] {
            if is_met {
                self.record_kink(kink, &[a.min(b), a.max(b)], step);
            }
        }
    }

    /// Records a kink of some bodies in a step. A kink counts once in each step. Steps must come from the last to the first.
    pub fn record_kink(&mut self, kink: Kink, bodies: &[usize], step: usize) {
        let met = self.kinks.entry((kink, bodies.to_vec()));
        let met = met.or_insert_with_key(|(kink, bodies)| KinkSummary {
            bodies: bodies.clone(),
            kink: *kink,
            count: 0,
            steps: [step; 2],
        });
        met.count += usize::from(met.count == 0 || met.steps[0] != step);
        met.steps[0] = step;
    }

    /// All recorded kinks.
    pub fn kinks(&self) -> Vec<KinkSummary> {
        self.kinks.values().cloned().collect()
    }
}
