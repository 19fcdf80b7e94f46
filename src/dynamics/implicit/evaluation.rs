//! Equations of a stage near a solution: contacts, forces and their derivatives, in `f64`.

use super::about_centers::{PairVector, joined, part};
use super::frozen_contact_model::{FrozenContactModel, NearbyWrenches, PairWrenches};
use super::island_step::StepError;
use super::matrix::BlockMatrix;
use super::stage::StageEquations;
use crate::contact::LinearizedContact;
use crate::dynamics::BodyState;
use crate::dynamics::multibody::{Directions, Kinematics};
use crate::dynamics::rigid_motion::displacement;
use crate::dynamics::sweep::Sweep;
use crate::parallel::mapped_into;
use nalgebra::{DMatrix, DVector, Matrix6, Vector6};

/// Contacts and forces at given velocities, with a local model of both.
pub(super) struct Evaluation {
    pub end: Kinematics,
    /// Contact models, in boxes because a model is expensive to move.
    pub contacts: Vec<Box<FrozenContactModel>>,
    /// Sum of the wrenches of contacts and forces on each dynamic body.
    pub wrenches: Vec<Vector6<f64>>,
    /// Forces other than contact on each dynamic body. Empty if the world has no forces.
    forces: Vec<Vector6<f64>>,
    pub force_jacobians: Vec<ForceJacobian>,
    /// Whether the derivatives of the contacts are exact.
    pub is_exact: bool,
}

/// State near an evaluated state, with the contact polygons of the evaluated state.
pub(super) struct NearbyState {
    pub end: Kinematics,
    contacts: Vec<NearbyWrenches>,
    wrenches: Vec<Vector6<f64>>,
    pub residual: DVector<f64>,
}

/// Matrix of a stage at its solution, and the wrenches of contacts and forces on the dynamic bodies.
pub(super) struct ExactMatrix {
    pub matrix: BlockMatrix,
    pub wrenches: Vec<Vector6<f64>>,
}

/// Derivatives of the wrench on one body with respect to the displacement and the velocities of another body.
pub(super) struct ForceJacobian {
    pub row: usize,
    pub column: usize,
    pub by_displacement: Matrix6<f64>,
    pub by_velocities: Matrix6<f64>,
}

impl StageEquations<'_> {
    /// Evaluates contacts and forces at given unknowns. Only this function of the solver searches for contacts.
    pub fn evaluation(&self, unknowns: DVector<f64>, is_exact: bool) -> Evaluation {
        let (context, island) = (self.step.context, self.step.island);
        let end = self.end(unknowns);
        let states = &*end.states;
        let mut sweep = Sweep::default();
        let pairs = context.close_pairs(island, states, &mut sweep);
        let mut models = Vec::new();
        mapped_into(&mut models, pairs, |&(i, j)| {
            let pair = context.pair(island, [i, j], states)?;
            FrozenContactModel::of(&pair, [i, j], is_exact).map(Box::new)
        });
        let contacts: Vec<_> = models.into_iter().flatten().collect();
        let (mut forces, mut force_jacobians) =
            (vec![Vector6::zeros(); island.dynamic.len()], Vec::new());
        if !context.forces.is_empty() {
            let wrenches: Vec<_> = contacts.iter().map(|model| model.evaluated()).collect();
            forces = self.forces(self.start.time, states, &wrenches);
            force_jacobians = self.force_jacobians(states, &wrenches);
        }
        let contact_wrenches = contacts
            .iter()
            .map(|contact| (contact.bodies, contact.wrenches));
        Evaluation {
            wrenches: with_contacts(forces.clone(), contact_wrenches),
            is_exact: is_exact || !contacts.iter().any(|model| model.is_dissipative()),
            end,
            contacts,
            forces,
            force_jacobians,
        }
    }

    /// Residual in an evaluated state.
    pub fn residual_in(&self, evaluation: &Evaluation) -> DVector<f64> {
        self.residual(&evaluation.end, &evaluation.wrenches)
    }

    /// State at unknowns near those of an evaluated state, with the contact polygons of the evaluated state.
    pub fn near(&self, evaluation: &Evaluation, unknowns: DVector<f64>) -> NearbyState {
        let end = self.end(unknowns);
        let count = self.step.island.dynamic.len();
        let changes = |participant: usize| {
            let [from, to] =
                [&evaluation.end.states, &end.states].map(|states| &states[participant]);
            let inertia = &self.multibody.links[participant].inertia;
            [
                displacement(inertia, &from.pose, &to.pose),
                to.twist.to_vector() - from.twist.to_vector(),
            ]
        };
        let changes: Vec<_> = (0..count).map(changes).collect();
        let near = |contact: &FrozenContactModel| {
            let of = |kind: usize| {
                joined(
                    contact
                        .bodies
                        .map(|body| changes.get(body).map(|change| change[kind])),
                )
            };
            contact.near(&of(0), &of(1))
        };
        let mut contacts = Vec::new();
        mapped_into(&mut contacts, &evaluation.contacts, |contact| near(contact));
        let mut forces = evaluation.forces.clone();
        for slopes in &evaluation.force_jacobians {
            let [displacement, velocities] = &changes[slopes.column];
            forces[slopes.row] +=
                slopes.by_displacement * displacement + slopes.by_velocities * velocities;
        }
        let contact_wrenches = evaluation
            .contacts
            .iter()
            .zip(&contacts)
            .map(|(model, near)| (model.bodies, near.wrenches));
        let wrenches = with_contacts(forces, contact_wrenches);
        NearbyState {
            residual: self.residual(&end, &wrenches),
            end,
            contacts,
            wrenches,
        }
    }

    /// Derivatives of the residual with respect to the unknowns, at a state near an evaluated state.
    pub fn matrix_near(&self, evaluation: &Evaluation, state: &NearbyState) -> BlockMatrix {
        let contacts = evaluation.contacts.iter().zip(&state.contacts);
        let contacts: Vec<_> = contacts
            .map(|(model, near)| model.linearized(near))
            .collect();
        self.matrix(
            &state.end,
            &state.wrenches,
            &contacts,
            &evaluation.force_jacobians,
        )
    }

    /// Matrix at the solution, from the exact derivatives of the contacts. Each contact has two participants.
    pub fn exact_matrix<'c>(
        &self,
        end: &Kinematics,
        contacts: impl Iterator<Item = ([usize; 2], &'c LinearizedContact)>,
    ) -> ExactMatrix {
        let (context, island) = (self.step.context, self.step.island);
        let contacts: Vec<_> = contacts
            .map(|(bodies, contact)| {
                let geometry = context.geometry(island, bodies, &end.states);
                PairWrenches::of(&geometry, bodies, contact)
            })
            .collect();
        let wrenches = self.wrenches(&end.states, &contacts);
        let forces = self.force_jacobians(&end.states, &contacts);
        let matrix = self.matrix(end, &wrenches, &contacts, &forces);
        ExactMatrix { matrix, wrenches }
    }

    /// Derivatives of the residual with respect to the positions at the end, at constant velocities and constant wrenches about the centers
    /// of mass. Each tree has one matrix.
    pub fn position_slopes(
        &self,
        end: &Kinematics,
        wrenches: &[Vector6<f64>],
    ) -> Vec<DMatrix<f64>> {
        let directions = end.position_directions(self.start.duration);
        self.slopes_along(&directions, (end, wrenches), [1.0, 0.0])
    }

    /// Derivatives of the residual along directions, at constant wrenches about the centers of mass. Each tree has one matrix. In its
    /// direction, the position and the velocity of a revolute or prismatic joint change by `joint_changes`.
    pub fn slopes_along(
        &self,
        directions: &Directions,
        (end, wrenches): (&Kinematics, &[Vector6<f64>]),
        joint_changes: [f64; 2],
    ) -> Vec<DMatrix<f64>> {
        let (multibody, duration) = (self.multibody, self.start.duration);
        let mut slopes = multibody.momentum_slopes(end, directions);
        let total = self.total_wrenches(end, wrenches);
        multibody.add_force_slopes(&mut slopes, (end, directions), &total, -duration);
        let (coordinates, time) = (&end.coordinates, self.start.time);
        let changes = (joint_changes, -duration);
        multibody.add_joint_force_slopes(&mut slopes, (coordinates, time), changes);
        slopes
    }

    /// Wrenches of contacts and forces on the dynamic bodies.
    pub fn wrenches(&self, states: &[BodyState], contacts: &[PairWrenches]) -> Vec<Vector6<f64>> {
        let context = self.step.context;
        let forces = if context.forces.is_empty() {
            vec![Vector6::zeros(); self.step.island.dynamic.len()]
        } else {
            self.forces(self.start.time, states, contacts)
        };
        let contacts = contacts
            .iter()
            .map(|contact| (contact.bodies, contact.wrenches));
        with_contacts(forces, contacts)
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
        self.step
            .speeds(velocities)
            .map(|speed| speed * speed)
            .sum::<f64>()
            .sqrt()
    }

    /// World index of the body with the largest speed.
    pub fn fastest(&self, velocities: &DVector<f64>) -> usize {
        let speeds = self.step.speeds(velocities).enumerate();
        let fastest = speeds.max_by(|(_, a), (_, b)| a.total_cmp(b));
        self.step.island.dynamic[fastest.map_or(0, |(index, _)| index)]
    }
}

/// Adds the wrenches of contacts to the forces on each dynamic body. Each contact has two participants.
pub(super) fn with_contacts(
    mut forces: Vec<Vector6<f64>>,
    contacts: impl Iterator<Item = ([usize; 2], PairVector)>,
) -> Vec<Vector6<f64>> {
    for (bodies, wrenches) in contacts {
        for (side, &body) in bodies.iter().enumerate() {
            if let Some(sum) = forces.get_mut(body) {
                *sum += part(&wrenches, side);
            }
        }
    }
    forces
}
