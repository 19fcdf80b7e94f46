//! Reverse sweep: propagates the gradient of a number with respect to a state to the state one step before, and to all inputs of the step.
//!
//! Every part of a step has a closed-form adjoint. An explicit step is reversed through free motion
//! and the kick. This requires only the state before the step. An implicit step is reversed through
//! its solved stages. Contacts are linearized again. Only forces other than contact are
//! differentiated with dual numbers. One sweep gives the derivatives with respect to any number of
//! parameters.
//!
//! The rollout in `f64` records its steps on a `Tape`. If the memory is too small for all steps,
//! binomial coefficients select the recorded steps (`schedule.rs`), and the other steps are
//! repeated with the same bits. A recorded step has the `Checkpoint` before it. If it is implicit,
//! it also has the `IslandRecord` of each island: its substeps with the velocities of their stages,
//! so that no stage is solved twice. [`ReverseSweep`] reverses each step. The path from wrenches
//! back to contacts, forces, controls and parameters is the same for all steps (`Pullback`). In an
//! explicit step, `free_rotation_adjoint.rs` is the adjoint of the drift. An implicit step is
//! reversed through its accepted stages. Each stage solves λ = J⁻ᵀū with the exact matrix at the
//! root. From λ, the gradient propagates through the residual at constant velocities to the earlier
//! stages.

mod centers_of_mass;
mod contact;
mod explicit;
mod forces;
mod free_rotation_adjoint;
mod gradients;
mod implicit;
mod linearized_pair;
mod pullback;
mod schedule;
mod seeded_forces;
mod tape;

use super::dyn_world::DynWorld;
use super::implicit::ImplicitIntegratorState;
use super::integrator::Kind;
use super::{Body, Plan, RolloutError};
use crate::contact::ShapeGradient;
use explicit::ExplicitSteps;
pub(crate) use gradients::ModelGradient;
pub use gradients::{BodyStateGradient, JointStateGradient, Kink, KinkSummary, StateGradient};
use implicit::ImplicitSteps;
use pullback::Pullback;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
pub(crate) use tape::{RecordedStep, Tape};

/// Reverse sweep through a rollout.
pub(crate) struct ReverseSweep<'w> {
    steps: Steps,
    pullback: Pullback<'w>,
}

enum Steps {
    Explicit(ExplicitSteps),
    Implicit(Box<ImplicitSteps>),
}

impl<'w> ReverseSweep<'w> {
    /// Reverse sweep through the steps of a plan. An implicit step ends early once the flag is true.
    pub fn of(world: &'w dyn DynWorld<f64>, plan: &Plan, stop: Arc<AtomicBool>) -> Self {
        let time_step = plan.time_step();
        let steps = match plan.integrator().kind() {
            Kind::Explicit(splitting) => {
                let count = world.model().bodies.len();
                Steps::Explicit(ExplicitSteps::new(splitting, time_step, count))
            }
            Kind::Implicit(scheme) => {
                let integrator_state = ImplicitIntegratorState::of(world, stop);
                Steps::Implicit(Box::new(ImplicitSteps::new(
                    scheme,
                    time_step,
                    integrator_state,
                )))
            }
        };
        Self {
            steps,
            pullback: Pullback::of(world),
        }
    }

    /// Adds derivatives with respect to the shapes of all bodies.
    pub fn with_shapes(mut self) -> Self {
        let bodies = self.pullback.model().bodies.iter();
        let zero = |body: &Body| {
            let shape = body.shape.partner();
            shape.map_or_else(ShapeGradient::default, ShapeGradient::zero)
        };
        self.pullback.gradient.shapes = bodies.map(zero).collect();
        self
    }

    /// Adds a gradient with respect to the state of a body at the current step of the sweep. The number of bodies plus the index of a joint
    /// stands for the joint: turn and spin are then those of its coordinates.
    pub fn add(&mut self, body: usize, by_state: &BodyStateGradient) {
        if let Some(index) = body.checked_sub(self.pullback.states.len()) {
            let joint = &mut self.pullback.joints[index];
            joint.position += by_state.turn;
            joint.velocity += by_state.spin;
            return;
        }
        // The state of a kinematic body depends on its path only.
        let motion = &self.pullback.model().bodies[body].motion;
        if !motion.is_kinematic() {
            self.pullback.states[body].add(by_state);
        }
    }

    /// Index of a body whose gradient is not finite, if there is one.
    pub fn non_finite_body(&self) -> Option<usize> {
        let Pullback { states, joints, .. } = &self.pullback;
        let model = self.pullback.model();
        let of_joint = |body: &usize| model.bodies[*body].joint_with_state().is_some();
        let on_joints = (0..states.len()).filter(of_joint);
        let joint = joints
            .iter()
            .zip(on_joints)
            .find(|(joint, _)| !joint.is_finite());
        let body = states.iter().position(|by_state| !by_state.is_finite());
        body.or(joint.map(|(_, body)| body))
    }

    /// Reverses a step. `step` is the number of the step, counted from 1.
    pub fn step_back(&mut self, step: usize, recorded: &RecordedStep) -> Result<(), RolloutError> {
        let (
            pullback,
            RecordedStep {
                before,
                island_records,
            },
        ) = (&mut self.pullback, recorded);
        pullback.step = step;
        match &mut self.steps {
            Steps::Explicit(steps) => steps.step_back(pullback, &before.state),
            Steps::Implicit(steps) => steps
                .step_back(pullback, &before.state, island_records)
                .map_err(|error| error.into_error(pullback.model(), (step, before.state.time)))?,
        }
        pullback.clear_kinematic();
        Ok(())
    }

    /// Gradient with respect to all inputs of the rollout, after the sweep has reached the initial state.
    pub fn into_gradient(mut self) -> ModelGradient {
        self.pullback.take_initial_bodies_on_joints();
        let Pullback {
            states,
            joints,
            mut gradient,
            ..
        } = self.pullback;
        for (body, initial) in gradient.bodies.iter_mut().zip(states) {
            body.initial = initial;
        }
        gradient.joints = joints;
        gradient
    }
}
