//! The reverse sweep: from the derivatives of a number by a state to those by the state one step before, and by all that the
//! step depends on.
//!
//! Every part of a step is taken backwards in closed form: of an explicit one, free motion and the kick, from the state before it
//! alone; of an implicit one, the stages as they were solved. Contacts are linearized anew. Only forces of other kinds are
//! differentiated by dual numbers. One sweep gives the derivatives by any number of parameters.
//!
//! The rollout in `f64` leaves its steps on a `Tape`: all of them, or as many as its memory holds, placed by binomial coefficients
//! (`schedule.rs`). The other steps are taken again with the same bits. A step is kept as the `Checkpoint` before it and, if it is implicit,
//! the `Trace` of each island: its substeps with the velocities of their stages, so that nothing is solved twice. [`Reversal`] takes
//! each step back. The way from wrenches back to contacts, forces, controls and parameters is the same for all steps (`Pullback`). In an explicit step
//! `free_motion.rs` is the adjoint of the free motion. An implicit step goes back through its accepted stages: λ = J⁻ᵀū with the exact
//! matrix at the root, transposed, then from λ through the residual at constant velocities to the earlier stages.

mod contact;
mod covector;
mod explicit;
mod forces;
mod free_rotation_adjoint;
mod implicit;
mod pullback;
mod schedule;
mod tape;

use super::dyn_world::DynWorld;
use super::implicit::ImplicitIntegratorState;
use super::integrator::Kind;
use super::{Body, Plan, RolloutError};
use crate::contact::ShapeGradient;
pub(crate) use covector::ModelGradient;
pub use covector::{Kink, KinkSummary, StateGradient};
use explicit::ExplicitSteps;
use implicit::ImplicitSteps;
use pullback::Pullback;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
pub(crate) use tape::{RecordedStep, Tape};

/// A rollout that is taken backwards.
pub(crate) struct ReverseSweep<'w> {
    steps: Steps,
    pullback: Pullback<'w>,
}

enum Steps {
    Explicit(ExplicitSteps),
    Implicit(Box<ImplicitSteps>),
}

impl<'w> ReverseSweep<'w> {
    /// Of a plan's steps. An implicit step that is taken back ends once the flag is true.
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

    /// The same, with derivatives by the shapes of all bodies.
    pub fn with_shapes(mut self) -> Self {
        let bodies = self.pullback.model().bodies.iter();
        let zero = |body: &Body| ShapeGradient::zero(body.shape.partner());
        self.pullback.gradient.shapes = bodies.map(zero).collect();
        self
    }

    /// Adds derivatives by the state of a body where the sweep has come to.
    pub fn add(&mut self, body: usize, by_state: &StateGradient) {
        // Where a path leads, nothing else does.
        let motion = &self.pullback.model().bodies[body].motion;
        if !motion.is_kinematic() {
            self.pullback.states[body].add(by_state);
        }
    }

    /// The place of a body with a derivative that is not finite, if there is one.
    pub fn non_finite_body(&self) -> Option<usize> {
        let mut states = self.pullback.states.iter();
        states.position(|by_state| !by_state.is_finite())
    }

    /// Takes a step back; `step` is its number, counted from 1.
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

    /// The derivatives by all that the rollout depends on, from those by its initial state.
    pub fn into_gradient(self) -> ModelGradient {
        let Pullback {
            states,
            mut gradient,
            ..
        } = self.pullback;
        for (body, initial) in gradient.bodies.iter_mut().zip(states) {
            body.initial = initial;
        }
        gradient
    }
}
