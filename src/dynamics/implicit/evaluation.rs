//! Equations of a stage near a solution: contacts, forces and their derivatives, in `f64`.

use super::about_centers::{PairVector, block, joined, part};
use super::frozen_contact_model::{FrozenContactModel, PairWrenches};
use super::island_step::StepError;
use super::matrix::BlockMatrix;
use super::rigid::displacement;
use super::stage::{StageEquations, concatenated, six_of};
use crate::contact::LinearizedContact;
use crate::dynamics::BodyState;
use crate::dynamics::sweep::Sweep;
use crate::parallel::mapped_into;
use nalgebra::{DVector, Matrix6, Vector6};

/// Contacts, forces and states at given velocities, with a local model of the contacts and forces.
pub(super) struct Evaluation {
    pub velocities: DVector<f64>,
    pub states: Vec<BodyState>,
    pub contacts: Vec<FrozenContactModel>,
    /// Sum of the wrenches of contacts and forces on each dynamic body.
    pub wrenches: Vec<Vector6<f64>>,
    /// Forces other than contact on each dynamic body, or an empty list if there are none.
    forces: Vec<Vector6<f64>>,
    pub force_jacobians: Vec<ForceJacobian>,
    /// Whether the derivatives of the contacts are exact.
    pub is_exact: bool,
}

/// Derivatives of the wrench on one body with respect to the displacement and the velocities of another body.
pub(super) struct ForceJacobian {
    pub row: usize,
    pub column: usize,
    pub by_displacement: Matrix6<f64>,
    pub by_velocities: Matrix6<f64>,
}

impl StageEquations<'_> {
    /// Evaluates contacts and forces for these velocities. This is the only place where the solver searches for contacts.
    pub fn evaluation(&self, velocities: DVector<f64>, is_exact: bool) -> Evaluation {
        let (context, island) = (self.step.context, self.step.island);
        let states = self.states_with(|index| six_of(&velocities, index));
        let mut sweep = Sweep::default();
        let pairs = context.close_pairs(island, &states, &mut sweep);
        let mut models = Vec::new();
        mapped_into(&mut models, pairs, |&(i, j)| {
            let pair = context.pair(island, [i, j], &states)?;
            FrozenContactModel::of(&pair, [i, j], is_exact)
        });
        let contacts: Vec<_> = models.into_iter().flatten().collect();
        let (mut forces, mut force_jacobians) =
            (vec![Vector6::zeros(); self.inertias.len()], Vec::new());
        if !context.forces.is_empty() {
            let wrenches: Vec<_> = contacts.iter().map(FrozenContactModel::evaluated).collect();
            forces = self.forces(self.start.time, &states, &wrenches);
            force_jacobians = self.force_jacobians(&states, &wrenches);
        }
        let contact_wrenches = contacts
            .iter()
            .map(|contact| (contact.bodies, &contact.wrenches));
        Evaluation {
            wrenches: with_contacts(forces.clone(), contact_wrenches),
            is_exact: is_exact || !contacts.iter().any(FrozenContactModel::is_dissipative),
            velocities,
            states,
            contacts,
            forces,
            force_jacobians,
        }
    }

    /// Residual in an evaluated state.
    pub fn residual_in(&self, evaluation: &Evaluation) -> DVector<f64> {
        concatenated(self.residual(&evaluation.states, &evaluation.wrenches))
    }

    /// Residual and its matrix near an evaluated state, with the contact polygons of that state.
    pub fn residual_near(
        &self,
        evaluation: &Evaluation,
        velocities: &DVector<f64>,
    ) -> (DVector<f64>, BlockMatrix) {
        let states = self.states_with(|index| six_of(velocities, index));
        let change = velocities - &evaluation.velocities;
        let displacement = |index: usize| {
            let [from, to] = [&evaluation.states[index].pose, &states[index].pose];
            displacement(self.inertias[index], from, to)
        };
        let count = self.inertias.len();
        let displacements: Vec<_> = (0..count).map(displacement).collect();
        let near = |contact: &FrozenContactModel| {
            let of = |numbers: &dyn Fn(usize) -> Vector6<f64>| {
                let of_dynamic = |body: usize| (body < count).then(|| numbers(body));
                joined(contact.bodies.map(of_dynamic))
            };
            let velocities = of(&|body| six_of(&change, body));
            contact.near(&of(&|body| displacements[body]), &velocities)
        };
        let mut contacts = Vec::new();
        mapped_into(&mut contacts, &evaluation.contacts, near);
        let mut forces = evaluation.forces.clone();
        for slopes in &evaluation.force_jacobians {
            forces[slopes.row] += slopes.by_displacement * displacements[slopes.column]
                + slopes.by_velocities * six_of(&change, slopes.column);
        }
        let matrix = self.matrix(&states, &contacts, &evaluation.force_jacobians);
        let contact_wrenches = contacts
            .iter()
            .map(|contact| (contact.bodies, &contact.wrenches));
        let wrenches = with_contacts(forces, contact_wrenches);
        (concatenated(self.residual(&states, &wrenches)), matrix)
    }

    /// Derivatives of the residual with respect to the velocities.
    pub fn matrix(
        &self,
        states: &[BodyState],
        contacts: &[PairWrenches],
        forces: &[ForceJacobian],
    ) -> BlockMatrix {
        let (count, duration) = (self.inertias.len(), self.start.duration);
        let rates: Vec<_> = (0..count)
            .map(|index| self.inertias[index].motion_jacobian(&states[index], duration))
            .collect();
        let mut matrix = BlockMatrix::zeros(count);
        for (index, rates) in rates.iter().enumerate() {
            let by_pose = rates.momentum_by_pose * rates.displacement;
            matrix.add(index, index, &(by_pose + rates.momentum_by_twist));
        }
        let mut add = |row: usize,
                       column: usize,
                       by_displacement: &Matrix6<f64>,
                       by_velocities: &Matrix6<f64>| {
            let slopes = by_displacement * rates[column].displacement + by_velocities;
            matrix.add(row, column, &(slopes * -duration));
        };
        for slopes in forces {
            add(
                slopes.row,
                slopes.column,
                &slopes.by_displacement,
                &slopes.by_velocities,
            );
        }
        for contact in contacts {
            for (row, &body) in contact.bodies.iter().enumerate() {
                for (column, &other_body) in contact.bodies.iter().enumerate() {
                    if body < count && other_body < count {
                        let slopes = [&contact.by_displacements, &contact.by_velocities];
                        let [by_displacement, by_velocities] =
                            slopes.map(|slopes| block(slopes, row, column));
                        add(body, other_body, &by_displacement, &by_velocities);
                    }
                }
            }
        }
        matrix
    }

    /// Matrix at the solution, from the exact derivatives of the contacts. Each contact has two participants.
    pub fn exact_matrix<'c>(
        &self,
        states: &[BodyState],
        contacts: impl Iterator<Item = ([usize; 2], &'c LinearizedContact)>,
    ) -> BlockMatrix {
        let (context, island) = (self.step.context, self.step.island);
        let contacts: Vec<_> = contacts
            .map(|(bodies, contact)| {
                PairWrenches::of(&context.geometry(island, bodies, states), bodies, contact)
            })
            .collect();
        self.matrix(states, &contacts, &self.force_jacobians(states, &contacts))
    }

    /// Error of a singular stage matrix.
    pub fn singular(&self) -> StepError {
        StepError::Unsolved {
            body: self.step.island.dynamic[0],
            duration: self.start.duration,
        }
    }

    /// Norm (m/s) of the speeds of all bodies.
    pub fn speed(&self, velocities: &DVector<f64>) -> f64 {
        let inertias = self.inertias.iter().enumerate();
        let speeds = inertias.map(|(index, inertia)| inertia.speed(&six_of(velocities, index)));
        speeds.map(|speed| speed * speed).sum::<f64>().sqrt()
    }

    /// Index of the body with the largest speed.
    pub fn fastest(&self, velocities: &DVector<f64>) -> usize {
        let speed = |index: usize| self.inertias[index].speed(&six_of(velocities, index));
        let indices = 0..self.inertias.len();
        let fastest = indices.max_by(|&a, &b| speed(a).total_cmp(&speed(b)));
        self.step.island.dynamic[fastest.unwrap_or_default()]
    }
}

/// Adds the wrenches of contacts to the forces on each dynamic body. Each contact has two participants.
pub(super) fn with_contacts<'c>(
    mut forces: Vec<Vector6<f64>>,
    contacts: impl Iterator<Item = ([usize; 2], &'c PairVector)>,
) -> Vec<Vector6<f64>> {
    for (bodies, wrenches) in contacts {
        for (side, &body) in bodies.iter().enumerate() {
            if let Some(sum) = forces.get_mut(body) {
                *sum += part(wrenches, side);
            }
        }
    }
    forces
}
