//! An implicit step, backwards: the parts of each island as they were taken, the last first, and so the stages of each.
//!
//! A stage solves r = P(q̃ ⊕ τu, u) − p̃ − τf = 0 for the velocities u. With J = ∂r/∂u, the derivatives ū of a number by u become
//! those by −r, λ = J⁻ᵀū, and go on through all that r depends on while u stays. Later stages are made of the velocities of
//! those before them, and of the wrenches (P − p̃)/τ.

use super::contact::{Touching, WrenchCovector};
use super::pullback::{Here, Pullback};
use super::{Kink, StateGradient};
use crate::dynamics::implicit::{
    Island, Memory, Replay, ReplayedStage, ReplayedSubstep, Scheme, StepError, Trace,
    displaced_back,
};
use crate::dynamics::{BodyState, Inertia, State, TimeSpan};
use crate::spatial::Wrench;
use nalgebra::{Vector3, Vector6};
use std::mem;

/// Implicit steps.
pub(super) struct ImplicitSteps {
    scheme: &'static Scheme,
    time_step: f64,
    memory: Memory,
}

/// Derivatives by six numbers of each dynamic body of an island.
type BySix = Vec<Vector6<f64>>;

/// By what a stage gives to later ones.
#[derive(Clone)]
struct ByRates {
    velocities: BySix,
    wrenches: BySix,
}

/// By where a stage begins: poses by displacements about the centers of mass, momenta.
struct ByStart {
    poses: BySix,
    momenta: BySix,
}

impl ImplicitSteps {
    pub fn new(scheme: &'static Scheme, time_step: f64, memory: Memory) -> Self {
        Self {
            scheme,
            time_step,
            memory,
        }
    }

    /// Takes the step back that led on from a state along these ways of its islands.
    pub fn step_back(
        &self,
        pullback: &mut Pullback,
        before: &State,
        traces: &[Trace],
    ) -> Result<(), StepError> {
        let span = TimeSpan::new(before.time, self.time_step);
        let scene = self
            .memory
            .scene(pullback.world.real_forces(), &before.bodies, span);
        let mut back = StepBack {
            pullback,
            span,
            states: before.bodies.clone(),
            by_wrenches: vec![Wrench::zero(); before.bodies.len()],
        };
        traces.iter().try_for_each(|trace| {
            back.pullback.meet_unresolved(trace);
            let replay = Replay::new(&scene, trace, self.scheme, before.time);
            back.island_back(&replay, &before.bodies)
        })
    }
}

/// A step on the way back.
struct StepBack<'a, 'w> {
    pullback: &'a mut Pullback<'w>,
    /// The time step over which controls are averaged.
    span: TimeSpan,
    /// All bodies, those of an island as they are in its stage.
    states: Vec<BodyState>,
    /// By the wrench on each body, those of the island.
    by_wrenches: Vec<WrenchCovector>,
}

impl Pullback<'_> {
    /// Counts a kink for each body whose errors exceed their tolerances in an island's step.
    fn meet_unresolved(&mut self, trace: &Trace) {
        for body in trace.missed() {
            self.gradient.meet(Kink::Unresolved, &[body], self.step);
        }
    }
}

impl StepBack<'_, '_> {
    /// Takes an island back to the states that it started from.
    fn island_back(&mut self, replay: &Replay, start: &[BodyState]) -> Result<(), StepError> {
        let island = replay.island();
        for substep in replay.substeps().iter().rev() {
            self.substep_back(replay, substep)?;
        }
        for body in island.bodies() {
            self.states[body] = start[body];
        }
        Ok(())
    }

    /// From the states after a substep to those before it.
    fn substep_back(
        &mut self,
        replay: &Replay,
        substep: &ReplayedSubstep,
    ) -> Result<(), StepError> {
        let none = || vec![Vector6::zeros(); substep.from.len()];
        let mut start = ByStart {
            poses: none(),
            momenta: none(),
        };
        let no_rates = ByRates {
            velocities: none(),
            wrenches: none(),
        };
        let mut by_rates = vec![no_rates; substep.stages.len()];
        for stage in substep.stages.iter().rev() {
            let Some(own) = by_rates.pop() else {
                break;
            };
            let begun = self.stage_back(replay, stage, &own)?;
            for place in 0..substep.from.len() {
                let (by_pose, by_momentum) = (&begun.poses[place], &begun.momenta[place]);
                let [by_pose, by_displacement] =
                    displaced_back(&stage.start().displacements[place], by_pose);
                start.poses[place] += by_pose;
                start.momenta[place] += by_momentum;
                for (by_rates, time) in by_rates.iter_mut().zip(stage.stage.before()) {
                    by_rates.velocities[place] += by_displacement * time;
                    by_rates.wrenches[place] += by_momentum * time;
                }
            }
        }
        self.set_by_start(replay, substep, &start);
        Ok(())
    }

    /// Makes the derivatives by where the first stage begins those by the states before the substep.
    fn set_by_start(&mut self, replay: &Replay, substep: &ReplayedSubstep, start: &ByStart) {
        for (place, &body) in replay.island().dynamic.iter().enumerate() {
            let own = (replay.inertias()[place], &substep.from[place]);
            let [by_pose, by_twist] = self.pull_back_momentum(body, own, &start.momenta[place]);
            let about_center = StateGradient::from_parts([start.poses[place] + by_pose, by_twist]);
            let arm = self.pullback.system().arm(body, own.1);
            self.pullback.states[body] = about_center.about(&-arm);
            self.add_by_center(body, own.1, &about_center.shift);
        }
    }

    /// From where a stage leads, and what later ones take of it, to where it begins.
    fn stage_back(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        by_rates: &ByRates,
    ) -> Result<ByStart, StepError> {
        let duration = stage.start().duration;
        let bodies = || replay.island().dynamic.iter().copied().enumerate();
        let own = |place: usize| (replay.inertias()[place], &stage.states[place]);
        let displacement = |place: usize| stage.states[place].twist.to_vector() * duration;
        let (mut poses, mut by_velocities) = (Vec::new(), Vec::new());
        for (place, body) in bodies() {
            let by_gained = by_rates.wrenches[place] / duration;
            let [by_pose, by_twist] = self.take_by_state(body, own(place).1);
            let [more, by_velocity] = self.pull_back_momentum(body, own(place), &by_gained);
            let by_pose = by_pose + more;
            let [_, by_displacement] = displaced_back(&displacement(place), &by_pose);
            by_velocities.push(
                by_rates.velocities[place] + by_twist + by_velocity + by_displacement * duration,
            );
            poses.push(by_pose);
        }
        let by_lack = self.by_lack(replay, stage, &by_velocities)?;
        let mut momenta = Vec::new();
        for (place, body) in bodies() {
            let by_lack = &by_lack[place];
            let [by_momentum, _] = self.pull_back_momentum(body, own(place), &-by_lack);
            let [by_acting, _] = self.take_by_state(body, own(place).1);
            let by_pose = poses[place] + by_momentum + by_acting;
            [poses[place], _] = displaced_back(&displacement(place), &by_pose);
            momenta.push(by_lack - by_rates.wrenches[place] / duration);
        }
        Ok(ByStart { poses, momenta })
    }

    /// From the derivatives by the velocities of a stage to those by what its momenta lack, p̃ + τf − P; and from these through
    /// all wrenches f, at velocities that stay.
    fn by_lack(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        by_velocities: &[Vector6<f64>],
    ) -> Result<BySix, StepError> {
        let (island, system) = (replay.island(), self.pullback.system());
        for (participant, state) in stage.states.iter().enumerate() {
            self.states[island.body(participant)] = *state;
        }
        let participants = stage.close_pairs();
        let world = |participant: usize| island.body(participant);
        let pairs: Vec<_> = participants
            .iter()
            .map(|&(a, b)| (world(a), world(b)))
            .collect();
        let with_shapes = self.pullback.wants_shapes();
        let found = Touching::of_pairs(system, &self.states, &pairs, with_shapes);
        let found = participants.into_iter().zip(found);
        let (participants, contacts): (Vec<_>, Vec<_>) = found
            .filter_map(|((a, b), touching)| Some(([a, b], touching?)))
            .unzip();
        let linearized = contacts.iter().map(|touching| &touching.contact);
        let by_lack =
            stage.solve_transposed(participants.into_iter().zip(linearized), by_velocities)?;
        for (&body, by_lack) in island.dynamic.iter().zip(&by_lack) {
            let by_wrench = Wrench::from_vector(&(by_lack * stage.start().duration));
            self.add_by_weight(body, &by_wrench);
            self.by_wrenches[body] = by_wrench;
        }
        self.pull_back_wrenches(stage.start().time, island, &contacts);
        for &body in &island.dynamic {
            self.by_wrenches[body] = Wrench::zero();
        }
        Ok(by_lack)
    }

    fn pull_back_wrenches(&mut self, time: f64, island: &Island, contacts: &[Touching]) {
        let (system, forces) = (self.pullback.system(), &self.pullback.forces);
        let net = forces
            .as_ref()
            .map(|_| Touching::net_wrenches(contacts, system, &self.states));
        let here = Here {
            time,
            span: self.span,
            states: &self.states,
            bodies: &island.bodies().collect::<Vec<_>>(),
            contacts,
            net: &net.unwrap_or_default(),
        };
        self.pullback.pull_back_wrenches(here, &self.by_wrenches);
    }

    /// Adds what follows from the derivative by the wrench on a body, for its weight.
    fn add_by_weight(&mut self, body: usize, by_wrench: &WrenchCovector) {
        let system = self.pullback.system();
        if let Some(inertia) = system.bodies[body].inertia() {
            let gradient = &mut self.pullback.gradient;
            gradient.gravity += by_wrench.force * inertia.mass;
            gradient.bodies[body].mass += by_wrench.force.dot(&system.gravity);
        }
    }

    /// From the derivatives by the momenta of a body to those by its displacement and by its velocities.
    fn pull_back_momentum(
        &mut self,
        body: usize,
        (inertia, state): (&Inertia, &BodyState),
        by_momentum: &Vector6<f64>,
    ) -> [Vector6<f64>; 2] {
        let by_mass = inertia.momentum(state).dot(by_momentum) / inertia.mass;
        let by_angular = by_momentum.fixed_rows::<3>(0).into_owned();
        let (principal, rotation) = (&inertia.principal, state.pose.rotation());
        let by_inertia =
            principal.by_inertia_in_momentum(rotation, &by_angular, &state.twist.angular);
        let gradient = &mut self.pullback.gradient.bodies[body];
        gradient.mass += by_mass;
        gradient.inertia += by_inertia * inertia.mass;
        let slopes = inertia.momentum_slopes(state);
        slopes.map(|slopes| slopes.tr_mul(by_momentum))
    }

    /// The derivatives by the state of a body, which are then 0: by a displacement about the center of mass, and by the velocities.
    fn take_by_state(&mut self, body: usize, state: &BodyState) -> [Vector6<f64>; 2] {
        let arm = self.pullback.system().arm(body, state);
        let by_state = mem::replace(&mut self.pullback.states[body], StateGradient::zero());
        self.add_by_center(body, state, &-by_state.shift);
        by_state.about(&arm).parts()
    }

    /// Adds what follows from the derivative by the place of a body's center of mass, its origin staying where it is.
    fn add_by_center(&mut self, body: usize, state: &BodyState, by_place: &Vector3<f64>) {
        self.pullback.gradient.bodies[body].center += state.pose.rotation().tr_mul(by_place);
    }
}
