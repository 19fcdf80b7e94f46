//! Forces other than contact in an implicit step: their wrenches, and the derivatives with respect to the states of the bodies on which
//! they depend.

use super::about_centers::{block, part};
use super::evaluation::ForceJacobian;
use super::frozen_contact_model::PairWrenches;
use super::stage::StageEquations;
use crate::dynamics::BodyState;
use crate::dynamics::dyn_world::BodyDual;
use crate::dynamics::model::Model;
use crate::scalar::lift;
use crate::spatial::{Twist, Wrench};
use nalgebra::{Matrix6, Vector6};

impl StageEquations<'_> {
    /// Wrenches of forces other than contact on the dynamic bodies of the island, at a time (s).
    pub(super) fn forces(
        &self,
        time: f64,
        states: &[BodyState],
        contacts: &[PairWrenches],
    ) -> Vec<Vector6<f64>> {
        let context = self.step.context;
        let mut all = context.start.bodies.clone();
        let mut contact = vec![Wrench::zero(); all.len()];
        for (participant, state) in states.iter().enumerate() {
            all[self.step.island.body(participant)] = *state;
        }
        for pair in contacts {
            for (side, &participant) in pair.bodies.iter().enumerate() {
                let wrench = Wrench::from_vector(&part(&pair.wrenches, side));
                contact[self.step.island.body(participant)] += wrench;
            }
        }
        let mut sums = vec![Wrench::zero(); all.len()];
        let inputs = (time, &*all, &*contact);
        let forces = context.forces;
        context
            .model
            .with_forces(inputs, &mut sums, |wrenches, now| {
                forces.add_real(wrenches, now);
            });
        let dynamic = self.step.island.dynamic.iter();
        dynamic.map(|&body| sums[body].to_vector()).collect()
    }

    /// Derivatives of the forces with respect to the states of the dynamic bodies, or an empty list
    /// if the forces depend on none of them.
    pub(super) fn force_jacobians(
        &self,
        states: &[BodyState],
        contacts: &[PairWrenches],
    ) -> Vec<ForceJacobian> {
        let coupled = self.step.context.coupled;
        let is_coupled = |body: &usize| coupled.iter().any(|group| group.contains(body));
        let Some(model) = self.step.context.lifted else {
            return Vec::new();
        };
        let all = self.lifted_states(states);
        // A force may depend on contact, and therefore on the states of all bodies in contact.
        let is_acted_on = self.step.island.dynamic.iter().any(is_coupled)
            || self.depends_on_contact((model, &all), contacts);
        let columns = 0..self.step.island.dynamic.len();
        columns
            .filter(|_| is_acted_on)
            .flat_map(|column| self.force_jacobians_by(column, (model, &all), contacts))
            .collect()
    }

    /// Whether forces on the dynamic bodies depend on the contact wrenches of the participants. The test uses derivatives along generic
    /// directions.
    fn depends_on_contact(
        &self,
        (model, all): (&Model<BodyDual>, &[BodyState<BodyDual>]),
        contacts: &[PairWrenches],
    ) -> bool {
        if contacts.is_empty() {
            return false;
        }
        let mut contact = vec![Wrench::zero(); all.len()];
        for pair in contacts {
            for (side, &participant) in pair.bodies.iter().enumerate() {
                let values = part(&pair.wrenches, side);
                let slope = (2.0 + participant as f64).sqrt();
                let seeded = |k: usize, value| BodyDual::variable(0.0, k) * slope + value;
                let wrench = Vector6::from_fn(|k, _| seeded(k, values[k]));
                contact[self.step.island.body(participant)] += Wrench::from_vector(&wrench);
            }
        }
        let wrenches = self.seeded_forces(model, all, &contact);
        let mut numbers = wrenches.iter().flatten();
        numbers.any(|number| number.eps.iter().any(|slope| *slope != 0.0))
    }

    /// Derivatives of the forces with respect to the state of one body.
    fn force_jacobians_by(
        &self,
        column: usize,
        (model, all): (&Model<BodyDual>, &[BodyState<BodyDual>]),
        contacts: &[PairWrenches],
    ) -> Vec<ForceJacobian> {
        let mut all = all.to_vec();
        let body = self.step.island.dynamic[column];
        if let Some(inertia) = model.bodies[body].inertia() {
            let seeds = |first: usize| Vector6::from_fn(|i, _| BodyDual::variable(0.0, first + i));
            let state = &mut all[body];
            state.pose = inertia.displaced(&state.pose, &seeds(0));
            state.twist = Twist::from_vector(&(state.twist.to_vector() + seeds(6)));
        }
        let contact = self.seeded_contact(column, contacts);
        let wrenches = self.seeded_forces(model, &all, &contact);
        let rows = wrenches.into_iter().enumerate();
        rows.map(|(row, wrench)| {
            let slopes = |first: usize| {
                // If a force has no derivative, such as a norm at 0, Newton's method uses 0.
                let slope = |i: usize, j: usize| wrench[i].eps[first + j];
                Matrix6::from_fn(slope).map(|slope| if slope.is_finite() { slope } else { 0.0 })
            };
            ForceJacobian {
                row,
                column,
                by_displacement: slopes(0),
                by_velocities: slopes(6),
            }
        })
        .collect()
    }

    /// States of all bodies of the world, with zero derivatives.
    fn lifted_states(&self, states: &[BodyState]) -> Vec<BodyState<BodyDual>> {
        let mut all: Vec<_> = self
            .step
            .context
            .start
            .bodies
            .iter()
            .map(BodyState::lifted)
            .collect();
        for (participant, state) in states.iter().enumerate() {
            all[self.step.island.body(participant)] = state.lifted();
        }
        all
    }

    /// Wrenches of forces on the dynamic bodies, from seeded states and contact wrenches of all bodies of the world.
    fn seeded_forces(
        &self,
        model: &Model<BodyDual>,
        all: &[BodyState<BodyDual>],
        contact: &[Wrench<BodyDual>],
    ) -> Vec<Vector6<BodyDual>> {
        let mut sums = vec![Wrench::zero(); all.len()];
        let forces = self.step.context.forces;
        model.with_forces(
            (self.start.time, all, contact),
            &mut sums,
            |wrenches, now| {
                forces.add_seeded(wrenches, now);
            },
        );
        let dynamic = self.step.island.dynamic.iter();
        dynamic.map(|&body| sums[body].to_vector()).collect()
    }

    /// Contact wrench on each body of the world, with its derivatives with respect to the state of one dynamic body of the island.
    fn seeded_contact(&self, by: usize, contacts: &[PairWrenches]) -> Vec<Wrench<BodyDual>> {
        let mut wrenches = vec![Wrench::zero(); self.step.context.start.bodies.len()];
        for pair in contacts {
            for (side, &participant) in pair.bodies.iter().enumerate() {
                let mut wrench = part(&pair.wrenches, side).map(lift::<BodyDual>);
                if let Some(column) = pair.bodies.iter().position(|&body| body == by) {
                    let [by_pose, by_velocity] = [&pair.by_displacements, &pair.by_velocities]
                        .map(|slopes| block(slopes, side, column));
                    for (row, number) in wrench.iter_mut().enumerate() {
                        for k in 0..6 {
                            number.eps[k] = by_pose[(row, k)];
                            number.eps[6 + k] = by_velocity[(row, k)];
                        }
                    }
                }
                wrenches[self.step.island.body(participant)] += Wrench::from_vector(&wrench);
            }
        }
        wrenches
    }
}
