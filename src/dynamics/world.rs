use super::force::check_coupled;
use super::model::{FORCE_PARAMETER, Model};
use super::validate::{check_finite, check_slip_tolerance};
use super::{Body, Control, Force, KinematicPath, Motion, State, WorldBuilder, WorldError};
use crate::scalar::Scalar;
use crate::spatial::Twist;
use nalgebra::Vector3;
use std::fmt;
use std::sync::Arc;

/// Bodies, what acts on them, and where they start.
///
/// Besides contact and gravity act the [forces](Force) `F` and the [controls](Control) it was given.
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
    /// These forces in another system.
    pub(crate) fn with_model<U>(&self, model: Model<U>) -> World<U, F> {
        let forces = Arc::clone(&self.forces);
        World { model, forces }
    }
}

/// Without the forces.
impl<T: fmt::Debug, F> fmt::Debug for World<T, F> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = formatter.debug_struct("World");
        parts.field("model", &self.model).finish_non_exhaustive()
    }
}

/// A copy to be shared.
impl<T: Clone, F> From<&World<T, F>> for Arc<World<T, F>> {
    fn from(world: &World<T, F>) -> Self {
        Self::new(world.clone())
    }
}

impl World {
    /// Starts a world of bodies and settings.
    pub fn builder() -> WorldBuilder {
        WorldBuilder::default()
    }

    /// A world without gravity, in which any two bodies may touch.
    ///
    /// # Errors
    /// As [`WorldBuilder::build`].
    pub fn new(bodies: Vec<Body>) -> Result<Self, WorldError> {
        Self::of_bodies(bodies, &[])
    }

    /// A world in which these pairs of bodies pass through each other.
    pub(super) fn of_bodies(
        bodies: Vec<Body>,
        ignored: &[[String; 2]],
    ) -> Result<Self, WorldError> {
        let mut model = Model::starting_at(0.0, bodies)?;
        for [first, second] in ignored {
            model = model.ignoring(first, second)?;
        }
        model.check_partners()?;
        // A body on a path has its pose from there, orthonormal already.
        for body in &mut model.bodies {
            if !body.motion.is_kinematic() {
                body.initial.pose = body.initial.pose.orthonormalized();
            }
        }
        Ok(Self::without_forces(model))
    }

    /// A world of a system, without forces of other kinds.
    pub(super) fn without_forces(model: Model) -> Self {
        let forces = Arc::new(());
        Self { model, forces }
    }
}

impl<F: Force> World<f64, F> {
    /// The same world with gravity (m/s²).
    ///
    /// # Errors
    /// If a component is not finite.
    pub fn with_gravity(mut self, gravity: Vector3<f64>) -> Result<Self, WorldError> {
        check_finite("gravity", gravity.as_slice())?;
        self.model.gravity = gravity;
        Ok(self)
    }

    /// The same world with a number that its forces may read, as a stiffness or a thrust: derivatives may be taken by it, which
    /// they cannot by a constant of the force itself. In place of the one of the same name, if there is one.
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
    /// If the name is empty, the value is not finite, or a force [cannot act](Force::check) with it.
    pub fn with_force_parameter(mut self, name: &str, value: f64) -> Result<Self, WorldError> {
        if name.is_empty() {
            return Err(WorldError::UnnamedForceParameter);
        }
        check_finite(FORCE_PARAMETER, &[value])?;
        self.model
            .force_parameters
            .retain(|(other, _)| other != name);
        self.model.force_parameters.push((name.into(), value));
        self.check_forces()?;
        Ok(self)
    }

    /// Checks that the forces can act.
    pub(crate) fn check_forces(&self) -> Result<(), WorldError> {
        let model = &self.model;
        self.forces.check(&model.bodies, &model.force_parameters)?;
        check_coupled(
            &self.forces.coupling_groups(&model.bodies),
            model.bodies.len(),
        )
    }

    /// Replaces the forces of the world by one force, or by several as a tuple or a list. The world must already have the
    /// [force parameters](Self::with_force_parameter) that the forces name.
    ///
    /// # Errors
    /// If a force [cannot act](Force::check) on the bodies, or [couples](Force::coupling_groups) one that the world does not have.
    pub fn with_forces<G: Force>(self, forces: G) -> Result<World<f64, G>, WorldError> {
        let world = World {
            model: self.model,
            forces: Arc::new(forces),
        };
        world.check_forces()?;
        Ok(world)
    }

    /// The same world with another initial state, at its own time. Bodies that forces do not move stay as they are: a fixed
    /// one where it was, one on a path where that is at the time.
    ///
    /// # Errors
    /// If the state has another number of bodies, a pose that is not rigid, or a number that is not finite, or a path is not
    /// finite at its time.
    pub fn with_initial_state(mut self, state: &State) -> Result<Self, WorldError> {
        state.check_fits(self.bodies())?;
        let placed = self.model.with_prescribed_states(state.clone());
        self.model.start = placed.time;
        for (body, initial) in self.model.bodies.iter_mut().zip(placed.bodies) {
            (body.initial, body.start) = (initial, placed.time);
        }
        self.model.check()?;
        Ok(self)
    }

    /// The same world with a control, in place of one that its body may have had.
    ///
    /// # Errors
    /// If there is no such body, or forces do not move it.
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
            .retain(|other| other.body() != control.body());
        self.model.controls.push(control);
        Ok(self)
    }

    /// The same world, in which a body that forces do not move follows a path, or stays where it starts if there is none: what
    /// takes the paths out of a world that is to be saved, and puts them back.
    ///
    /// # Errors
    /// If there is no such body, forces move it, or the path is not finite at the time of the initial state.
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

    /// The same world, in which two bodies pass through each other.
    ///
    /// # Errors
    /// If there is no body of one of the names, or both are the same.
    pub fn with_ignored(mut self, first: &str, second: &str) -> Result<Self, WorldError> {
        self.model = self.model.ignoring(first, second)?;
        Ok(self)
    }

    /// The same world with another slip tolerance (m/s): see [`SurfaceLaw`](crate::contact::SurfaceLaw). Implicit steps need at
    /// least 1e-6 m/s.
    ///
    /// # Errors
    /// If it is not from 1e-100 to 1e100 m/s.
    pub fn with_slip_tolerance(mut self, slip_tolerance: f64) -> Result<Self, WorldError> {
        check_slip_tolerance(slip_tolerance)?;
        self.model.slip_tolerance = slip_tolerance;
        Ok(self)
    }

    /// The constant world: a world in `T` whose numbers have no derivatives.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> World<T, F> {
        self.with_model(self.model.lifted())
    }
}

impl<T: Scalar, F: Force> World<T, F> {
    /// The bodies.
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

    /// The pairs of bodies that pass through each other, by their places, the smaller first.
    pub fn ignored(&self) -> impl Iterator<Item = (usize, usize)> {
        self.model.ignored.iter().copied()
    }

    /// The place of the body of that name, in [`Self::bodies`] and in every state.
    ///
    /// # Errors
    /// If there is none.
    pub fn index_of(&self, name: &str) -> Result<usize, WorldError> {
        self.model.index_of(name)
    }

    /// The controls.
    #[must_use]
    pub fn controls(&self) -> &[Control<T>] {
        &self.model.controls
    }

    /// Names and values of the force parameters.
    #[must_use]
    pub fn force_parameters(&self) -> &[(String, T)] {
        &self.model.force_parameters
    }

    /// The forces besides contact, gravity and controls.
    #[must_use]
    pub fn forces(&self) -> &F {
        &self.forces
    }

    /// The state from which rollouts start: at time 0, unless the world [starts from](Self::with_initial_state) another.
    #[must_use]
    pub fn initial_state(&self) -> State<T> {
        self.model.initial_state()
    }
}
