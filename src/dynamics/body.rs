use super::joint::JointKind;
use super::mass::check_mass_number;
use super::motion::state_on;
use super::validate::check_finite;
use super::{
    BodyShape, BodyState, Inertia, Joint, KinematicPath, Mass, Material, Motion, State, WorldError,
};
use crate::scalar::{Scalar, real_part};
use crate::spatial::{Pose, Twist};
use nalgebra::Vector3;
use std::sync::Arc;

/// Relative tolerance of mass properties of a uniform solid. Numbers in a file have nine digits.
const UNIFORM: f64 = 1e-9;

/// A shape with a name, a material, a motion and an initial state.
///
/// The shape can be a [`Shape`](crate::contact::Shape), a [`RigidShape`](crate::contact::RigidShape), a
/// [`HalfSpace`](crate::contact::HalfSpace), or an `Arc` of one of them, so that several bodies can share it.
#[derive(Debug, Clone)]
pub struct Body<T = f64> {
    pub(super) name: String,
    pub(super) shape: BodyShape,
    pub(crate) material: Material<T>,
    /// Whether a derivative with respect to dissipation or friction of the body is computed.
    pub(crate) is_law_differentiated: bool,
    pub(crate) motion: Motion<T>,
    pub(crate) initial: BodyState<T>,
    /// Time (s) of the initial state.
    pub(super) start: f64,
}

impl Body<f64> {
    /// Creates a dynamic body, which is moved by forces. It starts at rest at the origin.
    ///
    /// # Errors
    /// - If the material or the mass is out of range.
    /// - If a compliant body has no modulus, or a rigid body has one.
    /// - If the shape is a half-space.
    pub fn dynamic(
        name: &str,
        shape: impl Into<BodyShape>,
        material: Material,
        mass: Mass,
    ) -> Result<Self, WorldError> {
        let shape = shape.into();
        let properties = shape.mass_properties(name, &mass)?;
        let motion = Motion::Dynamic {
            inertia: Inertia::new(&properties),
            joint: Box::new(Joint::free()),
        };
        Self::new(name, shape, material, motion)
    }

    /// Creates a fixed body at the origin.
    ///
    /// # Errors
    /// - If the material is out of range.
    /// - If a compliant body has no modulus, or a rigid body has one.
    pub fn fixed(
        name: &str,
        shape: impl Into<BodyShape>,
        material: Material,
    ) -> Result<Self, WorldError> {
        Self::new(name, shape.into(), material, Motion::Fixed)
    }

    /// Creates a kinematic body, which follows a path of poses and twists. The twist must be the time derivative of the pose. Its linear
    /// part is the velocity of the origin of the body frame.
    ///
    /// # Errors
    /// - If the material is out of range.
    /// - If a compliant body has no modulus, or a rigid body has one.
    pub fn kinematic(
        name: &str,
        shape: impl Into<BodyShape>,
        material: Material,
        path: Arc<KinematicPath>,
    ) -> Result<Self, WorldError> {
        Self::new(name, shape.into(), material, Motion::Kinematic(path))
    }

    pub(super) fn new(
        name: &str,
        shape: BodyShape,
        material: Material,
        motion: Motion,
    ) -> Result<Self, WorldError> {
        material.check_on(name, &shape)?;
        let initial = match &motion {
            Motion::Kinematic(path) => state_on(&**path, 0.0),
            Motion::Dynamic { .. } | Motion::Fixed => BodyState {
                pose: Pose::identity(),
                twist: Twist::zero(),
            },
        };
        Ok(Self {
            name: name.to_owned(),
            shape,
            material,
            is_law_differentiated: false,
            motion,
            initial,
            start: 0.0,
        })
    }

    /// Sets the initial pose. Do not use it for a kinematic body: a world rejects a body that starts off its path.
    #[must_use]
    pub fn with_pose(mut self, pose: Pose) -> Self {
        self.initial.pose = pose;
        self
    }

    /// Connects a dynamic body to its parent, or to the world, by a joint. The joint gives the pose and the velocity of the body.
    ///
    /// # Errors
    /// If the body is not dynamic.
    pub fn with_joint(mut self, joint: Joint) -> Result<Self, WorldError> {
        match &mut self.motion {
            Motion::Dynamic { joint: current, .. } => **current = joint,
            Motion::Fixed | Motion::Kinematic(_) => {
                return Err(WorldError::NotDynamic {
                    body: self.name,
                    quantity: "joint",
                });
            }
        }
        Ok(self)
    }

    /// Removes the joint. A dynamic body is then free.
    #[must_use]
    pub fn without_joint(mut self) -> Self {
        if let Motion::Dynamic { joint, .. } = &mut self.motion {
            **joint = Joint::free();
        }
        self
    }

    /// Sets the initial velocity of the center of mass (m/s, world axes) of a dynamic body.
    #[must_use]
    pub fn with_velocity(mut self, velocity: Vector3<f64>) -> Self {
        self.initial.twist.linear = velocity;
        self
    }

    /// Sets the initial angular velocity (rad/s, world axes) of a dynamic body.
    #[must_use]
    pub fn with_angular_velocity(mut self, spin: Vector3<f64>) -> Self {
        self.initial.twist.angular = spin;
        self
    }

    /// The body with zero derivatives.
    pub(super) fn lifted<T: Scalar>(&self) -> Body<T> {
        Body {
            name: self.name.clone(),
            shape: self.shape.clone(),
            material: self.material.lifted(),
            is_law_differentiated: self.is_law_differentiated,
            motion: match &self.motion {
                Motion::Dynamic { inertia, joint } => Motion::Dynamic {
                    inertia: inertia.lifted(),
                    joint: Box::new(joint.lifted()),
                },
                Motion::Fixed => Motion::Fixed,
                Motion::Kinematic(path) => Motion::Kinematic(Arc::clone(path)),
            },
            initial: self.initial.lifted(),
            start: self.start,
        }
    }

    /// Sets the time (s) of the initial state. A kinematic body moves along its path to this time.
    pub(super) fn start_at(&mut self, time: f64) {
        self.start = time;
        if let Motion::Kinematic(path) = &self.motion {
            self.initial = state_on(&**path, time);
        }
    }

    /// Checks that material, mass and initial state are usable.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        self.material.check_on(&self.name, &self.shape)?;
        self.check_mass()?;
        if let Some(joint) = self.connecting_joint() {
            joint.check()?;
        }
        self.initial.check(&self.name)?;
        self.check_start()
    }

    /// Checks that the mass is in range. Only a body with zero inertia can be massless.
    pub(crate) fn check_mass(&self) -> Result<(), WorldError> {
        match self.inertia() {
            Some(inertia) if inertia.mass != 0.0 || inertia.principal.moments.amax() > 0.0 => {
                check_mass_number(&self.name, "mass", inertia.mass)
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Checks that a fixed body starts at rest, and a kinematic body on its path.
    fn check_start(&self) -> Result<(), WorldError> {
        let start = match &self.motion {
            Motion::Dynamic { .. } => return Ok(()),
            Motion::Fixed => BodyState {
                pose: self.initial.pose,
                twist: Twist::zero(),
            },
            Motion::Kinematic(path) => state_on(&**path, self.start),
        };
        let (initial, twist) = (&self.initial, &self.initial.twist);
        let keeps = [
            (
                "pose",
                initial.pose.translation() == start.pose.translation()
                    && initial.pose.rotation() == start.pose.rotation(),
            ),
            ("velocity", twist.linear == start.twist.linear),
            ("spin", twist.angular == start.twist.angular),
        ];
        match keeps.into_iter().find(|(_, kept)| !kept) {
            None => Ok(()),
            Some((quantity, _)) => Err(WorldError::NotDynamic {
                body: self.name.clone(),
                quantity,
            }),
        }
    }
}

impl<T: Scalar> Body<T> {
    /// The body without derivatives.
    pub(super) fn real(&self) -> Body {
        Body {
            name: self.name.clone(),
            shape: self.shape.clone(),
            material: self.material.real(),
            is_law_differentiated: self.is_law_differentiated,
            motion: match &self.motion {
                Motion::Dynamic { inertia, joint } => Motion::Dynamic {
                    inertia: inertia.real(),
                    joint: Box::new(joint.real()),
                },
                Motion::Fixed => Motion::Fixed,
                Motion::Kinematic(path) => Motion::Kinematic(Arc::clone(path)),
            },
            initial: self.initial.real(),
            start: self.start,
        }
    }

    /// Name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Shape.
    #[must_use]
    pub fn shape(&self) -> &BodyShape {
        &self.shape
    }

    /// Whether the body is compliant with a mesh.
    pub(super) fn has_mesh(&self) -> bool {
        self.shape.compliant().is_some()
    }

    /// Whether the body has a shape.
    pub(super) fn has_shape(&self) -> bool {
        !matches!(self.shape, BodyShape::None)
    }

    /// Material.
    #[must_use]
    pub fn material(&self) -> &Material<T> {
        &self.material
    }

    /// Mass and inertia of a dynamic body.
    #[must_use]
    pub fn inertia(&self) -> Option<&Inertia<T>> {
        match &self.motion {
            Motion::Dynamic { inertia, .. } => Some(inertia),
            Motion::Fixed | Motion::Kinematic(_) => None,
        }
    }

    /// Joint of a dynamic body to its parent.
    #[must_use]
    pub fn joint(&self) -> Option<&Joint<T>> {
        match &self.motion {
            Motion::Dynamic { joint, .. } => Some(joint),
            Motion::Fixed | Motion::Kinematic(_) => None,
        }
    }

    /// Whether the body is connected by a joint: it is dynamic, but not free.
    pub(crate) fn is_on_joint(&self) -> bool {
        self.connecting_joint().is_some()
    }

    /// Joint that is not free.
    pub(super) fn connecting_joint(&self) -> Option<&Joint<T>> {
        self.joint().filter(|joint| joint.kind != JointKind::Free)
    }

    /// Joint with its own state: neither free nor fixed, and without a leader.
    pub(crate) fn joint_with_state(&self) -> Option<&Joint<T>> {
        self.joint().filter(|joint| joint.has_state())
    }

    /// Initial state of a body that is not on a joint. The state of a body on a joint follows from the joint: see
    /// [`World::initial_state`](super::World::initial_state).
    #[must_use]
    pub fn initial_state(&self) -> &BodyState<T> {
        &self.initial
    }

    /// Time (s) of the initial state: 0, or the initial time of the world that contains the body.
    #[must_use]
    pub fn initial_time(&self) -> f64 {
        self.start
    }

    /// Whether dissipation and friction are evaluated: one of them is positive or differentiated.
    pub(super) fn is_dissipative(&self) -> bool {
        let is_positive = |number: T| real_part(number) > 0.0;
        self.is_law_differentiated
            || is_positive(self.material.dissipation)
            || self.material.friction.is_some_and(is_positive)
    }

    /// Mutable [`Self::connecting_joint`].
    pub(super) fn connecting_joint_mut(&mut self) -> Option<&mut Joint<T>> {
        match &mut self.motion {
            Motion::Dynamic { joint, .. } if joint.kind != JointKind::Free => Some(joint),
            Motion::Dynamic { .. } | Motion::Fixed | Motion::Kinematic(_) => None,
        }
    }

    /// Mutable [`Self::joint_with_state`].
    pub(super) fn joint_with_state_mut(&mut self) -> Option<&mut Joint<T>> {
        match &mut self.motion {
            Motion::Dynamic { joint, .. } if joint.has_state() => Some(joint),
            Motion::Dynamic { .. } | Motion::Fixed | Motion::Kinematic(_) => None,
        }
    }

    /// Position of the center of mass (m) in the world. For a body that is not dynamic, it is the origin of the body frame.
    pub(super) fn center_in(&self, state: &BodyState<T>) -> Vector3<T> {
        let origin = *state.pose.translation();
        match self.inertia() {
            Some(inertia) => origin + state.pose.rotated_constant(&inertia.center_of_mass),
            None => origin,
        }
    }

    /// Twist at the origin of the body frame.
    pub(super) fn twist_at_origin(&self, state: &BodyState<T>) -> Twist<T> {
        let Some(inertia) = self.inertia() else {
            return state.twist;
        };
        let to_center = state.pose.rotated_constant(&inertia.center_of_mass);
        Twist {
            angular: state.twist.angular,
            linear: state.twist.linear - state.twist.angular.cross(&to_center),
        }
    }
}

/// Index of the body with this name, if there is one.
pub(super) fn index_of<T: Scalar>(name: &str, bodies: &[Body<T>]) -> Option<usize> {
    bodies.iter().position(|body| body.name() == name)
}

/// Index of the body with this name, or an error that lists the known names.
pub(super) fn require_index_of<T: Scalar>(
    name: &str,
    bodies: &[Body<T>],
) -> Result<usize, WorldError> {
    index_of(name, bodies).ok_or_else(|| WorldError::UnknownBody {
        name: name.to_owned(),
        known: bodies.iter().map(|b| b.name().to_owned()).collect(),
    })
}

impl Body {
    /// Whether center of mass and inertia agree, up to round-off, with the shape at a uniform density.
    pub(crate) fn is_uniform(&self) -> bool {
        let unit = self.shape.mass_properties(&self.name, &Mass::Density(1.0));
        let (Some(inertia), Ok(unit)) = (self.inertia(), unit) else {
            return false;
        };
        let per_mass = unit.inertia / unit.mass;
        let length = per_mass.amax().sqrt();
        let off = (inertia.center_of_mass - unit.center_of_mass).amax();
        off <= UNIFORM * length
            && (inertia.per_mass() - per_mass).amax() <= UNIFORM * per_mass.amax()
    }
}

impl<T: Scalar> State<T> {
    /// Checks the time, the number of bodies, their poses and twists against the bodies of a world.
    pub(super) fn check_fits(&self, bodies: &[Body<T>]) -> Result<(), WorldError> {
        check_finite("time of a state", &[self.time])?;
        let (found, expected) = (self.bodies.len(), bodies.len());
        if found != expected {
            return Err(WorldError::StateSize { found, expected });
        }
        let joints = bodies.iter().filter_map(Body::joint_with_state);
        let (found, expected) = (self.joints.len(), joints.clone().count());
        if found != expected {
            return Err(WorldError::JointCount { found, expected });
        }
        let mut joints = self.joints.iter().zip(joints);
        joints.try_for_each(|(state, joint)| state.check(&joint.name, &joint.kind))?;
        let mut bodies = self.bodies.iter().zip(bodies);
        bodies.try_for_each(|(state, body)| state.check(body.name()))
    }
}
