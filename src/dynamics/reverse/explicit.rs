//! An explicit step, backwards: its parts in closed form, the last first.

use super::contact::{LinearizedPair, WrenchCovector};
use super::pullback::{EvaluationPoint, Pullback};
use crate::dynamics::integrator::{Splitting, accelerate};
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia, State, TimeSpan};
use crate::spatial::Wrench;

/// Explicit steps.
pub(super) struct ExplicitSteps {
    splitting: Splitting,
    time_step: f64,
    sweep: Sweep,
    /// All bodies.
    bodies: Vec<usize>,
}

/// All that acts on the bodies in a kick.
struct KickWrenches<'w> {
    contacts: Vec<LinearizedPair<'w>>,
    /// The wrench of contact on each body, about its center of mass.
    contact: Vec<Wrench>,
    /// The wrench of all but gravity on each body, about its center of mass.
    all: Vec<Wrench>,
}

impl ExplicitSteps {
    pub fn new(splitting: Splitting, time_step: f64, body_count: usize) -> Self {
        Self {
            splitting,
            time_step,
            sweep: Sweep::default(),
            bodies: (0..body_count).collect(),
        }
    }

    /// Takes the step back that led on from a state.
    pub fn step_back(&mut self, pullback: &mut Pullback, before: &State) {
        let model = pullback.model();
        let [approach, complete] = self.splitting.drifts().map(|share| share * self.time_step);
        let mut state = before.clone();
        self.splitting.approach(model, &mut state, self.time_step);
        let span = self.splitting.span(&state, self.time_step);
        let wrenches = self.kick_wrenches(pullback, &state, span);
        let mut kicked = state.clone();
        accelerate(model, &mut kicked, &wrenches.all, self.time_step);
        drift_back(pullback, &kicked, complete);
        self.kick_back(pullback, &state, &wrenches, span);
        drift_back(pullback, before, approach);
    }

    /// What acts in the kick at a state. Controls act by their means over a time step.
    fn kick_wrenches<'w>(
        &mut self,
        pullback: &Pullback<'w>,
        state: &State,
        span: TimeSpan,
    ) -> KickWrenches<'w> {
        let (world, model) = (pullback.world, pullback.model());
        let pairs = model.close_pairs(&state.bodies, &mut self.sweep);
        let contacts =
            LinearizedPair::of_pairs(model, &state.bodies, pairs, pullback.wants_shapes());
        let contacts: Vec<_> = contacts.into_iter().flatten().collect();
        let contact = LinearizedPair::net_wrenches(&contacts, model, &state.bodies);
        let mut all = contact.clone();
        let here = (state.time, &*state.bodies, &*contact);
        model.with_forces(here, &mut all, |wrenches, now| {
            model.add_controls(wrenches, now, span);
            world.add_forces(wrenches, now);
        });
        KickWrenches {
            contacts,
            contact,
            all,
        }
    }

    /// Takes the kick back: poses stay, and velocities before it count for the wrenches.
    fn kick_back(
        &self,
        pullback: &mut Pullback,
        state: &State,
        wrenches: &KickWrenches,
        span: TimeSpan,
    ) {
        let mut by_wrenches = vec![Wrench::zero(); state.bodies.len()];
        for (body, by_wrench) in by_wrenches.iter_mut().enumerate() {
            if let Some(inertia) = pullback.model().bodies[body].inertia() {
                let wrench = &wrenches.all[body];

                *by_wrench =
                    self.kick_of_body_back(pullback, body, (inertia, &state.bodies[body]), wrench);
            }
        }
        let here = EvaluationPoint {
            time: state.time,
            span,
            states: &state.bodies,
            bodies: &self.bodies,
            contacts: &wrenches.contacts,
            net: &wrenches.contact,
        };
        pullback.pull_back_wrenches(here, &by_wrenches);
    }

    /// The derivative by the wrench on a body about its center of mass. The inertia turns with the body, and grows with its mass.
    fn kick_of_body_back(
        &self,
        pullback: &mut Pullback,
        body: usize,
        (inertia, state): (&Inertia, &BodyState),
        &Wrench { torque, force }: &Wrench,
    ) -> WrenchCovector {
        let (rotation, mass) = (state.pose.rotation(), inertia.mass);
        let by_state = &mut pullback.states[body];
        let by_torque = inertia.angular_velocity(rotation, &by_state.spin) * self.time_step;
        let by_force = by_state.velocity * (self.time_step / mass);
        let angular = inertia.angular_velocity(rotation, &torque) * self.time_step;
        by_state.turn += angular.cross(&by_state.spin) - torque.cross(&by_torque);
        let by_mass = angular.dot(&by_state.spin) + force.dot(&by_force);
        let gradient = &mut pullback.gradient.bodies[body];
        gradient.mass -= by_mass / mass;
        let impulse = torque * (self.time_step / mass);
        let principal = &inertia.principal;
        gradient.inertia += principal.by_inertia_in_kick(rotation, &by_state.spin, &impulse);
        pullback.gradient.gravity += by_state.velocity * self.time_step;
        Wrench {
            torque: by_torque,
            force: by_force,
        }
    }
}

/// Takes free motion back to the states before it.
fn drift_back(pullback: &mut Pullback, before: &State, duration: f64) {
    if duration == 0.0 {
        return;
    }
    let bodies = pullback.model().bodies.iter().zip(&before.bodies);
    let gradients = pullback
        .states
        .iter_mut()
        .zip(&mut pullback.gradient.bodies);
    for ((body, state), (by_state, gradient)) in bodies.zip(gradients) {
        if let Some(inertia) = body.inertia() {
            *by_state = inertia.drifted_back(state, by_state, duration, gradient);
        }
    }
}
