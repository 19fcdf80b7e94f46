use super::body::{known_place, state_on};
use super::error::check_finite;
use super::{Body, BodyState, Control, Motion, State, WorldError};
use crate::scalar::{Scalar, lift_vector, real_vector};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Slip tolerance (m/s) of a new world.
const SLIP_TOLERANCE: f64 = 1e-3;

/// All of a [`World`](super::World) but its forces. What needs no force knows nothing of their type.
#[derive(Debug, Clone)]
pub(crate) struct System<T = f64> {
    pub bodies: Vec<Body<T>>,
    pub gravity: Vector3<T>,
    pub controls: Vec<Control<T>>,
    /// Time (s) of the initial state.
    pub(super) start: f64,
    pub(super) ignored: BTreeSet<(usize, usize)>,
    pub(super) slip_tolerance: f64,
}

impl System {
    /// Bodies whose initial states are those of a time (s), without gravity.
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
            ignored: BTreeSet::new(),
            slip_tolerance: SLIP_TOLERANCE,
        })
    }

    /// Checks all numbers that a parameter or another start may have changed.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let mut bodies = self.bodies.iter();
        bodies.try_for_each(|body| body.check(self.start))?;
        self.controls.iter().try_for_each(Control::check)?;
        check_finite("gravity", self.gravity.as_slice())
    }

    /// The constant system.
    pub(crate) fn lifted<T: Scalar>(&self) -> System<T> {
        System {
            bodies: self.bodies.iter().map(Body::lifted).collect(),
            gravity: lift_vector(&self.gravity),
            controls: self.controls.iter().map(Control::lifted).collect(),
            start: self.start,
            ignored: self.ignored.clone(),
            slip_tolerance: self.slip_tolerance,
        }
    }
}

impl<T: Scalar> System<T> {
    /// The system without derivatives.
    pub(super) fn real(&self) -> System {
        System {
            bodies: self.bodies.iter().map(Body::real).collect(),
            gravity: real_vector(&self.gravity),
            controls: self.controls.iter().map(Control::real).collect(),
            start: self.start,
            ignored: self.ignored.clone(),
            slip_tolerance: self.slip_tolerance,
        }
    }

    /// The place of the body of that name.
    pub(crate) fn index_of(&self, name: &str) -> Result<usize, WorldError> {
        known_place(name, &self.bodies)
    }

    /// The state from which rollouts start.
    pub(super) fn initial_state(&self) -> State<T> {
        State {
            time: self.start,
            bodies: self.bodies.iter().map(|body| body.initial).collect(),
        }
    }

    /// The places of the bodies that forces move.
    pub(crate) fn dynamic_bodies(&self) -> impl Iterator<Item = usize> {
        let places = 0..self.bodies.len();
        places.filter(|&index| self.bodies[index].inertia().is_some())
    }

    /// Whether contacts of two bodies, i < j, count: not ignored, and not both without forces.
    pub(crate) fn may_touch(&self, i: usize, j: usize) -> bool {
        let moves = |index: usize| self.bodies[index].inertia().is_some();
        (moves(i) || moves(j)) && !self.ignored.contains(&(i, j))
    }

    /// A state with the bodies that forces do not move where they belong.
    pub(super) fn placed(&self, mut state: State<T>) -> State<T> {
        self.place(&mut state);
        state
    }

    /// Puts the bodies that forces do not move where they belong.
    pub(super) fn place(&self, state: &mut State<T>) {
        for (index, body) in state.bodies.iter_mut().enumerate() {
            if let Some(driven) = self.driven_state(index, state.time) {
                *body = driven;
            }
        }
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
