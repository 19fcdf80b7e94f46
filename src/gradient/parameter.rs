use std::fmt;
use std::sync::Arc;

/// A quantity of a world with respect to which derivatives can be taken.
///
/// ```
/// use hydroelastic::gradient::Parameter;
///
/// let parameters = [Parameter::initial_velocity("ball"), Parameter::friction("floor"), Parameter::Gravity];
/// let dimensions = parameters.map(|parameter| parameter.dimension());
/// assert_eq!(dimensions, [3, 1, 3]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Parameter {
    /// Initial position (m) of the named body's origin: 3 numbers.
    InitialPosition(Arc<str>),
    /// Initial orientation of the named body: 3 numbers, a rotation vector (rad) in world axes. A change rotates the body about
    /// its origin.
    InitialOrientation(Arc<str>),
    /// Initial velocity (m/s) of the named body's center of mass: 3 numbers.
    InitialVelocity(Arc<str>),
    /// Initial angular velocity (rad/s) of the named body, in world axes: 3 numbers.
    InitialAngularVelocity(Arc<str>),
    /// Hydroelastic modulus (Pa) of the named body.
    Modulus(Arc<str>),
    /// Dissipation (s/m) of the named body.
    Dissipation(Arc<str>),
    /// Coefficient of friction of the named body.
    Friction(Arc<str>),
    /// Mass (kg) of the named body. The inertia is proportional to the mass.
    Mass(Arc<str>),
    /// Radius of gyration (m) of the named body about its center of mass: the square root of the mean principal moment of inertia divided
    /// by the mass. The mass and the ratios of the moments stay constant.
    RadiusOfGyration(Arc<str>),
    /// Gravity (m/s²): 3 numbers.
    Gravity,
    /// Wrench of one interval, counted from 0, of the named body's [`Control`](crate::dynamics::Control): 6 numbers, torque (N m)
    /// and force (N), about the center of mass in world axes.
    Control(Arc<str>, usize),
    /// Named parameter of forces: 1 number. See
    /// [`World::with_force_parameter`](crate::dynamics::World::with_force_parameter).
    ForceParameter(Arc<str>),
    /// Quantity of the named joint: 1 number, or 3 numbers for a ball joint.
    Joint(Arc<str>, JointQuantity),
}

/// Quantity of a joint that can be a parameter. The units are those of a revolute joint. A prismatic joint has m for rad and N for N m.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum JointQuantity {
    /// Initial position (rad).
    InitialPosition,
    /// Initial velocity (rad/s).
    InitialVelocity,
    /// Torque of the actuator (N m).
    Torque,
    /// Target position of the servo (rad).
    TargetPosition,
    /// Target velocity of the servo (rad/s).
    TargetVelocity,
    /// Stiffness of the servo (N m/rad).
    ServoStiffness,
    /// Damping of the servo (N m s/rad).
    ServoDamping,
    /// Viscous damping (N m s/rad).
    Damping,
    /// Coulomb friction (N m).
    Friction,
    /// Armature (kg m²).
    Armature,
    /// Scheduled torque (N m) with this index, from 0: see [`Joint::with_torques`](crate::dynamics::Joint::with_torques).
    ScheduledTorque(usize),
    /// Scheduled target position (rad) with this index, from 0: see [`Joint::with_targets`](crate::dynamics::Joint::with_targets).
    ScheduledTarget(usize),
    /// Initial orientation of a ball joint: 3 numbers, a rotation vector (rad) in the axes of the joint frame.
    InitialOrientation,
    /// Initial angular velocity (rad/s) of a ball joint, in the axes of the joint frame: 3 numbers.
    InitialAngularVelocity,
}

impl JointQuantity {
    /// Number of scalar values: 3 for a ball joint, and 1 for other joints.
    #[must_use]
    pub fn dimension(self) -> usize {
        if self.is_for_ball_joint() { 3 } else { 1 }
    }

    /// Whether the quantity belongs to a ball joint.
    pub(super) fn is_for_ball_joint(self) -> bool {
        matches!(
            self,
            Self::InitialOrientation | Self::InitialAngularVelocity
        )
    }

    /// Whether the quantity is a part of the initial state.
    pub(super) fn is_initial(self) -> bool {
        matches!(self, Self::InitialPosition | Self::InitialVelocity) || self.is_for_ball_joint()
    }

    /// Index among the numbers of a joint law, or `None` for the initial state and for schedules.
    pub(super) fn law_index(self) -> Option<usize> {
        match self {
            Self::InitialPosition
            | Self::InitialVelocity
            | Self::InitialOrientation
            | Self::InitialAngularVelocity
            | Self::ScheduledTorque(_)
            | Self::ScheduledTarget(_) => None,
            Self::Torque => Some(0),
            Self::TargetPosition => Some(1),
            Self::TargetVelocity => Some(2),
            Self::ServoStiffness => Some(3),
            Self::ServoDamping => Some(4),
            Self::Damping => Some(5),
            Self::Friction => Some(6),
            Self::Armature => Some(7),
        }
    }
}

impl fmt::Display for JointQuantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::InitialPosition => "initial position",
            Self::InitialVelocity => "initial velocity",
            Self::Torque => "torque",
            Self::TargetPosition => "target position",
            Self::TargetVelocity => "target velocity",
            Self::ServoStiffness => "servo stiffness",
            Self::ServoDamping => "servo damping",
            Self::Damping => "damping",
            Self::Friction => "friction",
            Self::Armature => "armature",
            Self::ScheduledTorque(index) => return write!(formatter, "scheduled torque {index}"),
            Self::ScheduledTarget(index) => return write!(formatter, "scheduled target {index}"),
            Self::InitialOrientation => "initial orientation",
            Self::InitialAngularVelocity => "initial angular velocity",
        })
    }
}

/// Constructors.
impl Parameter {
    /// Initial position (m) of a body: [`Self::InitialPosition`].
    #[must_use]
    pub fn initial_position(body: impl Into<Arc<str>>) -> Self {
        Self::InitialPosition(body.into())
    }

    /// Initial orientation of a body: [`Self::InitialOrientation`].
    #[must_use]
    pub fn initial_orientation(body: impl Into<Arc<str>>) -> Self {
        Self::InitialOrientation(body.into())
    }

    /// Initial velocity (m/s) of a body: [`Self::InitialVelocity`].
    #[must_use]
    pub fn initial_velocity(body: impl Into<Arc<str>>) -> Self {
        Self::InitialVelocity(body.into())
    }

    /// Initial angular velocity (rad/s) of a body: [`Self::InitialAngularVelocity`].
    #[must_use]
    pub fn initial_angular_velocity(body: impl Into<Arc<str>>) -> Self {
        Self::InitialAngularVelocity(body.into())
    }

    /// Hydroelastic modulus (Pa) of a body: [`Self::Modulus`].
    #[must_use]
    pub fn modulus(body: impl Into<Arc<str>>) -> Self {
        Self::Modulus(body.into())
    }

    /// Dissipation (s/m) of a body: [`Self::Dissipation`].
    #[must_use]
    pub fn dissipation(body: impl Into<Arc<str>>) -> Self {
        Self::Dissipation(body.into())
    }

    /// Coefficient of friction of a body: [`Self::Friction`].
    #[must_use]
    pub fn friction(body: impl Into<Arc<str>>) -> Self {
        Self::Friction(body.into())
    }

    /// Mass (kg) of a body: [`Self::Mass`].
    #[must_use]
    pub fn mass(body: impl Into<Arc<str>>) -> Self {
        Self::Mass(body.into())
    }

    /// Radius of gyration (m) of a body: [`Self::RadiusOfGyration`].
    #[must_use]
    pub fn radius_of_gyration(body: impl Into<Arc<str>>) -> Self {
        Self::RadiusOfGyration(body.into())
    }

    /// Named parameter of forces: [`Self::ForceParameter`].
    #[must_use]
    pub fn force_parameter(name: impl Into<Arc<str>>) -> Self {
        Self::ForceParameter(name.into())
    }

    /// Quantity of a joint: [`Self::Joint`].
    #[must_use]
    pub fn joint(joint: impl Into<Arc<str>>, quantity: JointQuantity) -> Self {
        Self::Joint(joint.into(), quantity)
    }

    /// Wrench of an interval of a body's control: [`Self::Control`].
    #[must_use]
    pub fn control(body: impl Into<Arc<str>>, interval: usize) -> Self {
        Self::Control(body.into(), interval)
    }
}

impl Parameter {
    /// Number of scalar values: 1, 3 or 6.
    #[must_use]
    pub fn dimension(&self) -> usize {
        match self {
            Self::InitialPosition(_)
            | Self::InitialOrientation(_)
            | Self::InitialVelocity(_)
            | Self::InitialAngularVelocity(_)
            | Self::Gravity => 3,
            Self::Modulus(_)
            | Self::Dissipation(_)
            | Self::Friction(_)
            | Self::Mass(_)
            | Self::RadiusOfGyration(_)
            | Self::ForceParameter(_) => 1,
            Self::Joint(_, quantity) => quantity.dimension(),
            Self::Control(..) => 6,
        }
    }

    /// Whether the numbers are a rotation vector.
    pub(crate) fn is_orientation(&self) -> bool {
        matches!(
            self,
            Self::InitialOrientation(_) | Self::Joint(_, JointQuantity::InitialOrientation)
        )
    }

    /// Name of each number, for messages.
    pub(super) fn number_names(&self) -> Vec<String> {
        let numbers: &[&str] = match self.dimension() {
            1 => return vec![format!("{self:?}")],
            3 => &["x", "y", "z"],
            _ => &[
                "torque x", "torque y", "torque z", "force x", "force y", "force z",
            ],
        };
        let name = |number: &&str| format!("{self:?} {number}");
        numbers.iter().map(name).collect()
    }

    /// Name of the body, or `None` for gravity, force parameters and joints.
    #[must_use]
    pub fn body(&self) -> Option<&str> {
        match self {
            Self::InitialPosition(name)
            | Self::InitialOrientation(name)
            | Self::InitialVelocity(name)
            | Self::InitialAngularVelocity(name)
            | Self::Modulus(name)
            | Self::Dissipation(name)
            | Self::Friction(name)
            | Self::Mass(name)
            | Self::RadiusOfGyration(name)
            | Self::Control(name, _) => Some(name),
            Self::Gravity | Self::ForceParameter(_) | Self::Joint(..) => None,
        }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = match self {
            Self::InitialPosition(_) => "the initial position",
            Self::InitialOrientation(_) => "the initial orientation",
            Self::InitialVelocity(_) => "the initial velocity",
            Self::InitialAngularVelocity(_) => "the initial angular velocity",
            Self::Modulus(_) => "the modulus",
            Self::Dissipation(_) => "the dissipation",
            Self::Friction(_) => "the friction",
            Self::Mass(_) => "the mass",
            Self::RadiusOfGyration(_) => "the radius of gyration",
            Self::Gravity => "gravity",
            Self::ForceParameter(name) => return write!(formatter, "the force parameter {name:?}"),
            Self::Joint(name, quantity) => {
                return write!(formatter, "the {quantity} of joint {name:?}");
            }
            Self::Control(_, interval) => {
                write!(formatter, "interval {interval} of ")?;
                "the control"
            }
        };
        write!(formatter, "{quantity}")?;
        self.body()
            .map_or(Ok(()), |body| write!(formatter, " of {body:?}"))
    }
}
