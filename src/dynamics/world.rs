use super::body::{place_of, state_on};
use super::error::{check_finite, check_positive};
use super::{Body, BodyState, Control, Force, Motion, State, WorldError};
use crate::scalar::{Scalar, lift_vector};
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Slip tolerance (m/s) of a new world.
const SLIP_TOLERANCE: f64 = 1e-3;

/// Bodies, what acts on them, and where they start.
///
/// Besides contact and gravity act the [forces](Force) `F` and the [controls](Control) it was given.
#[derive(Debug)]
pub struct World<T = f64, F = ()> {
    pub(crate) bodies: Vec<Body<T>>,
    pub(crate) gravity: Vector3<T>,
    pub(crate) controls: Vec<Control<T>>,
    /// Time (s) of the initial state.
    pub(super) start: f64,
    pub(super) forces: Arc<F>,
    pub(super) ignored: BTreeSet<(usize, usize)>,
    pub(super) slip_tolerance: f64,
}

/// Shapes, paths and forces are shared, not copied.
impl<T: Clone, F> Clone for World<T, F> {
    fn clone(&self) -> Self {
        Self {
            bodies: self.bodies.clone(),
            gravity: self.gravity.clone(),
            controls: self.controls.clone(),
            start: self.start,
            forces: Arc::clone(&self.forces),
            ignored: self.ignored.clone(),
            slip_tolerance: self.slip_tolerance,
        }
    }
}

/// A copy to be shared.
impl<T: Clone, F> From<&World<T, F>> for Arc<World<T, F>> {
    fn from(world: &World<T, F>) -> Self {
        Self::new(world.clone())
    }
}

impl World {
    /// A world without gravity, in which any two bodies may touch.
    ///
    /// # Errors
    /// If two bodies have the same name, or an initial state is not usable.
    pub fn new(bodies: Vec<Body>) -> Result<Self, WorldError> {
        let mut world = Self::starting_at(0.0, bodies)?;
        // A body on a path has its pose from there, orthonormal already.
        for body in &mut world.bodies {
            if !matches!(body.motion, Motion::Prescribed(_)) {
                body.initial.pose = body.initial.pose.orthonormalised();
            }
        }
        Ok(world)
    }

    /// A world of bodies whose initial states are those of a time (s), to the bit.
    pub(super) fn starting_at(start: f64, bodies: Vec<Body>) -> Result<Self, WorldError> {
        check_finite("time of the initial state", &[start])?;
        let mut names = BTreeSet::new();
        for body in &bodies {
            body.check(start)?;
            if !names.insert(body.name()) {
                return Err(WorldError::DuplicateName(body.name().to_owned()));
            }
        }
        Ok(Self {
            bodies,
            gravity: Vector3::zeros(),
            controls: Vec::new(),
            start,
            forces: Arc::new(()),
            ignored: BTreeSet::new(),
            slip_tolerance: SLIP_TOLERANCE,
        })
    }
}

impl<F: Force> World<f64, F> {
    /// The same world with gravity (m/s²).
    ///
    /// # Errors
    /// If a component is not finite.
    pub fn with_gravity(mut self, gravity: Vector3<f64>) -> Result<Self, WorldError> {
        check_finite("gravity", gravity.as_slice())?;
        self.gravity = gravity;
        Ok(self)
    }

    /// The same world with these forces, in place of those it had: one, or a sum of several as a tuple or a list.
    ///
    /// # Errors
    /// If a force [cannot act](Force::check) on the bodies.
    pub fn with_forces<G: Force>(self, forces: G) -> Result<World<f64, G>, WorldError> {
        forces.check(&self.bodies)?;
        Ok(World {
            bodies: self.bodies,
            gravity: self.gravity,
            controls: self.controls,
            start: self.start,
            forces: Arc::new(forces),
            ignored: self.ignored,
            slip_tolerance: self.slip_tolerance,
        })
    }

    /// The same world with another initial state, at its own time. Bodies that forces do not move stay as they are: a fixed
    /// one where it was, one on a path where that is at the time.
    ///
    /// # Errors
    /// If the state has another number of bodies, a pose that is not rigid, or a number that is not finite, or a path is not
    /// finite at its time.
    pub fn starting_from(mut self, state: &State) -> Result<Self, WorldError> {
        state.check_fits(&self)?;
        let placed = self.placed(state.clone());
        self.start = placed.time;
        for (body, initial) in self.bodies.iter_mut().zip(placed.bodies) {
            body.initial = initial;
            body.check(self.start)?;
        }
        Ok(self)
    }

    /// The same world with a control, in place of one that its body may have had.
    ///
    /// # Errors
    /// If there is no such body, or forces do not move it.
    pub fn with_control(mut self, control: Control) -> Result<Self, WorldError> {
        let body = &self.bodies[self.index_of(control.body())?];
        if body.inertia().is_none() {
            return Err(WorldError::NotDynamic {
                body: body.name().to_owned(),
                quantity: "control",
            });
        }
        self.controls.retain(|other| other.body() != control.body());
        self.controls.push(control);
        Ok(self)
    }

    /// The same world, in which two bodies pass through each other.
    ///
    /// # Errors
    /// If there is no body of one of the names, or both are the same.
    pub fn ignoring(mut self, first: &str, second: &str) -> Result<Self, WorldError> {
        let (a, b) = (self.index_of(first)?, self.index_of(second)?);
        if a == b {
            return Err(WorldError::SameBody(first.to_owned()));
        }
        self.ignored.insert((a.min(b), a.max(b)));
        Ok(self)
    }

    /// The same world with another slip tolerance (m/s): see
    /// [`SurfaceLaw`](crate::contact::SurfaceLaw).
    ///
    /// # Errors
    /// If it is not positive and finite.
    pub fn with_slip_tolerance(mut self, slip_tolerance: f64) -> Result<Self, WorldError> {
        check_positive("slip tolerance", slip_tolerance)?;
        self.slip_tolerance = slip_tolerance;
        Ok(self)
    }

    /// The constant world: a world in `T` whose numbers have no derivatives.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> World<T, F> {
        World {
            bodies: self.bodies.iter().map(Body::lifted).collect(),
            gravity: lift_vector(&self.gravity),
            controls: self.controls.iter().map(Control::lifted).collect(),
            start: self.start,
            forces: Arc::clone(&self.forces),
            ignored: self.ignored.clone(),
            slip_tolerance: self.slip_tolerance,
        }
    }
}

impl<T: Scalar, F: Force> World<T, F> {
    /// The bodies.
    #[must_use]
    pub fn bodies(&self) -> &[Body<T>] {
        &self.bodies
    }

    /// Gravity (m/s²).
    #[must_use]
    pub fn gravity(&self) -> &Vector3<T> {
        &self.gravity
    }

    /// The place of the body of that name, in [`Self::bodies`] and in every state.
    ///
    /// # Errors
    /// If there is none.
    pub fn index_of(&self, name: &str) -> Result<usize, WorldError> {
        place_of(name, &self.bodies)
    }

    /// The controls.
    #[must_use]
    pub fn controls(&self) -> &[Control<T>] {
        &self.controls
    }

    /// The forces besides contact, gravity and controls.
    #[must_use]
    pub fn forces(&self) -> &F {
        &self.forces
    }

    /// The state from which rollouts start: at time 0, unless the world [starts from](Self::starting_from) another.
    #[must_use]
    pub fn initial_state(&self) -> State<T> {
        State {
            time: self.start,
            bodies: self.bodies.iter().map(|body| body.initial).collect(),
        }
    }

    /// Whether contacts of two bodies, i < j, count: not ignored, and not both without forces.
    pub(crate) fn may_touch(&self, i: usize, j: usize) -> bool {
        let moves = |index: usize| self.bodies[index].inertia().is_some();
        (moves(i) || moves(j)) && !self.ignored.contains(&(i, j))
    }

    /// A state with the bodies that forces do not move where they belong.
    pub(super) fn placed(&self, mut state: State<T>) -> State<T> {
        for (index, body) in state.bodies.iter_mut().enumerate() {
            if let Some(driven) = self.driven_state(index, state.time) {
                *body = driven;
            }
        }
        state
    }

    /// The state of a body that forces do not move.
    pub(super) fn driven_state(&self, index: usize, time: f64) -> Option<BodyState<T>> {
        match &self.bodies[index].motion {
            Motion::Dynamic(_) => None,
            Motion::Fixed => Some(self.bodies[index].initial),
            Motion::Prescribed(path) => Some(state_on(&**path, time).lifted()),
        }
    }
}
