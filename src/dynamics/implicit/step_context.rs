use super::about_centers::PairGeometry;
use super::island::Island;
use super::matrix::SymbolicCache;
use crate::contact::{ContactPair, FrozenContact, LinearizedContact};
use crate::dynamics::dyn_world::{BodyDual, DynForce};
use crate::dynamics::model::Model;
use crate::dynamics::motion::state_on;
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{Body, BodyState, Motion, State, TimeSpan};
use crate::geometry::Aabb;
use crate::spatial::Pose;
use nalgebra::Vector6;
use std::sync::atomic::{AtomicBool, Ordering};

/// World in `f64` during one time step.
pub(in crate::dynamics) struct StepContext<'a> {
    pub(super) model: &'a Model,
    pub(super) forces: &'a dyn DynForce,
    /// Model for the derivatives of forces, or `None` if there are no forces.
    pub(super) lifted: Option<&'a Model<BodyDual>>,
    /// Symbolic factors of earlier matrices.
    pub(super) symbolic_cache: &'a SymbolicCache,
    /// Groups of bodies that a force couples.
    pub(super) coupled: &'a [Vec<usize>],
    /// Time step.
    pub(super) span: TimeSpan,
    /// Weight and mean control of each body.
    pub(super) applied: Vec<Vector6<f64>>,
    /// States of all bodies at the start of the step.
    pub(super) start: &'a State,
    /// True once the step should end.
    stop: &'a AtomicBool,
}

impl<'a> StepContext<'a> {
    /// Creates the context of a time step.
    pub(super) fn new(
        (model, forces): (&'a Model, &'a dyn DynForce),
        (lifted, coupled, symbolic_cache): (
            Option<&'a Model<BodyDual>>,
            &'a [Vec<usize>],
            &'a SymbolicCache,
        ),
        start: &'a State,
        span: TimeSpan,
        stop: &'a AtomicBool,
    ) -> Self {
        Self {
            model,
            forces,
            lifted,
            symbolic_cache,
            coupled,
            span,
            applied: model.applied_wrenches(span),
            start,
            stop,
        }
    }

    /// Whether the step should end.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// States of the neighbors of an island at a time (s).
    pub(super) fn neighbors_at(&self, island: &Island, time: f64) -> Vec<BodyState> {
        let state = |&body: &usize| match &self.model.bodies[body].motion {
            Motion::Kinematic(path) => state_on(&**path, time),
            Motion::Fixed | Motion::Dynamic { .. } => self.start.bodies[body],
        };
        island.neighbors.iter().map(state).collect()
    }

    /// Pairs of participants that may touch, A first.
    pub(super) fn close_pairs<'s>(
        &self,
        island: &Island,
        states: &[BodyState],
        sweep: &'s mut Sweep,
    ) -> &'s [(usize, usize)] {
        let boxes = states.iter().enumerate();
        let boxes =
            boxes.map(|(participant, state)| self.bounds(island.body(participant), &state.pose));
        self.overlapping(island, boxes, sweep)
    }

    /// Pairs of participants whose boxes overlap and that may touch, A first.
    pub(super) fn overlapping<'s>(
        &self,
        island: &Island,
        boxes: impl Iterator<Item = Aabb>,
        sweep: &'s mut Sweep,
    ) -> &'s [(usize, usize)] {
        sweep.overlapping(boxes, |i, j| {
            let [first, second] = [i, j].map(|participant| island.body(participant));
            let (a, _) = self
                .model
                .ordered_pair(first.min(second), first.max(second))?;
            Some(if a == first { (i, j) } else { (j, i) })
        })
    }

    /// Extends the swept boxes by the boxes of the participants in these states.
    pub(super) fn sweep(&self, island: &Island, states: &[BodyState], swept: &mut Vec<Aabb>) {
        for (participant, state) in states.iter().enumerate() {
            let bounds = self.bounds(island.body(participant), &state.pose);
            match swept.get_mut(participant) {
                Some(all) => *all = all.union(&bounds),
                None => swept.push(bounds),
            }
        }
    }

    /// Bounding box of a body at a pose.
    pub(super) fn bounds(&self, body: usize, pose: &Pose) -> Aabb {
        self.model.bodies[body].shape.bounds_at(pose)
    }

    /// Smallest extent (m) of the bounding box of a body in its body frame, or zero for an
    /// unbounded body.
    pub(super) fn thickness(&self, body: usize) -> f64 {
        let extents = self.bounds(body, &Pose::identity()).half_extents() * 2.0;
        if extents.max().is_finite() {
            extents.min()
        } else {
            0.0
        }
    }

    /// Length (m) of a dynamic body for error control: its smallest extent. For a body without a shape, it is twice the radius of gyration
    /// about the origin of the body frame. A massless body without a shape has infinite length, because other bodies determine its motion.
    pub(super) fn length(&self, body: usize) -> f64 {
        let properties = &self.model.bodies[body];
        let inertia = properties.inertia().filter(|_| !properties.has_shape());
        let Some(inertia) = inertia else {
            return self.thickness(body);
        };
        let radius = inertia.radius_of_gyration_about_origin();
        if radius > 0.0 {
            2.0 * radius
        } else {
            f64::INFINITY
        }
    }

    /// Pair of two participants, A first, if they can have a contact.
    pub(super) fn pair<'s>(
        &'s self,
        island: &Island,
        bodies: [usize; 2],
        states: &'s [BodyState],
    ) -> Option<Pair<'s>> {
        let indices = bodies.map(|participant| island.body(participant));
        let states = bodies.map(|participant| &states[participant]);
        Some(Pair {
            bodies: indices.map(|index| &self.model.bodies[index]),
            states,
            contact: self.model.pair_of(indices, states)?,
        })
    }

    /// Geometry of two participants: maps between motions of their centers of mass and their contact.
    pub(super) fn geometry<'s>(
        &'s self,
        island: &Island,
        bodies: [usize; 2],
        states: &'s [BodyState],
    ) -> PairGeometry<'s> {
        PairGeometry::of(
            bodies.map(|participant| &self.model.bodies[island.body(participant)]),
            bodies.map(|participant| &states[participant]),
        )
    }
}

/// Two bodies that can have a contact.
pub(super) struct Pair<'s> {
    bodies: [&'s Body; 2],
    states: [&'s BodyState; 2],
    contact: ContactPair<'s>,
}

impl<'s> Pair<'s> {
    pub fn states(&self) -> [&'s BodyState; 2] {
        self.states
    }

    pub fn geometry(&self) -> PairGeometry<'s> {
        PairGeometry::of(self.bodies, self.states)
    }

    /// Contact with frozen polygons, or `None` if the bodies do not touch.
    pub fn frozen(&self) -> Option<FrozenContact> {
        self.contact.frozen()
    }

    /// Contact with all exact first derivatives.
    pub fn linearized(&self) -> LinearizedContact {
        self.contact.linearized()
    }
}
