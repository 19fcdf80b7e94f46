use super::force::check_coupled;
use super::model::{FORCE_PARAMETER, Model};
use super::validate::{check_finite, check_slip_tolerance};
use super::{Body, Control, Force, KinematicPath, LoopJoint, Motion, State, WorldError};
use crate::scalar::Scalar;
use crate::spatial::Twist;
use nalgebra::Vector3;
use std::fmt;
use std::sync::Arc;

/// Bodies with their initial state. Contact, gravity, the [forces](Force) `F` and the [controls](Control) act on them.
pub struct World<T = f64, F = ()> {
    pub(crate) model: Model<T>,
    pub(super) forces: Arc<F>,
}

/// Shapes, paths and forces are shared, not copied.
impl<T: Clone, F> Clone for World<T, F> {
    fn clone(&self) -> Self {
        self.with_model(self.model.clone())
    }
}

impl<T, F> World<T, F> {
    /// World with the same forces and another model.
    pub(crate) fn with_model<U>(&self, model: Model<U>) -> World<U, F> {
        let forces = Arc::clone(&self.forces);
        World { model, forces }
    }
}

/// Prints the model, without the forces.
impl<T: fmt::Debug, F> fmt::Debug for World<T, F> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = formatter.debug_struct("World");
        parts.field("model", &self.model).finish_non_exhaustive()
    }
}

/// Copies the world into an `Arc`.
impl<T: Clone, F> From<&World<T, F>> for Arc<World<T, F>> {
    fn from(world: &World<T, F>) -> Self {
        Self::new(world.clone())
    }
}

impl World {
    /// World of bodies without gravity, in which no pairs of bodies are ignored.
    ///
    /// # Errors
    /// As for [`WorldBuilder::build`](super::WorldBuilder::build).
    pub fn new(bodies: Vec<Body>) -> Result<Self, WorldError> {
        Self::of_bodies(bodies, &[], &[])
    }

    /// World with loop joints and pairs of bodies without contact.
    pub(super) fn of_bodies(
        bodies: Vec<Body>,
        ignored: &[[String; 2]],
        loop_joints: &[LoopJoint],
    ) -> Result<Self, WorldError> {
        let mut world = Self::without_forces(Model::starting_at(0.0, bodies)?);
        for [first, second] in ignored {
            world = world.with_ignored(first, second)?;
        }
        for joint in loop_joints {
            world.model.add_loop_joint(joint)?;
        }
        world.model.check_partners()?;
        // The pose of a kinematic body comes from its path and is already orthonormal.
        for body in &mut world.model.bodies {
            if !body.motion.is_kinematic() {
                body.initial.pose = body.initial.pose.orthonormalized();
            }
        }
        Ok(world)
    }

    /// World of a model, without other forces.
    pub(super) fn without_forces(model: Model) -> Self {
        let forces = Arc::new(());
        Self { model, forces }
    }
}

impl<F: Force> World<f64, F> {
    /// Sets gravity (m/s²).
    ///
    /// # Errors
    /// If a component is not finite.
    pub fn with_gravity(mut self, gravity: Vector3<f64>) -> Result<Self, WorldError> {
        check_finite("gravity", gravity.as_slice())?;
        self.model.gravity = gravity;
        Ok(self)
    }

    /// Sets a force parameter: a number that forces read, such as a stiffness or a thrust. Rollouts can be differentiated with respect to
    /// force parameters, but not with respect to constants inside a force. The value replaces an earlier value of the same name.
    ///
    /// ```
    /// use hydroelastic::dynamics::{Force, ForceContext, World, WrenchAccumulator};
    /// use hydroelastic::scalar::{Scalar, lift};
    ///
    /// /// Drag on all bodies: the world's `"drag"` (N s/m).
    /// struct Honey;
    ///
    /// impl Force for Honey {
    ///     fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
    ///         let drag = now.parameter("drag").unwrap_or(lift(0.0));
    ///         for (body, state) in now.states.iter().enumerate() {
    ///             wrenches.apply_force_at_com(body, &(state.twist.linear * -drag));
    ///         }
    ///     }
    /// }
    /// # let bodies = vec![];
    /// let world = World::new(bodies)?.with_forces(Honey)?.with_force_parameter("drag", 0.3)?;
    /// # Ok::<(), hydroelastic::dynamics::WorldError>(())
    /// ```
    ///
    /// # Errors
    /// If the name is empty, the value is not finite, or a force [rejects](Force::check) the value.
    pub fn with_force_parameter(mut self, name: &str, value: f64) -> Result<Self, WorldError> {
        if name.is_empty() {
            return Err(WorldError::UnnamedForceParameter);
        }
        check_finite(FORCE_PARAMETER, &[value])?;
        self.model
            .force_parameters
            .retain(|(existing, _)| existing != name);
        self.model.force_parameters.push((name.into(), value));
        self.with_checked_forces()
    }

    /// Checks that the forces can act on the model.
    pub(crate) fn with_checked_forces(self) -> Result<Self, WorldError> {
        let model = &self.model;
        self.forces.check(&model.bodies, &model.force_parameters)?;
        let groups = self.forces.coupling_groups(&model.bodies);
        check_coupled(&groups, model.bodies.len())?;
        Ok(self)
    }

    /// Replaces the forces of the world by one force, or by several forces as a tuple or a list. The world must already have the [force
    /// parameters](Self::with_force_parameter) that the forces name.
    ///
    /// # Errors
    /// If a force [rejects](Force::check) the world, or [couples](Force::coupling_groups) a body that the world does not have.
    pub fn with_forces<G: Force>(self, forces: G) -> Result<World<f64, G>, WorldError> {
        let forces = Arc::new(forces);
        World {
            model: self.model,
            forces,
        }
        .with_checked_forces()
    }

    /// Sets the initial state and its time. Fixed bodies stay where they are. Kinematic bodies take the state of their path at that time.
    ///
    /// # Errors
    /// If the state does not fit the world, a path is not finite at its time, or a loop joint is open.
    pub fn with_initial_state(mut self, state: &State) -> Result<Self, WorldError> {
        self.model = self.model.with_initial_state(state)?;
        Ok(self)
    }

    /// State in which fixed and kinematic bodies have their prescribed states, and bodies on joints have the states that their joints determine.
    /// Loop joints may be open.
    ///
    /// # Errors
    /// If the state does not fit the world, or a pose or twist that a joint determines is not finite.
    pub fn placed(&self, state: &State) -> Result<State, WorldError> {
        self.model.placed(state)
    }

    /// Adds a control, or replaces the control of the same body.
    ///
    /// # Errors
    /// If the body is unknown or not dynamic.
    pub fn with_control(mut self, control: Control) -> Result<Self, WorldError> {
        let body = &self.model.bodies[self.index_of(control.body())?];
        if body.inertia().is_none() {
            return Err(WorldError::NotDynamic {
                body: body.name().to_owned(),
                quantity: "control",
            });
        }
        self.model
            .controls
            .retain(|existing| existing.body() != control.body());
        self.model.controls.push(control);
        Ok(self)
    }

    /// Makes a fixed or kinematic body follow a path, or stay at its initial pose if `path` is `None`. Use it to remove the paths from a
    /// world before it is saved, and to restore them.
    ///
    /// # Errors
    /// If the body is unknown or dynamic, or the path is not finite at the time of the initial state.
    pub fn with_path(
        mut self,
        body: &str,
        path: Option<Arc<KinematicPath>>,
    ) -> Result<Self, WorldError> {
        let index = self.index_of(body)?;
        let body_to_move = &mut self.model.bodies[index];
        if body_to_move.inertia().is_some() {
            return Err(WorldError::Dynamic(body.to_owned()));
        }
        body_to_move.motion = path.map_or(Motion::Fixed, Motion::Kinematic);
        body_to_move.initial.twist = Twist::zero();
        if let Some(start) = self.model.prescribed_state(index, self.model.start) {
            self.model.bodies[index].initial = start;
        }
        self.model.check()?;
        Ok(self)
    }

    /// Lets two bodies pass through each other.
    ///
    /// # Errors
    /// If one of the names is unknown, or both are the same.
    pub fn with_ignored(mut self, first: &str, second: &str) -> Result<Self, WorldError> {
        let (i, j) = (self.index_of(first)?, self.index_of(second)?);
        if i == j {
            return Err(WorldError::SameBody(first.to_owned()));
        }
        self.model.ignored.insert((i.min(j), i.max(j)));
        Ok(self)
    }

    /// Sets the slip tolerance (m/s) of all contacts: see [`SurfaceLaw`](crate::contact::SurfaceLaw). Implicit steps need at least 1e-6
    /// m/s.
    ///
    /// # Errors
    /// If the slip tolerance is not between 1e-100 and 1e100 m/s.
    pub fn with_slip_tolerance(mut self, slip_tolerance: f64) -> Result<Self, WorldError> {
        check_slip_tolerance(slip_tolerance)?;
        self.model.slip_tolerance = slip_tolerance;
        Ok(self)
    }

    /// The world in the scalar `T`, with zero derivatives.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> World<T, F> {
        self.with_model(self.model.lifted())
    }
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Bodies.
    #[must_use]
    pub fn bodies(&self) -> &[Body<T>] {
        &self.model.bodies
    }

    /// Gravity (m/s²).
    #[must_use]
    pub fn gravity(&self) -> &Vector3<T> {
        &self.model.gravity
    }

    /// Slip tolerance (m/s) of all contacts.
    #[must_use]
    pub fn slip_tolerance(&self) -> f64 {
        self.model.slip_tolerance
    }

    /// Indices of the pairs of bodies that pass through each other, the smaller index first.
    pub fn ignored(&self) -> impl Iterator<Item = (usize, usize)> {
        self.model.ignored.iter().copied()
    }

    /// Loop joints.
    pub fn loop_joints(&self) -> impl Iterator<Item = &LoopJoint> {
        self.model
            .loop_joints
            .iter()
            .map(|existing| &existing.joint)
    }

    /// Index of the body with this name, in [`Self::bodies`] and in every state.
    ///
    /// # Errors
    /// If no body has the name.
    pub fn index_of(&self, name: &str) -> Result<usize, WorldError> {
        self.model.index_of(name)
    }

    /// Controls.
    #[must_use]
    pub fn controls(&self) -> &[Control<T>] {
        &self.model.controls
    }

    /// Names and values of the force parameters.
    #[must_use]
    pub fn force_parameters(&self) -> &[(String, T)] {
        &self.model.force_parameters
    }

    /// Forces other than contact, gravity and controls.
    #[must_use]
    pub fn forces(&self) -> &F {
        &self.forces
    }

    /// Initial state of rollouts: at time 0, unless [`Self::with_initial_state`] has set another state.
    #[must_use]
    pub fn initial_state(&self) -> State<T> {
        self.model.initial_state()
    }
}
