//! Linearization of a stage: derivatives of contacts, forces and the residual.

use super::about_centers::joined;
use super::evaluation::{ForceJacobian, with_contacts};
use super::frozen_contact_model::PairWrenches;
use super::matrix::Factors;
use super::rates::BodyChange;
use super::stage::StageEquations;
use crate::dynamics::multibody::Kinematics;
use crate::dynamics::sweep::Sweep;
use crate::parallel::mapped_into;
use nalgebra::Vector6;

/// Linearization of a stage at its solution.
pub(super) struct Linearization {
    /// Wrenches of contacts and forces on the dynamic bodies.
    pub wrenches: Vec<Vector6<f64>>,
    pub contacts: Vec<PairWrenches>,
    pub forces: Vec<ForceJacobian>,
    /// Factors of the derivatives of the residual with respect to the velocities.
    pub factors: Factors,
    /// Whether the derivatives of the contacts are exact. If not, they hold the contact polygons fixed and approximate friction.
    pub is_exact: bool,
}

impl Linearization {
    /// Change of contacts and forces on each dynamic body, from the displacements and the changes of velocity of all participants.
    pub fn change(&self, count: usize, changes: &[BodyChange]) -> Vec<Vector6<f64>> {
        let mut forces = vec![Vector6::zeros(); count];
        for slopes in &self.forces {
            let BodyChange {
                displacement,
                velocities,
            } = &changes[slopes.column];
            forces[slopes.row] +=
                slopes.by_displacement * displacement + slopes.by_velocities * velocities;
        }
        let of_contact = |contact: &PairWrenches| {
            let changes = contact.bodies.map(|body| &changes[body]);
            let displacements = joined(changes.map(|change| Some(change.displacement)));
            let velocities = joined(changes.map(|change| Some(change.velocities)));
            let wrenches =
                contact.by_displacements * displacements + contact.by_velocities * velocities;
            (contact.bodies, wrenches)
        };
        with_contacts(forces, self.contacts.iter().map(of_contact))
    }
}

impl StageEquations<'_> {
    /// Linearization with all exact first derivatives.
    pub fn linearized(&self, end: &Kinematics) -> Linearization {
        let states = &*end.states;
        let (context, island) = (self.step.context, self.step.island);
        let mut sweep = Sweep::default();
        let pairs = context.close_pairs(island, states, &mut sweep);
        let mut contacts = Vec::new();
        mapped_into(&mut contacts, pairs, |&(i, j)| {
            let pair = context.pair(island, [i, j], states)?;
            Some(PairWrenches::of(
                &pair.geometry(),
                [i, j],
                &pair.linearized(),
            ))
        });
        let contacts: Vec<_> = contacts.into_iter().flatten().collect();
        let forces = self.force_jacobians(states, &contacts);
        let wrenches = self.wrenches(states, &contacts);
        let matrix = self.matrix(end, &wrenches, &contacts, &forces);
        Linearization {
            factors: matrix.factorized(context.symbolic_cache),
            wrenches,
            contacts,
            forces,
            is_exact: true,
        }
    }
}
