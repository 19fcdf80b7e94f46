use super::articulation::Articulation;
use super::body::require_index_of;
use super::joint::JointKind;
use super::loop_joint::{INITIAL_TOLERANCE, LATER_TOLERANCE};
use super::motion::state_on;
use super::multibody::{Kinematics, Link, LinkMimic, Loop, Multibody, Parent};
use super::validate::check_finite;
use super::{Body, BodyState, Control, Joint, LoopJoint, Motion, State, TimeSpan, WorldError};
use crate::scalar::{Scalar, lift, lift_vector, real_part, real_vector};
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Slip tolerance (m/s) of a new world.
const SLIP_TOLERANCE: f64 = 1e-3;

/// Duration (s) that stands for an instant in the mean of a scheduled torque and in the velocity of a scheduled target.
const INSTANT: f64 = 1e-6;

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
    articulation: Arc<Articulation>,
    pub(super) loop_joints: Arc<Vec<ResolvedLoop>>,
    /// Pairs of bodies that a loop joint connects, or that are welded to such bodies, the smaller index first.
    in_loops: Arc<BTreeSet<(usize, usize)>>,
    pub(super) slip_tolerance: f64,
}

/// Loop joint with the indices of its bodies.
#[derive(Debug, Clone)]
pub(super) struct ResolvedLoop {
    pub joint: LoopJoint,
    pub bodies: [usize; 2],
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
        let model = Self {
            articulation: Arc::new(Articulation::of(&bodies)?),
            bodies,
            gravity: Vector3::zeros(),
            controls: Vec::new(),
            force_parameters: Vec::new(),
            start,
            ignored: BTreeSet::new(),
            loop_joints: Arc::default(),
            in_loops: Arc::default(),
            slip_tolerance: SLIP_TOLERANCE,
        };
        model.check_inertia()?;
        Ok(model)
    }

    /// Checks that the mass matrix of the initial state is positive definite.
    fn check_inertia(&self) -> Result<(), WorldError> {
        let mut inertias = self.bodies.iter().filter_map(Body::inertia);
        if !self.has_joints() && inertias.all(|inertia| inertia.principal.is_of_solid()) {
            return Ok(());
        }
        let start = self.initial_state();
        // At coordinates so large that a pose overflows, the error is not about inertia.
        start.check_fits(&self.bodies)?;
        let (multibody, kinematics) = self.kinematics_at(&start);
        let factors = multibody.positive_mass_factors(&kinematics);
        factors.map(|_| ()).map_err(|link| {
            let body = multibody.links[link].body;
            WorldError::NoInertia(self.bodies[body].name().to_owned())
        })
    }

    /// Adds a loop joint, which may be open.
    pub(super) fn add_loop_joint(&mut self, joint: &LoopJoint) -> Result<(), WorldError> {
        joint.check()?;
        let [first, second] = joint.bodies();
        let bodies = [self.index_of(first)?, self.index_of(second)?];
        let is_dynamic = |index: &usize| self.bodies[*index].inertia().is_some();
        if bodies[0] == bodies[1] || !bodies.iter().any(is_dynamic) {
            return Err(WorldError::LoopBodies {
                joint: joint.name().to_owned(),
                bodies: joint.bodies().map(str::to_owned),
            });
        }
        let joints = self.bodies.iter().filter_map(Body::connecting_joint);
        let loops = self.loop_joints.iter().map(|existing| &existing.joint);
        let mut names = joints.map(Joint::name).chain(loops.map(LoopJoint::name));
        if names.any(|name| name == joint.name()) {
            return Err(WorldError::DuplicateJoint(joint.name().to_owned()));
        }
        let pairs = self.articulation.welded_pairs(bodies);
        Arc::make_mut(&mut self.in_loops).extend(pairs);
        let joint = joint.orthonormalized();
        Arc::make_mut(&mut self.loop_joints).push(ResolvedLoop { joint, bodies });
        Ok(())
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
        self.check_inertia()?;
        self.check_initial_loops()?;
        self.controls.iter().try_for_each(Control::check)?;
        let mut numbers = self.force_parameters.iter();
        numbers.try_for_each(|(_, value)| check_finite(FORCE_PARAMETER, &[*value]))?;
        check_finite("gravity", self.gravity.as_slice())
    }

    /// The model with another initial state and its time. Fixed and kinematic bodies have their prescribed states.
    ///
    /// # Errors
    /// If the state does not fit the model, a path is not finite at its time, or a loop joint is open.
    pub(crate) fn with_initial_state(mut self, state: &State) -> Result<Self, WorldError> {
        let placed = self.placed(state)?;
        self.start = placed.time;
        for (body, initial) in self.bodies.iter_mut().zip(placed.bodies) {
            (body.initial, body.start) = (initial, placed.time);
        }
        let joints = self
            .bodies
            .iter_mut()
            .filter_map(Body::joint_with_state_mut);
        for (joint, initial) in joints.zip(placed.joints) {
            joint.initial = initial;
        }
        self.check()?;
        Ok(self)
    }

    /// State in which fixed and kinematic bodies have their prescribed states, and bodies on joints have the states that their joints
    /// determine.
    pub(super) fn placed(&self, state: &State) -> Result<State, WorldError> {
        state.check_fits(&self.bodies)?;
        let placed = self.with_prescribed_states(state.clone());
        placed.check_fits(&self.bodies)?;
        Ok(placed)
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
            articulation: Arc::clone(&self.articulation),
            loop_joints: Arc::clone(&self.loop_joints),
            in_loops: Arc::clone(&self.in_loops),
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
            articulation: Arc::clone(&self.articulation),
            loop_joints: Arc::clone(&self.loop_joints),
            in_loops: Arc::clone(&self.in_loops),
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
        let parents = self.articulation.parents.iter().enumerate();
        parents.filter_map(|(body, parent)| Some((body, (*parent)?)))
    }

    /// Index of the state that determines the velocity of the joint of a body, and the multiplier of the velocity. Free and fixed joints have
    /// no such state.
    pub(super) fn state_of_joint(&self, body: usize) -> Option<(usize, f64)> {
        let indices = &self.articulation.state_indices;
        match self.articulation.mimics[body] {
            Some(mimic) => Some((indices[mimic.leader]?, mimic.multiplier)),
            None => Some((indices[body]?, 1.0)),
        }
    }

    /// Checks that loops are closed in the initial state.
    pub(super) fn check_initial_loops(&self) -> Result<(), WorldError> {
        if !self.has_loops() {
            return Ok(());
        }
        self.check_loops(&self.initial_state(), INITIAL_TOLERANCE)
    }

    /// Checks that loops are closed in a later state of a motion. The tolerance is above the errors of ordinary steps.
    pub(super) fn check_later_loops(&self, state: &State<T>) -> Result<(), WorldError> {
        self.check_loops(state, LATER_TOLERANCE)
    }

    /// Checks that loops are closed, with a tolerance (m and rad). The poses of bodies on joints must match the states of the joints.
    fn check_loops(&self, state: &State<T>, tolerance: f64) -> Result<(), WorldError> {
        let mut loops = self.loop_joints.iter();
        loops.try_for_each(|ResolvedLoop { joint, bodies }| {
            let poses = bodies.map(|body| state.bodies[body].pose.real());
            joint.check_closed(poses, tolerance)
        })
    }

    /// Whether the world has loop joints.
    pub(crate) fn has_loops(&self) -> bool {
        !self.loop_joints.is_empty()
    }

    /// Indices of the bodies of each loop joint.
    pub(super) fn loop_pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        self.loop_joints.iter().map(|joint| joint.bodies)
    }

    /// Name of the leader of the joint of a body, or `None` if the joint does not mimic.
    pub(crate) fn leader_name(&self, body: usize) -> Option<&str> {
        let leader = self.articulation.mimics[body]?.leader;
        self.bodies[leader].joint().map(Joint::name)
    }

    /// Indices of each body on a mimicking joint and of the body of its leader.
    pub(super) fn leaders(&self) -> impl Iterator<Item = (usize, usize)> {
        let mimics = self.articulation.mimics.iter().enumerate();
        mimics.filter_map(|(body, mimic)| Some((body, mimic.as_ref()?.leader)))
    }

    /// Index of the body on the named joint. It must be a ball joint if `is_ball` is true, and a revolute or prismatic joint otherwise.
    pub(crate) fn body_on(&self, joint: &str, is_ball: bool) -> Result<usize, WorldError> {
        let name_of = |body: &Body<T>| {
            let joint = body.connecting_joint()?;
            let is_of_kind = if is_ball {
                joint.kind == JointKind::Ball
            } else {
                joint.kind.is_scalar()
            };
            is_of_kind.then(|| joint.name.clone())
        };
        let names: Vec<Option<String>> = self.bodies.iter().map(name_of).collect();
        match names.iter().position(|name| name.as_deref() == Some(joint)) {
            Some(body) => Ok(body),
            None => Err(WorldError::UnknownJoint {
                kind: if is_ball {
                    "ball joint"
                } else {
                    "revolute or prismatic joint"
                },
                name: joint.to_owned(),
                known: names.into_iter().flatten().collect(),
            }),
        }
    }

    /// Index of the state of the joint of a body, or `None` for a free, fixed or mimicking joint.
    pub(crate) fn joint_state_index(&self, body: usize) -> Option<usize> {
        self.articulation.state_indices[body]
    }

    /// Returns an error if the world has joints. `quantity` is the requested quantity.
    pub(super) fn refuse_joints(&self, quantity: &'static str) -> Result<(), WorldError> {
        match self.body_on_joint() {
            Some(body) => Err(WorldError::OnJoint {
                body: body.name().to_owned(),
                quantity,
            }),
            None => Ok(()),
        }
    }

    /// First body on a joint, or dynamic body of a loop joint.
    pub(super) fn body_on_joint(&self) -> Option<&Body<T>> {
        let body = self.bodies.iter().find(|body| body.is_on_joint());
        body.or_else(|| {
            let [first, second] = self.loop_pairs().next()?;
            let is_dynamic = self.bodies[first].inertia().is_some();
            Some(&self.bodies[if is_dynamic { first } else { second }])
        })
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

    /// Multibody of dynamic bodies during a time step. `neighbors` contains their fixed and kinematic parents. Both lists are in increasing
    /// order.
    pub(super) fn multibody(
        &self,
        [dynamic, neighbors]: [&[usize]; 2],
        step: TimeSpan,
    ) -> Multibody<T> {
        let parent_of = |body: usize| {
            let parent = self.articulation.parents[body]?;
            let link = dynamic.binary_search(&parent).map(Parent::Link);
            link.or_else(|_| neighbors.binary_search(&parent).map(Parent::Neighbor))
                .ok()
        };
        let links = dynamic.iter().filter_map(|&body| {
            let Motion::Dynamic { inertia, joint } = &self.bodies[body].motion else {
                return None;
            };
            let parent = parent_of(body).unwrap_or(Parent::World);
            let law = joint.law_during(step);
            let mimic = self.articulation.mimics[body].and_then(|mimic| {
                Some(LinkMimic {
                    leader: dynamic.binary_search(&mimic.leader).ok()?,
                    multiplier: mimic.multiplier,
                    offset: mimic.offset,
                })
            });
            Some(Link {
                state_index: self.articulation.state_indices[body],
                mimic,
                ..Link::new(body, *inertia, (&**joint, law), parent)
            })
        });
        let participant = |body: usize| {
            let link = dynamic.binary_search(&body);
            let neighbor = |index| dynamic.len() + index;
            link.or_else(|_| neighbors.binary_search(&body).map(neighbor))
                .ok()
        };
        let loops = self
            .loop_joints
            .iter()
            .filter_map(|ResolvedLoop { joint, bodies }| {
                let [first, second] = bodies.map(participant);
                Some(Loop {
                    participants: [first?, second?],
                    frames: *joint.frames(),
                    constraints: joint.constraints(),
                    multipliers: 0..0,
                })
            });
        Multibody::new(links.collect(), neighbors).with_loops(loops)
    }

    /// Sets the bodies on joints to the states that their joints give. Other bodies must have their states.
    pub(super) fn place_joints(&self, state: &mut State<T>) {
        if self.has_joints() {
            let (multibody, kinematics) = self.kinematics_at(state);
            multibody.store(&kinematics, state);
        }
    }

    /// All dynamic bodies of the world with their kinematics.
    pub(super) fn kinematics_at(&self, state: &State<T>) -> (Multibody<T>, Kinematics<T>) {
        let is_dynamic = |body: &usize| self.bodies[*body].inertia().is_some();
        let (dynamic, neighbors): (Vec<usize>, Vec<usize>) =
            (0..self.bodies.len()).partition(is_dynamic);
        let now = TimeSpan::new(state.time, INSTANT);
        let multibody = self.multibody([&dynamic, &neighbors], now);
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
        self.bodies[index].has_mesh()
    }

    /// Whether the contact of two bodies, i < j, has an effect: both have shapes, one of them is dynamic, and the pair is not ignored.
    fn can_interact(&self, i: usize, j: usize) -> bool {
        let moves = |index: usize| self.bodies[index].inertia().is_some();
        let has_shape = |index: usize| self.bodies[index].has_shape();
        let is_excluded = self.ignored.contains(&(i, j))
            || self.articulation.adjacent.contains(&(i, j))
            || self.in_loops.contains(&(i, j));
        (moves(i) || moves(j)) && has_shape(i) && has_shape(j) && !is_excluded
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
