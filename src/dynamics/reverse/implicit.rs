//! Adjoint of an implicit step: reverses the substeps of each island as they were accepted, the last one first, and the stages of each
//! substep.
//!
//! A stage solves r = P(q̃ ⊕ τu, u) − p̃ − τf = 0 for the velocities u. With J = ∂r/∂u, the gradient ū with respect to u becomes the
//! gradient with respect to −r, λ = J⁻ᵀū. It propagates through all other inputs of r at constant u. Later stages depend on the velocities
//! of the earlier stages and on their wrenches (P − p̃)/τ.

use super::linearized_pair::{LinearizedPair, WrenchGradient};
use super::pullback::{EvaluationPoint, Pullback};
use super::{Kink, StateGradient};
use crate::dynamics::implicit::{
    ImplicitIntegratorState, Island, IslandRecord, Replay, ReplayedStage, ReplayedSubstep, Scheme,
    StepError, displaced_back,
};
use crate::dynamics::{BodyState, Inertia, State, TimeSpan};
use crate::spatial::Wrench;
use nalgebra::{Vector3, Vector6};
use std::mem;

/// Adjoint of implicit steps.
pub(super) struct ImplicitSteps {
    scheme: &'static Scheme,
    time_step: f64,
    integrator_state: ImplicitIntegratorState,
}

/// One 6-vector for each dynamic body of an island.
type BodyVectors = Vec<Vector6<f64>>;

/// Gradient with respect to the rates that a stage passes to later stages.
#[derive(Clone)]
struct RateGradient {
    velocities: BodyVectors,
    wrenches: BodyVectors,
}

/// Gradient with respect to the start of a stage: to poses, as displacements about the centers of mass, and to momenta.
struct StartGradient {
    poses: BodyVectors,
    momenta: BodyVectors,
}

impl ImplicitSteps {
    pub fn new(
        scheme: &'static Scheme,
        time_step: f64,
        integrator_state: ImplicitIntegratorState,
    ) -> Self {
        Self {
            scheme,
            time_step,
            integrator_state,
        }
    }

    /// Reverses the step that began at a state, along the records of its islands.
    pub fn step_back(
        &self,
        pullback: &mut Pullback,
        before: &State,
        island_records: &[IslandRecord],
    ) -> Result<(), StepError> {
        let span = TimeSpan::new(before.time, self.time_step);
        let context =
            self.integrator_state
                .context(pullback.world.real_forces(), &before.bodies, span);
        let mut back = StepBack {
            pullback,
            span,
            states: before.bodies.clone(),
            by_wrenches: vec![Wrench::zero(); before.bodies.len()],
        };
        island_records.iter().try_for_each(|record| {
            back.pullback.record_unresolved(record);
            let replay = Replay::new(&context, record, self.scheme, before.time);
            back.island_back(&replay, &before.bodies)
        })
    }
}

/// State of the reversal of one step.
struct StepBack<'a, 'w> {
    pullback: &'a mut Pullback<'w>,
    /// Time step over which controls are averaged.
    span: TimeSpan,
    /// States of all bodies. The bodies of the current island have their states in the current stage.
    states: Vec<BodyState>,
    /// Gradient with respect to the wrench on each body of the current island.
    by_wrenches: Vec<WrenchGradient>,
}

impl Pullback<'_> {
    /// Records a kink for each body whose errors exceed their tolerances in the step of an island.
    fn record_unresolved(&mut self, record: &IslandRecord) {
        for body in record.missed() {
            self.gradient
                .record_kink(Kink::Unresolved, &[body], self.step);
        }
    }
}

impl StepBack<'_, '_> {
    /// Reverses the step of an island to the states at its start.
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

    /// Propagates the gradient from the states after a substep to the states before it.
    fn substep_back(
        &mut self,
        replay: &Replay,
        substep: &ReplayedSubstep,
    ) -> Result<(), StepError> {
        let zeros = || vec![Vector6::zeros(); substep.from.len()];
        let mut start = StartGradient {
            poses: zeros(),
            momenta: zeros(),
        };
        let no_rates = RateGradient {
            velocities: zeros(),
            wrenches: zeros(),
        };
        let mut by_rates = vec![no_rates; substep.stages.len()];
        for stage in substep.stages.iter().rev() {
            let Some(stage_rates) = by_rates.pop() else {
                break;
            };
            let by_start = self.stage_back(replay, stage, &stage_rates)?;
            for index in 0..substep.from.len() {
                let (by_pose, by_momentum) = (&by_start.poses[index], &by_start.momenta[index]);
                let [by_pose, by_displacement] =
                    displaced_back(&stage.start().displacements[index], by_pose);
                start.poses[index] += by_pose;
                start.momenta[index] += by_momentum;
                for (by_rates, time) in by_rates.iter_mut().zip(stage.stage.before()) {
                    by_rates.velocities[index] += by_displacement * time;
                    by_rates.wrenches[index] += by_momentum * time;
                }
            }
        }
        self.set_by_start(replay, substep, &start);
        Ok(())
    }

    /// Sets the gradient with respect to the states before the substep, from the gradient with respect to the start of the first stage.
    fn set_by_start(&mut self, replay: &Replay, substep: &ReplayedSubstep, start: &StartGradient) {
        for (index, &body) in replay.island().dynamic.iter().enumerate() {
            let (inertia, state) = (replay.inertias()[index], &substep.from[index]);
            let [by_pose, by_twist] =
                self.pull_back_momentum(body, (inertia, state), &start.momenta[index]);
            let about_center = StateGradient::from_parts([start.poses[index] + by_pose, by_twist]);
            let arm = self.pullback.model().arm(body, state);
            self.pullback.states[body] = about_center.about(&-arm);
            self.add_by_center(body, state, &about_center.shift);
        }
    }

    /// Propagates the gradient with respect to the end of a stage, and to the rates that later stages use, to the start of the stage.
    fn stage_back(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        by_rates: &RateGradient,
    ) -> Result<StartGradient, StepError> {
        let duration = stage.start().duration;
        let bodies = || replay.island().dynamic.iter().copied().enumerate();
        let body_in_stage = |index: usize| (replay.inertias()[index], &stage.states[index]);
        let displacement = |index: usize| stage.states[index].twist.to_vector() * duration;
        let (mut poses, mut by_velocities) = (Vec::new(), Vec::new());
        for (index, body) in bodies() {
            let by_impulse = by_rates.wrenches[index] / duration;
            let [by_pose, by_twist] = self.take_state_gradient(body, body_in_stage(index).1);
            let [more, by_velocity] =
                self.pull_back_momentum(body, body_in_stage(index), &by_impulse);
            let by_pose = by_pose + more;
            let [_, by_displacement] = displaced_back(&displacement(index), &by_pose);
            by_velocities.push(
                by_rates.velocities[index] + by_twist + by_velocity + by_displacement * duration,
            );
            poses.push(by_pose);
        }
        let adjoints = self.solve_adjoint(replay, stage, &by_velocities)?;
        let mut momenta = Vec::new();
        for (index, body) in bodies() {
            let adjoint = &adjoints[index];
            let [by_momentum, _] = self.pull_back_momentum(body, body_in_stage(index), &-adjoint);
            let [by_forces, _] = self.take_state_gradient(body, body_in_stage(index).1);
            let by_pose = poses[index] + by_momentum + by_forces;
            [poses[index], _] = displaced_back(&displacement(index), &by_pose);
            momenta.push(adjoint - by_rates.wrenches[index] / duration);
        }
        Ok(StartGradient { poses, momenta })
    }

    /// Solves the adjoint equation of a stage for λ, the gradient with respect to p̃ + τf − P. Then propagates λ through all wrenches f at
    /// constant velocities.
    fn solve_adjoint(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        by_velocities: &[Vector6<f64>],
    ) -> Result<BodyVectors, StepError> {
        let (island, model) = (replay.island(), self.pullback.model());
        for (participant, state) in stage.states.iter().enumerate() {
            self.states[island.body(participant)] = *state;
        }
        let participants = stage.close_pairs();
        let body = |participant: usize| island.body(participant);
        let pairs: Vec<_> = participants
            .iter()
            .map(|&(a, b)| (body(a), body(b)))
            .collect();
        let with_shapes = self.pullback.wants_shapes();
        let pairs = LinearizedPair::of_pairs(model, &self.states, &pairs, with_shapes);
        let touching = participants.into_iter().zip(pairs);
        let (participants, contacts): (Vec<_>, Vec<_>) = touching
            .filter_map(|((a, b), pair)| Some(([a, b], pair?)))
            .unzip();
        let linearized = contacts.iter().map(|pair| &pair.contact);
        let adjoints =
            stage.solve_transposed(participants.into_iter().zip(linearized), by_velocities)?;
        for (&body, adjoint) in island.dynamic.iter().zip(&adjoints) {
            let by_wrench = Wrench::from_vector(&(adjoint * stage.start().duration));
            self.add_by_weight(body, &by_wrench);
            self.by_wrenches[body] = by_wrench;
        }
        self.pull_back_wrenches(stage.start().time, island, &contacts);
        for &body in &island.dynamic {
            self.by_wrenches[body] = Wrench::zero();
        }
        Ok(adjoints)
    }

    fn pull_back_wrenches(&mut self, time: f64, island: &Island, contacts: &[LinearizedPair]) {
        let (model, forces) = (self.pullback.model(), &self.pullback.forces);
        let net = forces
            .as_ref()
            .map(|_| LinearizedPair::net_wrenches(contacts, model, &self.states));
        let point = EvaluationPoint {
            time,
            span: self.span,
            states: &self.states,
            bodies: &island.bodies().collect::<Vec<_>>(),
            contacts,
            net: &net.unwrap_or_default(),
        };
        self.pullback.pull_back_wrenches(point, &self.by_wrenches);
    }

    /// Propagates the gradient with respect to the wrench on a body to gravity and mass, through its weight.
    fn add_by_weight(&mut self, body: usize, by_wrench: &WrenchGradient) {
        let model = self.pullback.model();
        if let Some(inertia) = model.bodies[body].inertia() {
            let gradient = &mut self.pullback.gradient;
            gradient.gravity += by_wrench.force * inertia.mass;
            gradient.bodies[body].mass += by_wrench.force.dot(&model.gravity);
        }
    }

    /// Propagates the gradient with respect to the momenta of a body to its displacement and its velocities, its mass and its inertia.
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

    /// Takes the gradient with respect to the state of a body, and replaces it by 0. Returns the parts with respect to a displacement about
    /// the center of mass and to the velocities.
    fn take_state_gradient(&mut self, body: usize, state: &BodyState) -> [Vector6<f64>; 2] {
        let arm = self.pullback.model().arm(body, state);
        let by_state = mem::replace(&mut self.pullback.states[body], StateGradient::zero());
        self.add_by_center(body, state, &-by_state.shift);
        by_state.about(&arm).parts()
    }

    /// Adds the gradient with respect to the position of the center of mass of a body, at a constant origin.
    fn add_by_center(&mut self, body: usize, state: &BodyState, by_position: &Vector3<f64>) {
        self.pullback.gradient.bodies[body].center += state.pose.rotation().tr_mul(by_position);
    }
}
