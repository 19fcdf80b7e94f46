//! Adjoint of an explicit step: reverses its parts in closed form, the last part first.

use super::linearized_pair::{LinearizedPair, WrenchGradient};
use super::pullback::{EvaluationPoint, Pullback};
use crate::dynamics::integrator::{Splitting, accelerate};
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia, State, TimeSpan};
use crate::spatial::Wrench;

/// Adjoint of explicit steps.
pub(super) struct ExplicitSteps {
    splitting: Splitting,
    time_step: f64,
    sweep: Sweep,
    /// Indices of all bodies.
    bodies: Vec<usize>,
}

/// Contacts and wrenches in a kick.
struct KickWrenches<'w> {
    contacts: Vec<LinearizedPair<'w>>,
    /// Contact wrench on each body, about its center of mass.
    contact: Vec<Wrench>,
    /// Wrench of everything but gravity on each body, about its center of mass.
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

    /// Reverses the step that began at a state.
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

    /// Contacts and wrenches in the kick at a state. Controls are averaged over a time step.
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
        let inputs = (state.time, &*state.bodies, &*contact);
        model.with_forces(inputs, &mut all, |wrenches, now| {
            model.add_controls(wrenches, now, span);
            world.add_forces(wrenches, now);
        });
        KickWrenches {
            contacts,
            contact,
            all,
        }
    }

    /// Reverses the kick. Poses are constant in a kick, and the wrenches depend on the velocities before it.
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
        let point = EvaluationPoint {
            time: state.time,
            span,
            states: &state.bodies,
            bodies: &self.bodies,
            contacts: &wrenches.contacts,
            net: &wrenches.contact,
        };
        pullback.pull_back_wrenches(point, &by_wrenches);
    }

    /// Gradient with respect to the wrench on a body about its center of mass. The inertia turns with the body, and is proportional to its
    /// mass.
    fn kick_of_body_back(
        &self,
        pullback: &mut Pullback,
        body: usize,
        (inertia, state): (&Inertia, &BodyState),
        &Wrench { torque, force }: &Wrench,
    ) -> WrenchGradient {
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

/// Reverses free motion to the states before it.
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
