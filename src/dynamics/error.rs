use crate::contact::STEEPEST;
use crate::spatial::PoseError;

/// Why bodies, settings or a state do not make or fit a world.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A material's number is out of range.
    #[error(
        "the {quantity} of body {body:?} is {value}: a modulus must be positive, dissipation and friction not negative, and all finite"
    )]
    Material {
        /// Name of the body.
        body: String,
        /// Which number.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// The modulus of a body makes its pressure rise by more than contact can be computed with.
    #[error(
        "the pressure of body {body:?} rises by {slope:e} Pa/m, its hydroelastic modulus times the steepest gradient of its extent, but {most:e} Pa/m is the most that can be computed with",
        most = STEEPEST
    )]
    Steep {
        /// Name of the body.
        body: String,
        /// How fast the pressure rises (Pa/m).
        slope: f64,
    },
    /// A rigid body has a material with a modulus.
    #[error(
        "body {0:?} is rigid, but its material has a hydroelastic modulus, and that of a rigid body has none"
    )]
    RigidWithModulus(String),
    /// A compliant body has a material without a modulus.
    #[error("body {0:?} is compliant, but its material is rigid: it needs a hydroelastic modulus")]
    NoModulus(String),
    /// A half-space was to be moved by forces.
    #[error("body {0:?} is a half-space, which has no mass: it can only be fixed or follow a path")]
    Unbounded(String),
    /// Two bodies, of which forces move one at least, are rigid or half-spaces.
    #[error(
        "between bodies {:?} and {:?} no contact is computed, because neither is compliant with a mesh: make one so, or name the pair as one to ignore when the world is made",
        .0[0], .0[1]
    )]
    NoContact([String; 2]),
    /// [`Force::coupling_groups`](super::Force::coupling_groups) returned the index of a body that the world does not have.
    #[error(
        "Force::coupling_groups returned body index {index}, but the world has {bodies} bodies, counted from 0"
    )]
    CoupledBody {
        /// The index that was returned.
        index: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// Mass, density or inertia are not those of a solid.
    #[error("the {quantity} of body {body:?} is {value}, but must be positive and finite")]
    Mass {
        /// Name of the body.
        body: String,
        /// Which number.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// An inertia matrix is not symmetric.
    #[error(
        "the inertia of body {body:?} differs from its transpose by {difference} kg m², but must be symmetric"
    )]
    AsymmetricInertia {
        /// Name of the body.
        body: String,
        /// Largest difference of two entries that should be equal (kg m²).
        difference: f64,
    },
    /// Principal moments that no solid has: each is the integral of the squares of two coordinates, so that none is greater
    /// than the sum of the other two.
    #[error(
        "the largest principal moment of inertia of body {body:?} is {largest} kg m², but that of a solid is at most the sum of the others, {others} kg m²"
    )]
    ImpossibleInertia {
        /// Name of the body.
        body: String,
        /// The largest principal moment (kg m²).
        largest: f64,
        /// The sum of the other two (kg m²).
        others: f64,
    },
    /// A center of mass is not finite.
    #[error("the center of mass of body {body:?} has the component {value}, but must be finite")]
    CenterOfMass {
        /// Name of the body.
        body: String,
        /// The component.
        value: f64,
    },
    /// A body that is fixed or on a path was given a start of its own, a control or a force.
    #[error("body {body:?} cannot have a {quantity} of its own: it is fixed or follows a path")]
    NotDynamic {
        /// Name of the body.
        body: String,
        /// What it was given.
        quantity: &'static str,
    },
    /// Forces move neither of the two bodies of a force.
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
    /// A body that forces move was given a path.
    #[error("body {0:?} cannot follow a path: forces move it")]
    Dynamic(String),
    /// A pose, initial or of a state, is not rigid or not finite.
    #[error("the pose of body {body:?} is unusable: {source}")]
    Pose {
        /// Name of the body.
        body: String,
        /// Why.
        source: PoseError,
    },
    /// A velocity or spin, initial or of a state, is not finite.
    #[error("the {quantity} of body {body:?} has the component {value}, but must be finite")]
    Velocity {
        /// Name of the body.
        body: String,
        /// Velocity or spin.
        quantity: &'static str,
        /// The component.
        value: f64,
    },
    /// Two bodies have the same name.
    #[error("two bodies are named {0:?}, but names must differ")]
    DuplicateName(String),
    /// Two bodies were asked for, and both are the same.
    #[error("two bodies are needed, but both are {0:?}")]
    SameBody(String),
    /// A name belongs to no body.
    #[error("no body is named {name:?}; there are {known:?}")]
    UnknownBody {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// A force names a force parameter that the world does not have.
    #[error("no force parameter is named {name:?}; there are {known:?}")]
    UnknownForceParameter {
        /// Name that the force asks for.
        name: String,
        /// Names of the world's force parameters.
        known: Vec<String>,
    },
    /// The name of a force parameter is empty.
    #[error("a force parameter needs a name, but its name is empty")]
    UnnamedForceParameter,
    /// A state does not fit the world.
    #[error("a state of {found} bodies does not fit a world of {expected}")]
    StateSize {
        /// Bodies in the state.
        found: usize,
        /// Bodies in the world.
        expected: usize,
    },
    /// A trajectory was made of no states.
    #[error("a trajectory needs at least one state")]
    NoState,
    /// The states of a trajectory are of different numbers of bodies.
    #[error("state {state} of a trajectory has {found} bodies, but the first has {expected}")]
    BodyCount {
        /// The state, counted from 0.
        state: usize,
        /// Bodies in it.
        found: usize,
        /// Bodies in the first one.
        expected: usize,
    },
    /// The states of a trajectory are not in the order of time.
    #[error("state {state} of a trajectory is at {time} s, but the one before it at {previous} s")]
    StateOrder {
        /// The state, counted from 0.
        state: usize,
        /// Its time (s).
        time: f64,
        /// Time of the one before it (s).
        previous: f64,
    },
    /// Changes of a state are more or fewer than it has degrees of freedom.
    #[error("{found} numbers do not change a state of {expected} local coordinates")]
    ChangeSize {
        /// Numbers given.
        found: usize,
        /// 12 for each dynamic body.
        expected: usize,
    },
    /// A number of the world, a plan, a force, a control or a state is out of range.
    #[error("the {quantity} is {value}, but must be {expected}")]
    Setting {
        /// Which number.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
}
