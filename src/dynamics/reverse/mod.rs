//! The reverse sweep: from the derivatives of a number by a state to those by the state one step before, and by all that the
//! step depends on.
//!
//! Every part of an explicit step is taken backwards in closed form, from the state before the step alone: free motion, the kick,
//! and the contacts, which are linearised anew. Only forces of other kinds are differentiated by dual numbers. One sweep gives
//! the derivatives by any number of parameters.

mod contact;
mod covector;
mod explicit;
mod forces;
mod free_motion;
mod pullback;
mod tape;

use super::any_world::AnyWorld;
use super::integrator::Kind;
use super::{Motion, Plan, State};
pub(crate) use covector::{StateCovector, SystemGradient};
use explicit::ExplicitSteps;
use pullback::Pullback;
pub(crate) use tape::Tape;

/// A rollout that is taken backwards.
pub(crate) struct Reversal<'w> {
    steps: ExplicitSteps,
    pullback: Pullback<'w>,
}

impl<'w> Reversal<'w> {
    /// Of a plan's steps; none if they are implicit.
    pub fn of(world: &'w dyn AnyWorld<f64>, plan: &Plan) -> Option<Self> {
        let Kind::Explicit(splitting) = plan.integrator().kind() else {
            return None;
        };
        let count = world.system().bodies.len();
        Some(Self {
            steps: ExplicitSteps::new(splitting, plan.time_step(), count),
            pullback: Pullback::of(world),
        })
    }

    /// Adds derivatives by the state of a body where the sweep has come to.
    pub fn add(&mut self, body: usize, by_state: &StateCovector) {
        // Where a path leads, nothing else does.
        let motion = &self.pullback.system().bodies[body].motion;
        if !matches!(motion, Motion::Prescribed(_)) {
            self.pullback.states[body].add(by_state);
        }
    }

    /// The place of a body with a derivative that is not finite, if there is one.
    pub fn lost(&self) -> Option<usize> {
        let mut states = self.pullback.states.iter();
        states.position(|by_state| !by_state.is_finite())
    }

    /// Takes the step back that led on from a state.
    pub fn step_back(&mut self, before: &State) {
        self.steps.step_back(&mut self.pullback, before);
        self.pullback.forget_paths();
    }

    /// The derivatives by all that the rollout depends on, from those by its initial state.
    pub fn finished(self) -> SystemGradient {
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
