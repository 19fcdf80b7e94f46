use super::about_centers::PairGeometry;
use super::island::Island;
use super::matrix::SymbolicCache;
use crate::contact::{ContactPair, FrozenContact, LinearizedContact};
use crate::dynamics::dyn_world::{BodyDual, DynForce};
use crate::dynamics::model::Model;
use crate::dynamics::motion::state_on;
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{Body, BodyState, Inertia, Motion, TimeSpan};
use crate::geometry::Aabb;
use crate::spatial::Pose;
use nalgebra::Vector6;
use std::sync::atomic::{AtomicBool, Ordering};

/// A world in `f64`, in one of its steps.
pub(in crate::dynamics) struct StepContext<'a> {
    pub(super) model: &'a Model,
    pub(super) forces: &'a dyn DynForce,
    /// The system once more, for the derivatives of forces; none if there are no forces.
    pub(super) lifted: Option<&'a Model<BodyDual>>,
    /// Of matrices that were factorized before.
    pub(super) symbolic_cache: &'a SymbolicCache,
    /// Bodies that a force holds together.
    pub(super) coupled: &'a [Vec<usize>],
    /// Weight and mean control of each body.
    pub(super) applied: Vec<Vector6<f64>>,
    /// All bodies at the start of the step.
    pub(super) start: &'a [BodyState],
    /// True once the step should end.
    stop: &'a AtomicBool,
}

impl<'a> StepContext<'a> {
    /// Creates the scene of a time step.
    pub(super) fn new(
        (model, forces): (&'a Model, &'a dyn DynForce),
        (lifted, coupled, symbolic_cache): (
            Option<&'a Model<BodyDual>>,
            &'a [Vec<usize>],
            &'a SymbolicCache,
        ),
        start: &'a [BodyState],
        span: TimeSpan,
        stop: &'a AtomicBool,
    ) -> Self {
        Self {
            model,
            forces,
            lifted,
            symbolic_cache,
            coupled,
            applied: model.applied_wrenches(span),
            start,
            stop,
        }
    }

    /// Whether the step should end.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Of an island's dynamic bodies.
    pub(super) fn inertias(&self, island: &Island) -> Vec<&'a Inertia> {
        let bodies = island.dynamic.iter();
        bodies
            .filter_map(|&body| self.model.bodies[body].inertia())
            .collect()
    }

    /// The states of an island's neighbors at a time (s).
    pub(super) fn neighbors_at(&self, island: &Island, time: f64) -> Vec<BodyState> {
        let state = |&body: &usize| match &self.model.bodies[body].motion {
            Motion::Kinematic(path) => state_on(&**path, time),
            Motion::Fixed | Motion::Dynamic(_) => self.start[body],
        };
        island.neighbors.iter().map(state).collect()
    }

    /// The pairs of participants that may touch, A first.
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

    /// The pairs of participants whose boxes overlap and that may touch, A first.
    pub(super) fn overlapping<'s>(
        &self,
        island: &Island,
        boxes: impl Iterator<Item = Aabb>,
        sweep: &'s mut Sweep,
    ) -> &'s [(usize, usize)] {
        sweep.overlapping(boxes, |i, j| {
            let [one, other] = [i, j].map(|participant| island.body(participant));
            let (a, _) = self.model.ordered_pair(one.min(other), one.max(other))?;
            Some(if a == one { (i, j) } else { (j, i) })
        })
    }

    /// Adds where participants are to where they have been.
    pub(super) fn sweep(&self, island: &Island, states: &[BodyState], swept: &mut Vec<Aabb>) {
        for (participant, state) in states.iter().enumerate() {
            let bounds = self.bounds(island.body(participant), &state.pose);
            match swept.get_mut(participant) {
                Some(all) => *all = all.union(&bounds),
                None => swept.push(bounds),
            }
        }
    }

    /// The box around a body.
    pub(super) fn bounds(&self, body: usize, pose: &Pose) -> Aabb {
        self.model.bodies[body].shape.bounds_at(pose)
    }

    /// The smallest extent (m) of the box around a body in its own axes; zero if the body has no bounds.
    pub(super) fn thickness(&self, body: usize) -> f64 {
        let extents = self.bounds(body, &Pose::identity()).half_extents() * 2.0;
        if extents.max().is_finite() {
            extents.min()
        } else {
            0.0
        }
    }

    /// Two participants that may touch, A first.
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

    /// How the motions of two participants count in their contact.
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

/// Two bodies that may touch.
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

    /// The contact as it is; none if the bodies do not touch.
    pub fn frozen(&self) -> Option<FrozenContact> {
        self.contact.frozen()
    }

    /// The contact with all its first derivatives.
    pub fn linearized(&self) -> LinearizedContact {
        self.contact.linearized()
    }
}
