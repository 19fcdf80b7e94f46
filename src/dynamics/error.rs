use crate::contact::STEEPEST;
use crate::spatial::PoseError;

/// Error of a world, its settings, or a state that does not fit it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A number of a material is out of range.
    #[error(
        "the {quantity} of body {body:?} is {value}: a modulus must be positive, dissipation and friction not negative, and all finite"
    )]
    Material {
        /// Name of the body.
        body: String,
        /// Name of the quantity.
        quantity: &'static str,
        /// Value of the quantity.
        value: f64,
    },
    /// The pressure gradient of a body is too steep for the contact computation.
    #[error(
        "the pressure gradient of body {body:?} is {slope:e} Pa/m (hydroelastic modulus times the steepest gradient of the extent), but must be at most {most:e} Pa/m",
        most = STEEPEST
    )]
    Steep {
        /// Name of the body.
        body: String,
        /// Pressure gradient (Pa/m).
        slope: f64,
    },
    /// A rigid body has a material with a modulus.
    #[error(
        "body {0:?} is rigid, but its material has a hydroelastic modulus: a rigid body needs a material without one"
    )]
    RigidWithModulus(String),
    /// A compliant body has a material without a modulus.
    #[error("body {0:?} is compliant, but its material is rigid: it needs a hydroelastic modulus")]
    NoModulus(String),
    /// A half-space is dynamic, but has no mass.
    #[error("body {0:?} is a half-space, which has no mass: it can only be fixed or follow a path")]
    Unbounded(String),
    /// The mass of a body is distributed over its volume, but the body has no shape.
    #[error(
        "body {0:?} has no shape, so its mass cannot be distributed over its volume: use Mass::Properties or Mass::Link"
    )]
    NoVolume(String),
    /// A link has rotational inertia, but no mass.
    #[error(
        "body {0:?} has rotational inertia, but no mass: add the inertia to the body to which it is welded"
    )]
    MasslessInertia(String),
    /// The mass matrix is not positive definite, because a joint moves no inertia in one of its directions.
    #[error(
        "the joint of body {0:?} moves no inertia in one of its directions: give mass to the body or to a descendant, or give the joint an armature"
    )]
    NoInertia(String),
    /// Two bodies are rigid or half-spaces, and at least one of them is dynamic.
    #[error(
        "bodies {:?} and {:?} cannot have a contact, because neither is compliant with a mesh: give one of them a compliant mesh, or ignore the pair when the world is built",
        .0[0], .0[1]
    )]
    NoContact([String; 2]),
    /// [`Force::coupling_groups`](super::Force::coupling_groups) returned an index that is not the index of a body.
    #[error(
        "Force::coupling_groups returned body index {index}, but the world has {bodies} bodies, counted from 0"
    )]
    CoupledBody {
        /// Returned index.
        index: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// A quantity is requested that is defined only for worlds without joints.
    #[error("body {body:?} has a joint, but {quantity} is defined only for worlds without joints")]
    OnJoint {
        /// Name of a body on a joint, or of a body of a loop joint.
        body: String,
        /// Name of the quantity.
        quantity: &'static str,
    },
    /// A ball joint has a force.
    #[error(
        "ball joint {0:?} has damping, friction, stops or an actuator, but ball joints can have armature only"
    )]
    BallJointForce(String),
    /// Two joints have the same name.
    #[error("two joints have the name {0:?}: names of joints must be unique")]
    DuplicateJoint(String),
    /// No joint of the required kind has this name.
    #[error("no {kind} is named {name:?}: the names are {known:?}")]
    UnknownJoint {
        /// "ball joint", "revolute or prismatic joint", or "joint".
        kind: &'static str,
        /// Requested name.
        name: String,
        /// Names of all joints of this kind.
        known: Vec<String>,
    },
    /// A mimicking joint or its leader is neither revolute nor prismatic, the leader does not exist, or the leader mimics the joint.
    #[error(
        "joint {joint:?} mimics {leader:?}, but both must be existing revolute or prismatic joints, and the leader must not mimic the joint"
    )]
    Mimic {
        /// Name of the joint.
        joint: String,
        /// Name of the leader.
        leader: String,
    },
    /// A loop joint allows all motions.
    #[error("loop joint {0:?} is free: it must be a ball, revolute, prismatic or fixed joint")]
    FreeLoop(String),
    /// A loop joint connects a body to itself, or two bodies that are not dynamic.
    #[error(
        "loop joint {joint:?} connects {:?} and {:?}, but it must connect two different bodies, at least one of which is dynamic",
        .bodies[0], .bodies[1]
    )]
    LoopBodies {
        /// Name of the loop joint.
        joint: String,
        /// Names of its bodies.
        bodies: [String; 2],
    },
    /// A joint frame of a loop joint is not rigid or not finite.
    #[error("a frame of loop joint {joint:?} is unusable: {source}")]
    LoopFrame {
        /// Name of the loop joint.
        joint: String,
        /// Reason.
        source: PoseError,
    },
    /// Forward dynamics are requested in a world with loop joints.
    #[error(
        "forward dynamics are not available in worlds with loop joints: remove the loop joints, or use World::step"
    )]
    ForwardDynamicsOfLoops,
    /// The joint frames of a loop joint do not coincide in the first state of a motion.
    #[error(
        "the frames of loop joint {joint:?} are {distance:.1e} m and {angle:.1e} rad apart, but at most {tolerance:e} m and {tolerance:e} rad are allowed: change the positions of the joints, or the frames of the loop joint"
    )]
    OpenLoop {
        /// Name of the loop joint.
        joint: String,
        /// Distance between the origins of the joint frames (m), without the motion that the joint allows.
        distance: f64,
        /// Angle between the joint frames (rad), without the motion that the joint allows.
        angle: f64,
        /// Largest allowed distance and angle.
        tolerance: f64,
    },
    /// A chain of leaders gives a multiplier that is zero or not finite, or an offset that is not finite. The multiplier is the product of
    /// the multipliers along the chain.
    #[error(
        "the multipliers between joint {joint:?} and its leader {leader:?} have the product {multiplier}, and the offset is {offset}: both must be finite, and the product must not be zero"
    )]
    MimicChain {
        /// Name of the joint.
        joint: String,
        /// Name of the leader that has a state.
        leader: String,
        /// Product of the multipliers.
        multiplier: f64,
        /// Position (rad or m) if the position of the leader is zero.
        offset: f64,
    },
    /// A joint connects a body to a body that does not come before it.
    #[error(
        "joint {joint:?} connects body {body:?} to {parent:?}, but no earlier body has this name: list parents before children"
    )]
    JointParent {
        /// Name of the joint.
        joint: String,
        /// Name of the body.
        body: String,
        /// Name of the parent.
        parent: String,
    },
    /// A number of a joint is out of range.
    #[error("the {quantity} of joint {joint:?} is {value}, but must be {expected}")]
    Joint {
        /// Name of the joint.
        joint: String,
        /// Name of the number.
        quantity: &'static str,
        /// Value of the number.
        value: f64,
        /// Values that are allowed.
        expected: &'static str,
    },
    /// The state of a joint does not fit the kind of the joint.
    #[error(
        "the state of joint {0:?} does not fit its kind: revolute and prismatic joints have a position and a velocity, ball joints a rotation and an angular velocity"
    )]
    JointState(String),
    /// A state has another number of joints than the world.
    #[error(
        "the state has {found} joints, but the world has {expected} joints that are neither free nor fixed"
    )]
    JointCount {
        /// Number of joints in the state.
        found: usize,
        /// Number of joints of the world.
        expected: usize,
    },
    /// A mass, density or moment of inertia is not positive and finite.
    #[error("the {quantity} of body {body:?} is {value}, but must be positive and finite")]
    Mass {
        /// Name of the body.
        body: String,
        /// Name of the quantity.
        quantity: &'static str,
        /// Value of the quantity.
        value: f64,
    },
    /// An inertia matrix is not symmetric.
    #[error(
        "the inertia of body {body:?} differs from its transpose by {difference} kg m², but must be symmetric"
    )]
    AsymmetricInertia {
        /// Name of the body.
        body: String,
        /// Largest difference of two entries that must be equal (kg m²).
        difference: f64,
    },
    /// No solid has these principal moments. Each moment is the integral of the squares of two coordinates, so no moment is greater than
    /// the sum of the other two.
    #[error(
        "the largest principal moment of inertia of body {body:?} is {largest} kg m², but must be at most the sum of the others, {others} kg m²"
    )]
    ImpossibleInertia {
        /// Name of the body.
        body: String,
        /// Largest principal moment (kg m²).
        largest: f64,
        /// Sum of the other two moments (kg m²).
        others: f64,
    },
    /// A center of mass is not finite.
    #[error("the center of mass of body {body:?} has the component {value}, but must be finite")]
    CenterOfMass {
        /// Name of the body.
        body: String,
        /// Value of the component.
        value: f64,
    },
    /// A fixed or kinematic body was given an initial motion, a control or a force.
    #[error("body {body:?} cannot have a {quantity} of its own: it is fixed or follows a path")]
    NotDynamic {
        /// Name of the body.
        body: String,
        /// Rejected property.
        quantity: &'static str,
    },
    /// Neither of the two bodies of a force is dynamic.
    #[error(
        "a {quantity} between bodies {:?} and {:?} moves nothing: each is fixed or follows a path, so make one of them dynamic",
        .bodies[0], .bodies[1]
    )]
    NeitherDynamic {
        /// Names of the bodies.
        bodies: [String; 2],
        /// Kind of the force.
        quantity: &'static str,
    },
    /// A dynamic body was given a path.
    #[error("body {0:?} cannot follow a path: forces move it")]
    Dynamic(String),
    /// The pose of a body, initial or in a state, is not rigid or not finite.
    #[error("the pose of body {body:?} is unusable: {source}")]
    Pose {
        /// Name of the body.
        body: String,
        /// Cause.
        source: PoseError,
    },
    /// The velocity or spin of a body, initial or in a state, is not finite.
    #[error("the {quantity} of body {body:?} has the component {value}, but must be finite")]
    Velocity {
        /// Name of the body.
        body: String,
        /// "velocity" or "spin".
        quantity: &'static str,
        /// Value of the component.
        value: f64,
    },
    /// Two bodies have the same name.
    #[error("two bodies are named {0:?}, but names must differ")]
    DuplicateName(String),
    /// Two different bodies are required, but both names are the same.
    #[error("two bodies are needed, but both are {0:?}")]
    SameBody(String),
    /// No body has the name.
    #[error("no body is named {name:?}; there are {known:?}")]
    UnknownBody {
        /// Requested name.
        name: String,
        /// Names of the bodies.
        known: Vec<String>,
    },
    /// A force names a force parameter that the world does not have.
    #[error("no force parameter is named {name:?}; there are {known:?}")]
    UnknownForceParameter {
        /// Name that the force requires.
        name: String,
        /// Names of the world's force parameters.
        known: Vec<String>,
    },
    /// The name of a force parameter is empty.
    #[error("a force parameter needs a name, but its name is empty")]
    UnnamedForceParameter,
    /// A state does not fit the world.
    #[error("a state has {found} bodies, but the world has {expected}")]
    StateSize {
        /// Number of bodies in the state.
        found: usize,
        /// Number of bodies in the world.
        expected: usize,
    },
    /// No body has this index.
    #[error("no body has the index {index}: the world has {bodies} bodies, counted from 0")]
    BodyIndex {
        /// Requested index.
        index: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// The length of a vector is not the number of generalized velocities.
    #[error("there are {found} {quantity}, but the world has {expected} generalized velocities")]
    VelocityCount {
        /// Quantity in the vector.
        quantity: &'static str,
        /// Number of values in the vector.
        found: usize,
        /// Number of generalized velocities of the world.
        expected: usize,
    },
    /// A trajectory has no states.
    #[error("a trajectory needs at least one state")]
    NoState,
    /// The states of a trajectory have different numbers of bodies.
    #[error("state {state} of a trajectory has {found} bodies, but the first has {expected}")]
    BodyCount {
        /// Index of the state, from 0.
        state: usize,
        /// Number of bodies in the state.
        found: usize,
        /// Number of bodies in the first state.
        expected: usize,
    },
    /// The states of a trajectory have different joints.
    #[error(
        "the joints of state {0} of a trajectory differ in number or kind from those of the state before it"
    )]
    TrajectoryJoints(usize),
    /// The states of a trajectory are not in the order of time.
    #[error("state {state} of a trajectory is at {time} s, but the one before it at {previous} s")]
    StateOrder {
        /// Index of the state, from 0.
        state: usize,
        /// Time of the state (s).
        time: f64,
        /// Time of the previous state (s).
        previous: f64,
    },
    /// A change of a state has the wrong size.
    #[error(
        "a change of a state has {found} numbers, but must have {expected}: 2 for each generalized velocity that is not of a mimicking joint"
    )]
    ChangeSize {
        /// Number of values in the vector.
        found: usize,
        /// Expected number: 2 for each generalized velocity that is not of a mimicking joint.
        expected: usize,
    },
    /// A number of a world, plan, force, control or state is out of range.
    #[error("the {quantity} is {value}, but must be {expected}")]
    Setting {
        /// Name of the quantity.
        quantity: &'static str,
        /// Value of the quantity.
        value: f64,
        /// Valid values.
        expected: &'static str,
    },
}
