//! Adjoint of an implicit step: reverses the substeps of each island as they were accepted, the last one first, and the stages of each
//! substep.
//!
//! A stage solves r = P(q̃ ⊕ τu, u) − p̃ − τf = 0 for the velocities u. With J = ∂r/∂u, the gradient ū with respect to u becomes the
//! gradient with respect to −r, λ = J⁻ᵀū. It propagates through all other inputs of r at constant u. Later stages depend on the velocities
//! of the earlier stages and on their wrenches (P − p̃)/τ.

use super::linearized_pair::{LinearizedPair, WrenchGradient};
use super::pullback::{EvaluationPoint, Pullback, turn_gradient};
use super::{BodyStateGradient, Kink};
use crate::dynamics::implicit::{
    ImplicitIntegratorState, Island, IslandRecord, Replay, ReplayedStage, ReplayedSubstep, Scheme,
    StageAdjoint, StepError,
};
use crate::dynamics::joint::{JointPosition, NUMBER_COUNT};
use crate::dynamics::multibody::{Kinematics, Multibody};
use crate::dynamics::{BodyState, State, TimeSpan};
use crate::spatial::{Twist, Wrench};
use nalgebra::{DVector, Vector6};

/// Adjoint of implicit steps.
pub(super) struct ImplicitSteps {
    scheme: &'static Scheme,
    time_step: f64,
    integrator_state: ImplicitIntegratorState,
}

/// Gradient with respect to the rates that a stage passes to later stages.
#[derive(Clone)]
struct RateGradient {
    velocities: DVector<f64>,
    momenta: DVector<f64>,
}

/// Gradient with respect to the start of a stage: to positions, as displacements, and to generalized momenta.
struct StartGradient {
    positions: DVector<f64>,
    momenta: DVector<f64>,
    /// Gradient with respect to the closing rates of loops.
    closing_rates: DVector<f64>,
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
        let context = self
            .integrator_state
            .context(pullback.world.real_forces(), before, span);
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
        let multibody = replay.multibody();
        let zeros = || DVector::zeros(multibody.width());
        let mut start = StartGradient {
            positions: zeros(),
            momenta: zeros(),
            closing_rates: DVector::zeros(multibody.constraint_count()),
        };
        let no_rates = RateGradient {
            velocities: zeros(),
            momenta: zeros(),
        };
        let mut by_rates = vec![no_rates; substep.stages.len()];
        for stage in substep.stages.iter().rev() {
            let Some(stage_rates) = by_rates.pop() else {
                break;
            };
            let by_start = self.stage_back(replay, stage, &stage_rates)?;
            let [by_position, by_displacement] =
                multibody.displaced_back(&stage.start().displacement, &by_start.positions);
            start.positions += by_position;
            start.momenta += &by_start.momenta;
            start.closing_rates += &by_start.closing_rates;
            for (by_rates, time) in by_rates.iter_mut().zip(stage.stage.before()) {
                by_rates.velocities += &by_displacement * time;
                by_rates.momenta += &by_start.momenta * time;
            }
        }
        let [by_position, by_velocity] =
            self.pull_back_momenta(multibody, &substep.from, &start.momenta);
        self.pullback.add_gradient(
            multibody,
            &substep.from,
            [start.positions + by_position, by_velocity],
        );
        let by_values = replay.closing_back(&start.closing_rates);
        // The derivative of a constraint with respect to a displacement is the unit wrench.
        for (participant, by_displacement) in multibody.loop_wrenches(&substep.from, &by_values) {
            let state = &substep.from.states[participant];
            let by_motion = [by_displacement, Vector6::zeros()];
            self.add_about_center(replay.island().body(participant), state, by_motion);
        }
        Ok(())
    }

    /// Propagates the gradient with respect to the end of a stage, and to the rates that later stages use, to the start of the stage.
    fn stage_back(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        by_rates: &RateGradient,
    ) -> Result<StartGradient, StepError> {
        let (multibody, end) = (replay.multibody(), &stage.end);
        let duration = stage.start().duration;
        let displacement = end.velocities() * duration;
        let by_impulse = &by_rates.momenta / duration;
        let [mut by_position, by_velocity] = self.pullback.take_gradient(multibody, end);
        let [by_position_of_momenta, by_velocity_of_momenta] =
            self.pull_back_momenta(multibody, end, &by_impulse);
        by_position += by_position_of_momenta;
        let [_, by_displacement] = multibody.displaced_back(&displacement, &by_position);
        let by_velocity = &by_rates.velocities
            + by_velocity
            + by_velocity_of_momenta
            + by_displacement * duration;
        let StageAdjoint {
            adjoint,
            by_position: by_residual,
            by_loops,
            ..
        } = self.solve_adjoint(replay, stage, &by_velocity)?;
        self.add_by_inertia(multibody, end, (&-&adjoint, duration));
        let [by_forces, _] = self.pullback.take_gradient(multibody, end);
        by_position += by_residual + by_forces;
        let [by_position, _] = multibody.displaced_back(&displacement, &by_position);
        Ok(StartGradient {
            positions: by_position,
            momenta: adjoint - by_impulse,
            closing_rates: -by_loops,
        })
    }

    /// Solves the adjoint equation of a stage for λ, the gradient with respect to the negative residual. Then propagates λ through all
    /// wrenches at constant velocities.
    fn solve_adjoint(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        by_velocities: &DVector<f64>,
    ) -> Result<StageAdjoint, StepError> {
        let (island, model) = (replay.island(), self.pullback.model());
        for (participant, state) in stage.end.states.iter().enumerate() {
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
        let adjoint =
            stage.solve_transposed(participants.into_iter().zip(linearized), by_velocities)?;
        self.add_by_laws(
            replay.multibody(),
            &stage.end,
            &adjoint.adjoint,
            [stage.start().duration, stage.start().time],
        );
        let multibody = replay.multibody();
        let virtual_twists = multibody.twists(&stage.end, &adjoint.adjoint, 0.0);
        self.add_by_loops(replay, stage, (&virtual_twists, &adjoint.by_loops));
        if with_shapes {
            let products = [&virtual_twists[..], &adjoint.wrenches];
            let duration = stage.start().duration;
            self.pullback
                .add_by_centers_in_forces(multibody, &stage.end, products, duration);
        }
        for (index, (twist, wrench)) in virtual_twists.iter().zip(&adjoint.wrenches).enumerate() {
            if let Some(neighbor) = multibody.carrier(index) {
                // A turn of the carrier turns the motions of the links, but not the wrenches.
                let by_turn = turn_gradient(&Twist::from_vector(twist), wrench);
                let by_carrier = &mut self.pullback.states[multibody.neighbors[neighbor]];
                by_carrier.turn += by_turn * stage.start().duration;
            }
        }
        for (&body, twist) in island.dynamic.iter().zip(&virtual_twists) {
            let by_wrench = Wrench::from_vector(&(twist * stage.start().duration));
            self.add_by_weight(body, &by_wrench);
            self.by_wrenches[body] = by_wrench;
        }
        self.pull_back_wrenches(stage.start().time, island, &contacts);
        for &body in &island.dynamic {
            self.by_wrenches[body] = Wrench::zero();
        }
        Ok(adjoint)
    }

    /// Propagates the adjoint through the wrenches and the velocities of loops to the states of their bodies, at constant unknowns.
    fn add_by_loops(
        &mut self,
        replay: &Replay,
        stage: &ReplayedStage,
        (virtual_twists, by_loops): (&[Vector6<f64>], &DVector<f64>),
    ) {
        let (multibody, end, island) = (replay.multibody(), &stage.end, replay.island());
        let duration = stage.start().duration;
        for joint in &multibody.loops {
            let by_velocities = by_loops.rows(joint.multipliers.start, joint.multipliers.len());
            for (side, &participant) in joint.participants.iter().enumerate() {
                let slopes = multibody.loop_slopes(end, (joint, side));
                let mut by_displacement = -(&slopes.by_displacement * by_velocities);
                for (&body, by_motion) in joint.participants.iter().zip(&slopes.wrenches) {
                    if let Some(twist) = virtual_twists.get(body) {
                        by_displacement += by_motion.tr_mul(twist) * duration;
                    }
                }
                let by_twist = -(&slopes.by_velocity * by_velocities);
                let (body, state) = (island.body(participant), &end.states[participant]);
                self.add_about_center(body, state, [by_displacement, by_twist]);
            }
        }
    }

    /// Adds the gradient with respect to a displacement of a body about its center of mass, and to its twist.
    fn add_about_center(&mut self, body: usize, state: &BodyState, by_motion: [Vector6<f64>; 2]) {
        let arm = self.pullback.model().arm(body, state);
        let about_center = BodyStateGradient::from_parts(by_motion);
        self.pullback.states[body].add(&about_center.about(&-arm));
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

    /// Propagates the gradient with respect to generalized momenta to positions and velocities, and to masses and inertias.
    fn pull_back_momenta(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
        by_momenta: &DVector<f64>,
    ) -> [DVector<f64>; 2] {
        // The gradient is zero in the last stage of a substep, because no later stage uses its rates.
        if by_momenta.iter().all(|gradient| *gradient == 0.0) {
            return [by_momenta.clone(), by_momenta.clone()];
        }
        self.add_by_inertia(multibody, kinematics, (by_momenta, 0.0));
        let directions = [
            kinematics.position_directions(0.0),
            kinematics.velocity_directions(),
        ];
        directions.map(|directions| {
            let slopes = multibody.momentum_slopes(kinematics, &directions);
            multibody.transposed_product(&slopes, by_momenta)
        })
    }

    /// Propagates the gradient with respect to projected momenta (S − τṠ)ᵀH to masses, inertias and centers of mass, at a
    /// duration τ (s).
    fn add_by_inertia(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
        (by_momenta, duration): (&DVector<f64>, f64),
    ) {
        if self.pullback.wants_shapes() {
            let by_momenta = (by_momenta, duration);
            self.pullback
                .add_by_centers_in_momenta(multibody, kinematics, by_momenta);
        }
        let twists = multibody.twists(kinematics, by_momenta, duration);
        for ((link, state), twist) in multibody.links.iter().zip(&kinematics.states).zip(&twists) {
            let inertia = &link.inertia;
            let by_angular = twist.fixed_rows::<3>(0).into_owned();
            let by_inertia = inertia.principal.by_inertia_in_momentum(
                state.pose.rotation(),
                &by_angular,
                &state.twist.angular,
            );
            let gradient = &mut self.pullback.gradient.bodies[link.body];
            gradient.mass += inertia.momentum_per_mass(state).dot(twist);
            gradient.inertia += by_inertia * inertia.mass;
            let columns = link.columns.clone();
            let by_armature =
                columns.map(|column| by_momenta[column] * kinematics.velocities()[column]);
            gradient.joint_law[NUMBER_COUNT - 1] += by_armature.sum::<f64>();
        }
    }

    /// Propagates λ to the numbers of the joint laws, through the joint forces in a stage of a duration (s), at the time (s) of the stage.
    fn add_by_laws(
        &mut self,
        multibody: &Multibody,
        end: &Kinematics,
        adjoint: &DVector<f64>,
        [duration, time]: [f64; 2],
    ) {
        for (link, position) in multibody.links.iter().zip(&end.coordinates.positions) {
            if let JointPosition::Scalar(position) = position {
                let column = link.columns.start;
                let motion = [*position, end.velocities()[column]];
                let slopes = link.law.slopes_by_numbers(motion, time);
                let gradient = slopes.map(|slope| slope * adjoint[column] * duration);
                self.pullback
                    .add_by_joint_law(link.body, gradient, self.span);
            }
        }
    }
}
