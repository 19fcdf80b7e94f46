use super::about_centers::PairGeometry;
use super::island::Island;
use super::matrix::Patterns;
use crate::contact::{FrozenContact, LinearisedContact};
use crate::dynamics::any_world::{RealForces, Seeded};
use crate::dynamics::body::state_on;
use crate::dynamics::sweep::Sweep;
use crate::dynamics::system::System;
use crate::dynamics::{BodyState, Inertia, Motion};
use crate::geometry::Aabb;
use crate::spatial::Pose;
use nalgebra::Vector6;

/// A world in `f64`, in one of its steps.
pub(in crate::dynamics) struct Scene<'a> {
    pub(super) system: &'a System,
    pub(super) forces: &'a dyn RealForces,
    /// The system once more, for the derivatives of forces; none if there are no forces.
    pub(super) lifted: Option<&'a System<Seeded>>,
    /// Of matrices that were factorised before.
    pub(super) patterns: &'a Patterns,
    /// Bodies that a force holds together.
    pub(super) coupled: &'a [Vec<usize>],
    /// Weight and control of each body.
    pub(super) given: Vec<Vector6<f64>>,
    /// All bodies at the start of the step.
    pub(super) start: &'a [BodyState],
}

impl<'a> Scene<'a> {
    /// The controls are those of a time (s).
    pub(super) fn new(
        (system, forces): (&'a System, &'a dyn RealForces),
        (lifted, coupled, patterns): (Option<&'a System<Seeded>>, &'a [Vec<usize>], &'a Patterns),
        start: &'a [BodyState],
        control_time: f64,
    ) -> Self {
        Self {
            system,
            forces,
            lifted,
            patterns,
            coupled,
            given: system.given(control_time),
            start,
        }
    }

    /// Of an island's dynamic bodies.
    pub(super) fn inertias(&self, island: &Island) -> Vec<&'a Inertia> {
        let bodies = island.dynamic.iter();
        bodies
            .filter_map(|&body| self.system.bodies[body].inertia())
            .collect()
    }

    /// The states of an island's neighbors at a time (s).
    pub(super) fn neighbors_at(&self, island: &Island, time: f64) -> Vec<BodyState> {
        let state = |&body: &usize| match &self.system.bodies[body].motion {
            Motion::Prescribed(path) => state_on(&**path, time),
            Motion::Fixed | Motion::Dynamic(_) => self.start[body],
        };
        island.neighbors.iter().map(state).collect()
    }

    /// The pairs of participants that may touch: that of the smaller place in the world first.
    pub(super) fn close_pairs<'s>(
        &self,
        island: &Island,
        states: &[BodyState],
        sweep: &'s mut Sweep,
    ) -> &'s [(usize, usize)] {
        let system = self.system;
        let boxes = states.iter().enumerate();
        let boxes =
            boxes.map(|(participant, state)| self.bounds(island.body(participant), &state.pose));
        sweep.overlapping(boxes, |i, j| {
            let (i, j) = (island.body(i), island.body(j));
            system.may_touch(i.min(j), i.max(j))
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
        self.system.bodies[body].shape.tree().bounds().posed(pose)
    }

    /// Two participants that may touch.
    pub(super) fn pair<'s>(
        &'s self,
        island: &Island,
        bodies: [usize; 2],
        states: &'s [BodyState],
    ) -> Pair<'s> {
        Pair {
            system: self.system,
            places: bodies.map(|participant| island.body(participant)),
            states: bodies.map(|participant| &states[participant]),
        }
    }
}

/// Two bodies that may touch.
pub(super) struct Pair<'s> {
    system: &'s System,
    places: [usize; 2],
    states: [&'s BodyState; 2],
}

impl<'s> Pair<'s> {
    pub fn states(&self) -> [&'s BodyState; 2] {
        self.states
    }

    pub fn geometry(&self) -> PairGeometry<'s> {
        PairGeometry::of(
            self.places.map(|place| &self.system.bodies[place]),
            self.states,
        )
    }

    /// The contact as it is; none if the bodies do not touch.
    pub fn frozen(&self) -> Option<FrozenContact> {
        let moving = self.system.motion_of(self.places, self.states);
        let moving = moving.as_ref().map(|(law, twists)| (law, *twists));
        self.system.pair_of(self.places, self.states).frozen(moving)
    }

    /// The contact with all its first derivatives.
    pub fn linearised(&self) -> LinearisedContact {
        let moving = self.system.motion_of(self.places, self.states);
        let moving = moving.as_ref().map(|(law, twists)| (law, *twists));
        let pair = self.system.pair_of(self.places, self.states);
        pair.wrench_and_linearised(moving).1
    }
}
