use crate::contact::STEEPEST;
use crate::spatial::PoseError;
use crate::threads::Panicked;

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
    /// A centre of mass is not finite.
    #[error("the centre of mass of body {body:?} has the component {value}, but must be finite")]
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

/// Why a rollout ended.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RolloutError {
    /// The state that it was to start from does not fit the world.
    #[error(transparent)]
    State(#[from] WorldError),
    /// A body starts wholly below the surface of a half-space without a contact that pushes it out.
    #[error(
        "body {:?} starts wholly below the surface of half-space {:?}, and no contact pushes it out: start it above (z > 0 in the frame of the half-space), turn the half-space, or ignore the pair",
        .bodies[0], .bodies[1]
    )]
    StartsBelow {
        /// Names of the body and of the half-space.
        bodies: [String; 2],
    },
    /// It was [stopped](super::Rollout::stopped_by), or the batch that it belongs to was ended before it began.
    #[error("the rollout was stopped before its end")]
    Stopped,
    /// A state is no longer finite.
    #[error(
        "step {step} (t = {time} s) took body {body:?} to a state that is not finite: the time step may be too long for its stiffness (see World::largest_stable_step)"
    )]
    NotFinite {
        /// The step that gave the state, counted from 1.
        step: usize,
        /// The time of the state (s).
        time: f64,
        /// Name of the body.
        body: String,
    },
    /// The path of a prescribed body gives a pose or a twist that is not finite.
    #[error("step {step} (t = {time} s): the path of body {body:?} is not finite there")]
    PathNotFinite {
        /// The step to that time, counted from 1.
        step: usize,
        /// The time (s).
        time: f64,
        /// Name of the body.
        body: String,
    },
    /// An explicit time step is too long for the contacts, so the rollout ends before it becomes unstable.
    /// [`Plan::without_stability_check`](super::Plan::without_stability_check) turns this check off.
    #[error(
        "step {step} (from t = {time:.6} s) was not taken: the time step of {time_step:.3e} s exceeds {limit:.3e} s, the stability limit of the contacts; the stiffest contact is that of bodies {:?} and {:?}; use shorter steps or an implicit integrator (Sdirk2), or make the contact softer",
        .bodies[0], .bodies[1]
    )]
    TimeStepTooLong {
        /// The step that was not taken, counted from 1.
        step: usize,
        /// The time of the state it would have started from (s).
        time: f64,
        /// The time step (s).
        time_step: f64,
        /// [`World::largest_stable_step`](super::World::largest_stable_step) without friction, at the poses of the contacts (s).
        limit: f64,
        /// Names of the two bodies whose contact, by itself, allows the shortest step.
        bodies: [String; 2],
    },
    /// A contact has created energy in explicit time steps: it returned more than twice the energy that it absorbed. A body moved
    /// far into another within a step, or bounces gained energy one after another.
    #[error(
        "step {step} (from t = {time:.6} s) was not taken: the contact of bodies {:?} and {:?} would have returned {returned:.3e} J, after it absorbed {absorbed:.3e} J; the time step of {time_step:.3e} s is too long for their impacts; use shorter steps or an implicit integrator (Sdirk2)",
        .bodies[0], .bodies[1]
    )]
    EnergyGained {
        /// The step that was not taken, counted from 1.
        step: usize,
        /// The time of the state it would have started from (s).
        time: f64,
        /// The time step (s).
        time_step: f64,
        /// Names of the two bodies.
        bodies: [String; 2],
        /// Energy that the contact has absorbed from the bodies, or stored at the start of the rollout (J).
        absorbed: f64,
        /// Energy that the contact would have returned to the bodies (J).
        returned: f64,
    },
    /// The equations of an implicit step were not solved, however often it was divided.
    #[error(
        "step {step} (from t = {time:.6} s) was not solved, down to {shortest:.3e} s: body {body:?} is the farthest from a solution; it may have started deep inside another, or a force may not be smooth"
    )]
    NotSolved {
        /// The step that was not taken, counted from 1.
        step: usize,
        /// The time of the state it would have started from (s).
        time: f64,
        /// Name of the body whose velocity is farthest from a solution.
        body: String,
        /// The shortest duration that was tried (s).
        shortest: f64,
    },
    /// A function that was passed in panicked while a rollout was recorded, alone or in a
    /// [`Batch`](super::Batch), or its outcome was read. In a program whose panics abort there is no
    /// such error.
    #[error("a force, a path or an outcome panicked: {message}")]
    Panicked {
        /// What it said.
        message: String,
    },
}

impl From<Panicked> for RolloutError {
    fn from(Panicked(message): Panicked) -> Self {
        Self::Panicked { message }
    }
}
