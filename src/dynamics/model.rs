use super::body::require_index_of;
use super::joint::{Joint, JointKind};
use super::motion::state_on;
use super::multibody::{Kinematics, Multibody, Parent};
use super::validate::check_finite;
use super::{Body, BodyState, Control, Motion, State, WorldError};
use crate::scalar::{Scalar, lift, lift_vector, real_part, real_vector};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Slip tolerance (m/s) of a new world.
const SLIP_TOLERANCE: f64 = 1e-3;

/// Name of a force parameter in error messages.
pub(super) const FORCE_PARAMETER: &str = "force parameter";

/// Everything in a [`World`](super::World) but the forces. Code that needs no forces does not depend on their type.
#[derive(Debug, Clone)]
pub(crate) struct Model<T = f64> {
    pub bodies: Vec<Body<T>>,
    pub gravity: Vector3<T>,
    pub controls: Vec<Control<T>>,
    /// Names and values of the force parameters.
    pub force_parameters: Vec<(String, T)>,
    /// Time (s) of the initial state.
    pub(crate) start: f64,
    pub(super) ignored: BTreeSet<(usize, usize)>,
    /// Pairs of bodies that a joint connects, or that are welded to such bodies, the smaller index first.
    adjacent: BTreeSet<(usize, usize)>,
    pub(super) slip_tolerance: f64,
}

impl Model {
    /// Model of bodies whose initial state is at a time (s), without gravity.
    pub(super) fn starting_at(start: f64, mut bodies: Vec<Body>) -> Result<Self, WorldError> {
        check_finite("time of the initial state", &[start])?;
        let mut names = BTreeSet::new();
        for body in &mut bodies {
            // Check before the move, because the move would hide a start that is not on the path.
            body.check()?;
            body.start_at(start);
            body.check()?;
            if !names.insert(body.name.clone()) {
                return Err(WorldError::DuplicateName(body.name.clone()));
            }
        }
        check_joints(&bodies)?;
        Ok(Self {
            adjacent: adjacent_pairs(&bodies),
            bodies,
            gravity: Vector3::zeros(),
            controls: Vec::new(),
            force_parameters: Vec::new(),
            start,
            ignored: BTreeSet::new(),
            slip_tolerance: SLIP_TOLERANCE,
        })
    }

    /// Checks that at least one body of each pair that can interact has a mesh.
    pub(super) fn check_partners(&self) -> Result<(), WorldError> {
        // Only pairs of bodies without a mesh can fail.
        let indices = 0..self.bodies.len();
        let meshless: Vec<usize> = indices.filter(|&index| !self.has_mesh(index)).collect();
        for (position, &j) in meshless.iter().enumerate() {
            let mut others = meshless[..position].iter();
            if let Some(&i) = others.find(|&&i| self.can_interact(i, j)) {
                let name = |index: usize| self.bodies[index].name().to_owned();
                return Err(WorldError::NoContact([name(i), name(j)]));
            }
        }
        Ok(())
    }

    /// Checks all numbers that a parameter or a new initial state may have changed.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let mut bodies = self.bodies.iter();
        bodies.try_for_each(Body::check)?;
        self.controls.iter().try_for_each(Control::check)?;
        let mut numbers = self.force_parameters.iter();
        numbers.try_for_each(|(_, value)| check_finite(FORCE_PARAMETER, &[*value]))?;
        check_finite("gravity", self.gravity.as_slice())
    }

    /// The model with zero derivatives.
    pub(crate) fn lifted<T: Scalar>(&self) -> Model<T> {
        Model {
            bodies: self.bodies.iter().map(Body::lifted).collect(),
            gravity: lift_vector(&self.gravity),
            controls: self.controls.iter().map(Control::lifted).collect(),
            force_parameters: self.force_parameters_by(|value| lift(value)),
            start: self.start,
            ignored: self.ignored.clone(),
            adjacent: self.adjacent.clone(),
            slip_tolerance: self.slip_tolerance,
        }
    }
}

impl<T: Scalar> Model<T> {
    /// The model without derivatives.
    pub(super) fn real(&self) -> Model {
        Model {
            bodies: self.bodies.iter().map(Body::real).collect(),
            gravity: real_vector(&self.gravity),
            controls: self.controls.iter().map(Control::real).collect(),
            force_parameters: self.force_parameters_by(real_part),
            start: self.start,
            ignored: self.ignored.clone(),
            adjacent: self.adjacent.clone(),
            slip_tolerance: self.slip_tolerance,
        }
    }

    /// The force parameters with converted values.
    fn force_parameters_by<U>(&self, convert: impl Fn(T) -> U) -> Vec<(String, U)> {
        let numbers = self.force_parameters.iter();
        numbers
            .map(|(name, value)| (name.clone(), convert(*value)))
            .collect()
    }

    /// Index of the body with this name.
    pub(crate) fn index_of(&self, name: &str) -> Result<usize, WorldError> {
        require_index_of(name, &self.bodies)
    }

    /// Initial state of rollouts.
    pub(super) fn initial_state(&self) -> State<T> {
        let joints = self.bodies.iter().filter_map(Body::joint_with_state);
        let mut state = State {
            time: self.start,
            bodies: self.bodies.iter().map(|body| body.initial).collect(),
            joints: joints.map(|joint| joint.initial).collect(),
        };
        self.place_joints(&mut state);
        state
    }

    /// Bodies on joints with their parents. Bodies whose parent is the world are omitted.
    pub(super) fn parents(&self) -> impl Iterator<Item = (usize, usize)> {
        let bodies = self.bodies.iter().enumerate();
        bodies.filter_map(|(index, body)| {
            let parent = body.joint().and_then(Joint::parent)?;
            Some((index, self.index_of(parent).ok()?))
        })
    }

    /// Index of the body on a revolute or prismatic joint, and index of the state of the joint.
    pub(crate) fn scalar_joint(&self, name: &str) -> Result<(usize, usize), WorldError> {
        let with_state =
            |(index, body): (usize, &'_ Body<T>)| body.joint_with_state().map(|_| index);
        let bodies: Vec<usize> = self
            .bodies
            .iter()
            .enumerate()
            .filter_map(with_state)
            .collect();
        let joint = |body: usize| self.bodies[body].joint_with_state();
        let scalar_joint =
            |body: usize| joint(body).filter(|joint| joint.initial.position().is_some());
        let is_named = |&body: &usize| scalar_joint(body).is_some_and(|joint| joint.name == name);
        if let Some(state_index) = bodies.iter().position(is_named) {
            return Ok((bodies[state_index], state_index));
        }
        let scalar = bodies.iter().filter_map(|&body| scalar_joint(body));
        Err(WorldError::UnknownJoint {
            name: name.to_owned(),
            known: scalar.map(|joint| joint.name.clone()).collect(),
        })
    }

    /// Returns an error if the world has joints.
    pub(super) fn refuse_joints(&self) -> Result<(), WorldError> {
        match self.bodies.iter().find(|body| body.is_on_joint()) {
            Some(body) => Err(WorldError::NoCoordinates(body.name().to_owned())),
            None => Ok(()),
        }
    }

    /// Number of joints that are neither free nor fixed.
    pub(crate) fn joint_count(&self) -> usize {
        self.bodies
            .iter()
            .filter_map(Body::joint_with_state)
            .count()
    }

    /// Whether a body is on a joint.
    pub(crate) fn has_joints(&self) -> bool {
        self.bodies.iter().any(Body::is_on_joint)
    }

    /// Generalized coordinates of dynamic bodies, in increasing order. `neighbors` has their parents that are not dynamic.
    pub(super) fn multibody(&self, dynamic: &[usize], neighbors: &[usize]) -> Multibody<T> {
        let mut next_state = 0;
        let state_indices = self.bodies.iter().map(|body| {
            let index = next_state;
            next_state += usize::from(body.joint_with_state().is_some());
            index
        });
        let state_indices: Vec<usize> = state_indices.collect();
        let links = dynamic.iter().filter_map(|&body| {
            let Motion::Dynamic { inertia, joint } = &self.bodies[body].motion else {
                return None;
            };
            let parent = joint
                .parent
                .as_ref()
                .and_then(|name| self.index_of(name).ok());
            let parent = parent.map_or(Parent::World, |parent| {
                let index_in =
                    |indices: &[usize]| indices.iter().position(|&index| index == parent);
                match (index_in(dynamic), index_in(neighbors)) {
                    (Some(link), _) => Parent::Link(link),
                    (None, Some(neighbor)) => Parent::Neighbor(neighbor),
                    (None, None) => Parent::World,
                }
            });
            Some((body, state_indices[body], *inertia, &**joint, parent))
        });
        Multibody::new(links, neighbors)
    }

    /// Sets the bodies on joints to the states that their joints give. Other bodies must have their states.
    fn place_joints(&self, state: &mut State<T>) {
        if self.has_joints() {
            let (multibody, kinematics) = self.kinematics_at(state);
            multibody.store(&kinematics, state);
        }
    }

    /// All dynamic bodies of the world with their kinematics.
    pub(super) fn kinematics_at(&self, state: &State<T>) -> (Multibody<T>, Kinematics<T>) {
        let dynamic: Vec<usize> = self.dynamic_bodies().collect();
        let indices = 0..self.bodies.len();
        let neighbors: Vec<usize> = indices.filter(|index| !dynamic.contains(index)).collect();
        let multibody = self.multibody(&dynamic, &neighbors);
        let states: Vec<_> = neighbors.iter().map(|&body| state.bodies[body]).collect();
        let kinematics = multibody.kinematics(multibody.coordinates(state), &states);
        (multibody, kinematics)
    }

    /// Indices of the dynamic bodies.
    pub(crate) fn dynamic_bodies(&self) -> impl Iterator<Item = usize> {
        let indices = 0..self.bodies.len();
        indices.filter(|&index| self.bodies[index].inertia().is_some())
    }

    /// Bodies A and B of the contact of two bodies, i < j. Returns `None` unless the pair is not ignored, one of the bodies is dynamic, and
    /// A is compliant with a mesh. Only this method decides which pairs can collide and which body is A.
    pub(crate) fn ordered_pair(&self, i: usize, j: usize) -> Option<(usize, usize)> {
        if !self.can_interact(i, j) {
            return None;
        }
        match (self.has_mesh(i), self.has_mesh(j)) {
            (true, _) => Some((i, j)),
            (false, true) => Some((j, i)),
            (false, false) => None,
        }
    }

    fn has_mesh(&self, index: usize) -> bool {
        self.bodies[index].shape.compliant().is_some()
    }

    /// Whether the contact of two bodies, i < j, has an effect: one of them is dynamic, and the pair is not ignored.
    fn can_interact(&self, i: usize, j: usize) -> bool {
        let moves = |index: usize| self.bodies[index].inertia().is_some();
        let is_excluded = self.ignored.contains(&(i, j)) || self.adjacent.contains(&(i, j));
        (moves(i) || moves(j)) && !is_excluded
    }

    /// Returns the state with fixed and kinematic bodies in their prescribed states, and bodies on joints where their joints put them.
    pub(super) fn with_prescribed_states(&self, mut state: State<T>) -> State<T> {
        self.set_prescribed_states(&mut state);
        self.place_joints(&mut state);
        state
    }

    /// Sets fixed and kinematic bodies to their prescribed states.
    pub(super) fn set_prescribed_states(&self, state: &mut State<T>) {
        for (index, body) in state.bodies.iter_mut().enumerate() {
            if let Some(driven) = self.prescribed_state(index, state.time) {
                *body = driven;
            }
        }
    }

    /// State of a fixed or kinematic body at a time (s), or `None` for a dynamic body.
    pub(super) fn prescribed_state(&self, index: usize, time: f64) -> Option<BodyState<T>> {
        match &self.bodies[index].motion {
            Motion::Dynamic { .. } => None,
            Motion::Fixed => Some(self.bodies[index].initial),
            Motion::Kinematic(path) => Some(state_on(&**path, time).lifted()),
        }
    }
}

/// Checks the names, the parents and the numbers of joints.
fn check_joints(bodies: &[Body]) -> Result<(), WorldError> {
    let mut names = BTreeSet::new();
    for (index, body) in bodies.iter().enumerate() {
        let Some(joint) = body.joint().filter(|_| body.is_on_joint()) else {
            continue;
        };
        if !names.insert(&joint.name) {
            return Err(WorldError::DuplicateJoint(joint.name.clone()));
        }
        if let Some(parent) = &joint.parent {
            let is_parent = |candidate: &Body| candidate.name() == parent;
            if !bodies[..index].iter().any(is_parent) {
                return Err(WorldError::JointParent {
                    joint: joint.name.clone(),
                    body: body.name().to_owned(),
                    parent: parent.clone(),
                });
            }
        }
    }
    Ok(())
}

/// Pairs of bodies, the smaller index first, that a joint connects, or that are welded to such bodies.
fn adjacent_pairs(bodies: &[Body]) -> BTreeSet<(usize, usize)> {
    let parent_of = |body: &Body| {
        let parent = body.joint().and_then(Joint::parent)?;
        bodies
            .iter()
            .position(|candidate| candidate.name() == parent)
    };
    // Welded bodies have the same root. Parents come before children.
    let mut roots: Vec<usize> = (0..bodies.len()).collect();
    let mut connected = BTreeSet::new();
    for (index, body) in bodies.iter().enumerate() {
        let Some(parent) = parent_of(body) else {
            continue;
        };
        if body
            .joint()
            .is_some_and(|joint| joint.kind == JointKind::Fixed)
        {
            roots[index] = roots[parent];
        } else {
            connected.insert((roots[parent], index));
        }
    }
    let mut pairs = BTreeSet::new();
    for (i, &first) in roots.iter().enumerate() {
        for (j, &second) in roots.iter().enumerate().skip(i + 1) {
            let is_connected = |a: usize, b: usize| connected.contains(&(a, b));
            if first == second || is_connected(first, second) || is_connected(second, first) {
                pairs.insert((i, j));
            }
        }
    }
    pairs
}
