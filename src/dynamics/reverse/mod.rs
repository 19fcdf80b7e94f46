//! The reverse sweep: from the derivatives of a number by a state to those by the state one step before, and by all that the
//! step depends on.
//!
//! Every part of an explicit step is taken backwards in closed form, from the state before the step alone: free motion, the kick,
//! and the contacts, which are linearised anew. Only forces of other kinds are differentiated by dual numbers. One sweep gives
//! the derivatives by any number of parameters.

mod contact;
mod covector;
mod forces;
mod free_motion;
mod tape;

use super::any_world::AnyWorld;
use super::integrator::{Kind, Splitting, accelerate};
use super::sweep::Sweep;
use super::{BodyState, Inertia, Motion, Plan, State};
use crate::spatial::Wrench;
use contact::{Touching, WrenchCovector};
pub use covector::StateCovector;
pub(crate) use covector::SystemGradient;
use forces::SeededForces;
pub(crate) use tape::Tape;

/// A rollout that is taken backwards by explicit steps.
pub(crate) struct Reversal<'w> {
    world: &'w dyn AnyWorld<f64>,
    splitting: Splitting,
    time_step: f64,
    forces: Option<SeededForces>,
    sweep: Sweep,
    /// By the state of each body where the sweep has come to.
    states: Vec<StateCovector>,
    gradient: SystemGradient,
}

/// All that acts on the bodies in a kick.
struct Acting {
    contacts: Vec<Touching>,
    /// The wrench of contact on each body, about its centre of mass.
    contact: Vec<Wrench>,
    /// The wrench of all but gravity.
    all: Vec<Wrench>,
}

impl<'w> Reversal<'w> {
    /// Of a plan's steps; none if they are implicit.
    pub fn of(world: &'w dyn AnyWorld<f64>, plan: &Plan) -> Option<Self> {
        let Kind::Explicit(splitting) = plan.integrator().kind() else {
            return None;
        };
        let system = world.system();
        Some(Self {
            world,
            splitting,
            time_step: plan.time_step(),
            forces: SeededForces::of(world),
            sweep: Sweep::default(),
            states: vec![StateCovector::zero(); system.bodies.len()],
            gradient: SystemGradient::zero(system),
        })
    }

    /// Adds derivatives by the state of a body where the sweep has come to.
    pub fn add(&mut self, body: usize, by_state: &StateCovector) {
        // Where a path leads, nothing else does.
        if !matches!(
            self.world.system().bodies[body].motion,
            Motion::Prescribed(_)
        ) {
            self.states[body].add(by_state);
        }
    }

    /// The place of a body with a derivative that is not finite, if there is one.
    pub fn lost(&self) -> Option<usize> {
        self.states
            .iter()
            .position(|by_state| !by_state.is_finite())
    }

    /// Takes the step back that led on from a state.
    pub fn step_back(&mut self, before: &State) {
        let [approach, complete] = self.splitting.drifts().map(|share| share * self.time_step);
        let mut state = before.clone();
        self.splitting
            .approach(self.world.system(), &mut state, self.time_step);
        let middle = self.splitting.middle(&state, self.time_step);
        let acting = self.acting(&state, middle);
        let mut kicked = state.clone();
        accelerate(
            self.world.system(),
            &mut kicked,
            &acting.all,
            self.time_step,
        );
        self.drift_back(&kicked, complete);
        self.kick_back(&state, &acting, middle);
        self.drift_back(before, approach);
    }

    /// The derivatives by all that the rollout depends on, from those by its initial state.
    pub fn finished(mut self) -> SystemGradient {
        for (body, initial) in self.gradient.bodies.iter_mut().zip(self.states) {
            body.initial = initial;
        }
        self.gradient
    }

    fn drift_back(&mut self, before: &State, duration: f64) {
        if duration == 0.0 {
            return;
        }
        let bodies = self.world.system().bodies.iter().zip(&before.bodies);
        for ((body, state), by_state) in bodies.zip(&mut self.states) {
            if let Some(inertia) = body.inertia() {
                *by_state = inertia.drifted_back(state, by_state, duration);
            } else if matches!(body.motion, Motion::Prescribed(_)) {
                *by_state = StateCovector::zero();
            }
        }
    }

    fn acting(&mut self, state: &State, middle: f64) -> Acting {
        let contacts = self.contacts(&state.bodies);
        let contact = self.net_wrenches(&contacts, &state.bodies);
        let (world, system) = (self.world, self.world.system());
        let mut all = contact.clone();
        let here = (state.time, &*state.bodies, &*contact);
        system.with_forces(here, &mut all, |wrenches, now| {
            system.add_controls(wrenches, now, middle);
            world.add_forces(wrenches, now);
        });
        Acting {
            contacts,
            contact,
            all,
        }
    }

    /// Takes the kick back: poses stay, and velocities before it count for the wrenches.
    fn kick_back(&mut self, state: &State, acting: &Acting, middle: f64) {
        let mut by_wrenches = vec![Wrench::zero(); state.bodies.len()];
        for (body, by_wrench) in by_wrenches.iter_mut().enumerate() {
            if let Some(inertia) = self.world.system().bodies[body].inertia() {
                *by_wrench = self.kick_of_body_back(body, inertia, &state.bodies[body], acting);
            }
        }
        self.pull_back_controls(middle, &by_wrenches);
        let mut by_contact = by_wrenches.clone();
        let here = (state.time, &*state.bodies, &*acting.contact);
        self.pull_back_forces(here, &by_wrenches, &mut by_contact);
        let contact = (&*acting.contacts, &*acting.contact);
        self.pull_back_contacts(&state.bodies, contact, &by_contact);
    }

    /// The derivative by the wrench on a body about its centre of mass. The inertia turns with the body, and grows with its mass.
    fn kick_of_body_back(
        &mut self,
        body: usize,
        inertia: &Inertia,
        state: &BodyState,
        acting: &Acting,
    ) -> WrenchCovector {
        let Wrench { torque, force } = acting.all[body];
        let (rotation, mass) = (state.pose.rotation(), inertia.mass);
        let by_state = &mut self.states[body];
        let by_torque = inertia.angular_velocity(rotation, &by_state.spin) * self.time_step;
        let by_force = by_state.velocity * (self.time_step / mass);
        let angular = inertia.angular_velocity(rotation, &torque) * self.time_step;
        by_state.turn += angular.cross(&by_state.spin) - torque.cross(&by_torque);
        let by_mass = angular.dot(&by_state.spin) + force.dot(&by_force);
        self.gradient.bodies[body].mass -= by_mass / mass;
        self.gradient.gravity += by_state.velocity * self.time_step;
        Wrench {
            torque: by_torque,
            force: by_force,
        }
    }

    fn pull_back_controls(&mut self, middle: f64, by_wrenches: &[WrenchCovector]) {
        let system = self.world.system();
        for (control, by_intervals) in system.controls.iter().zip(&mut self.gradient.controls) {
            let interval = control.interval_at(middle);
            let by_interval = interval.and_then(|interval| by_intervals.get_mut(interval));
            if let (Some(by_interval), Ok(body)) = (by_interval, system.index_of(control.body())) {
                *by_interval += by_wrenches[body].to_vector();
            }
        }
    }
}
