use super::mass::check_mass_number;
use super::motion::state_on;
use super::{BodyShape, BodyState, Inertia, KinematicPath, Mass, Material, Motion, WorldError};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Twist};
use nalgebra::Vector3;
use std::sync::Arc;

/// A shape with a name, a material, a motion and an initial state.
///
/// A shape goes in as a [`Shape`](crate::contact::Shape), a [`RigidShape`](crate::contact::RigidShape) or a
/// [`HalfSpace`](crate::contact::HalfSpace), or in an `Arc` of one of them, to be shared by several bodies.
#[derive(Debug, Clone)]
pub struct Body<T = f64> {
    pub(super) name: String,
    pub(super) shape: BodyShape,
    pub(crate) material: Material<T>,
    /// Whether dissipation and friction are evaluated: one of them is not zero, or is a parameter.
    pub(crate) is_dissipative: bool,
    pub(crate) motion: Motion<T>,
    pub(crate) initial: BodyState<T>,
    /// Time (s) of the initial state.
    pub(super) start: f64,
}

impl Body<f64> {
    /// A body that forces move, at rest at the origin.
    ///
    /// # Errors
    /// If the material or the mass is out of range, a compliant body has no modulus or a rigid one has one, or it is a
    /// half-space.
    pub fn dynamic(
        name: &str,
        shape: impl Into<BodyShape>,
        material: Material,
        mass: Mass,
    ) -> Result<Self, WorldError> {
        let shape = shape.into();
        let properties = shape.mass_properties(name, &mass)?;
        let motion = Motion::Dynamic(Inertia::new(&properties));
        Self::new(name, shape, material, motion)
    }

    /// A body that never moves, at the origin.
    ///
    /// # Errors
    /// If the material is out of range, or a compliant body has no modulus, or a rigid one has one.
    pub fn fixed(
        name: &str,
        shape: impl Into<BodyShape>,
        material: Material,
    ) -> Result<Self, WorldError> {
        Self::new(name, shape.into(), material, Motion::Fixed)
    }

    /// A body that follows a path: its pose and its twist, which must be the pose's derivative (the
    /// linear part being the velocity of the origin of the body frame).
    ///
    /// # Errors
    /// If the material is out of range, or a compliant body has no modulus, or a rigid one has one.
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
            Motion::Dynamic(_) | Motion::Fixed => BodyState {
                pose: Pose::identity(),
                twist: Twist::zero(),
            },
        };
        Ok(Self {
            name: name.to_owned(),
            shape,
            material,
            is_dissipative: material.dissipation > 0.0
                || material.friction.is_some_and(|friction| friction > 0.0),
            motion,
            initial,
            start: 0.0,
        })
    }

    /// The same body, starting at a pose; not for a body on a path.
    #[must_use]
    pub fn with_pose(mut self, pose: Pose) -> Self {
        self.initial.pose = pose;
        self
    }

    /// The same body, its center of mass starting with a velocity (m/s, world axes); only for a
    /// body that forces move.
    #[must_use]
    pub fn with_velocity(mut self, velocity: Vector3<f64>) -> Self {
        self.initial.twist.linear = velocity;
        self
    }

    /// The same body, starting with a spin (rad/s, world axes); only for a body that forces move.
    #[must_use]
    pub fn with_angular_velocity(mut self, spin: Vector3<f64>) -> Self {
        self.initial.twist.angular = spin;
        self
    }

    /// The constant body.
    pub(super) fn lifted<T: Scalar>(&self) -> Body<T> {
        Body {
            name: self.name.clone(),
            shape: self.shape.clone(),
            material: self.material.lifted(),
            is_dissipative: self.is_dissipative,
            motion: match &self.motion {
                Motion::Dynamic(inertia) => Motion::Dynamic(inertia.lifted()),
                Motion::Fixed => Motion::Fixed,
                Motion::Kinematic(path) => Motion::Kinematic(Arc::clone(path)),
            },
            initial: self.initial.lifted(),
            start: self.start,
        }
    }

    /// Moves the initial state to a time (s): that of a body on a path along the path.
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
        self.initial.check(&self.name)?;
        self.check_own_start()
    }

    /// Checks that the mass is usable.
    pub(crate) fn check_mass(&self) -> Result<(), WorldError> {
        let inertia = self.inertia();
        inertia.map_or(Ok(()), |inertia| {
            check_mass_number(&self.name, "mass", inertia.mass)
        })
    }

    /// Checks that a fixed body starts at rest, and a body with a path on the path.
    fn check_own_start(&self) -> Result<(), WorldError> {
        let start = match &self.motion {
            Motion::Dynamic(_) => return Ok(()),
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
            is_dissipative: self.is_dissipative,
            motion: match &self.motion {
                Motion::Dynamic(inertia) => Motion::Dynamic(inertia.real()),
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

    /// Material.
    #[must_use]
    pub fn material(&self) -> &Material<T> {
        &self.material
    }

    /// Mass and inertia of a dynamic body.
    #[must_use]
    pub fn inertia(&self) -> Option<&Inertia<T>> {
        match &self.motion {
            Motion::Dynamic(inertia) => Some(inertia),
            Motion::Fixed | Motion::Kinematic(_) => None,
        }
    }

    /// The state the body starts in.
    #[must_use]
    pub fn initial_state(&self) -> &BodyState<T> {
        &self.initial
    }

    /// Time (s) of the initial state: 0, or the time at which the world of the body starts.
    #[must_use]
    pub fn initial_time(&self) -> f64 {
        self.start
    }

    /// The center of mass (m) in the world, of a body that forces do not move its origin.
    pub(super) fn center_in(&self, state: &BodyState<T>) -> Vector3<T> {
        let origin = *state.pose.translation();
        match self.inertia() {
            Some(inertia) => origin + state.pose.rotated_constant(&inertia.center_of_mass),
            None => origin,
        }
    }

    /// The twist at the origin of the body frame instead of the center of mass.
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

/// The place of the body of a name, if there is one.
pub(super) fn index_of<T: Scalar>(name: &str, bodies: &[Body<T>]) -> Option<usize> {
    bodies.iter().position(|body| body.name() == name)
}

/// The place of the body of a name.
pub(super) fn known_index_of<T: Scalar>(
    name: &str,
    bodies: &[Body<T>],
) -> Result<usize, WorldError> {
    index_of(name, bodies).ok_or_else(|| WorldError::UnknownBody {
        name: name.to_owned(),
        known: bodies.iter().map(|b| b.name().to_owned()).collect(),
    })
}
