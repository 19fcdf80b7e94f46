//! Derivative pass of a step: repeats the stages that were solved in `f64` in a scalar that carries derivatives.
//!
//! Let u₀ be the real solution of a stage, and J the real matrix. Each iteration u = u₀ − J⁻¹·(r(u) − re r(u)) makes the residual r vanish
//! to one more order. By the implicit function theorem, the first iteration gives all first derivatives. All parameters share one
//! factorization.

use super::island_step::{IslandStep, StepError, Substep};
use super::rigid::zero6;
use super::stage::{StageEquations, Stages, six_of};
use crate::contact::{ContactWrench, LinearizedContact};
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia};
use crate::parallel::mapped_into;
use crate::scalar::{Scalar, change, lift};
use crate::spatial::Wrench;
use nalgebra::{DMatrix, DVector, Vector6};

/// Linearized contact of two participants.
type Linearized = ([usize; 2], LinearizedContact);

/// Step of an island in a scalar that carries derivatives.
pub(super) struct DualPass<'a, T> {
    world: &'a dyn DynWorld<T>,
    step: &'a IslandStep<'a>,
    /// Weight and control of each body of the world.
    applied: &'a [Vector6<T>],
    /// Inertias of the dynamic bodies.
    inertias: Vec<&'a Inertia<T>>,
}

impl<'a, T: Scalar> DualPass<'a, T> {
    pub fn new(
        world: &'a dyn DynWorld<T>,
        step: &'a IslandStep<'a>,
        applied: &'a [Vector6<T>],
    ) -> Self {
        let bodies = &world.model().bodies;
        let dynamic = step.island.dynamic.iter();
        Self {
            world,
            step,
            applied,
            inertias: dynamic.filter_map(|&body| bodies[body].inertia()).collect(),
        }
    }

    /// Advances the bodies of the island by a substep. `states` has the states of all bodies of the world.
    pub fn advance(&self, substep: &Substep, states: &mut [BodyState<T>]) -> Result<(), StepError> {
        if self.step.context.is_stopped() {
            return Err(StepError::Stopped);
        }
        let island = self.step.island;
        let from = island.dynamic.iter().map(|&body| states[body]).collect();
        let mut stages = Stages::new(self.step, &self.inertias, substep.offset, from);
        for (stage, root) in self
            .step
            .scheme
            .stages(substep.duration)
            .zip(&substep.roots)
        {
            let start = stages.start(&stage);
            let neighbors = self.step.context.neighbors_at(island, start.time);
            for (&body, state) in island.neighbors.iter().zip(&neighbors) {
                // A path carries no derivatives, but the pose of a fixed body may.
                if self.step.context.model.bodies[body].motion.is_kinematic() {
                    states[body] = state.lifted();
                }
            }
            let equations = StageEquations {
                step: self.step,
                inertias: &self.inertias,
                applied: self.applied,
                start,
                neighbors: island.neighbors.iter().map(|&body| states[body]).collect(),
            };
            self.solve(&equations, root, states)?;
            let ends: Vec<_> = island.dynamic.iter().map(|&body| states[body]).collect();
            stages.push(&equations.start, &ends);
        }
        Ok(())
    }

    /// Adds the derivatives to the real solution of a stage, and sets the states at its end.
    fn solve(
        &self,
        equations: &StageEquations<'_, T>,
        root: &DVector<f64>,
        states: &mut [BodyState<T>],
    ) -> Result<(), StepError> {
        let lifted = (0..self.inertias.len()).map(|index| six_of(root, index).map(lift));
        let mut velocities: Vec<Vector6<T>> = lifted.collect();
        let set = |velocities: &[Vector6<T>], states: &mut [BodyState<T>]| {
            let moved = equations.states_with(|index| velocities[index]);
            for (&body, state) in self.step.island.dynamic.iter().zip(&moved) {
                states[body] = *state;
            }
            moved
        };
        let mut inverse: Option<DMatrix<f64>> = None;
        for _ in 0..T::NDERIV {
            let moved = set(&velocities, states);
            let (wrenches, contacts) =
                self.wrenches_and_contacts(equations, states, inverse.is_none());
            let residual = equations.residual(&moved, &wrenches);
            let inverse = match inverse.take() {
                Some(known) => inverse.insert(known),
                None => inverse.insert(inverse_at(&equations.real(), root, &contacts)?),
            };
            correct(&mut velocities, inverse, &residual);
        }
        set(&velocities, states);
        Ok(())
    }

    /// Wrenches of contacts and forces on the dynamic bodies, and the linearized contacts if `wants_contacts` is true.
    fn wrenches_and_contacts(
        &self,
        equations: &StageEquations<'_, T>,
        states: &[BodyState<T>],
        wants_contacts: bool,
    ) -> (Vec<Vector6<T>>, Vec<Linearized>) {
        let (context, island) = (self.step.context, self.step.island);
        let model = self.world.model();
        let real: Vec<_> = island.bodies().map(|body| states[body].real()).collect();
        let mut sweep = Sweep::default();
        let pairs = context.close_pairs(island, &real, &mut sweep);
        let mut results = Vec::new();
        mapped_into(&mut results, pairs, |&(i, j)| {
            let pair = [i, j];
            let [a, b] = pair.map(|participant| island.body(participant));
            if !wants_contacts {
                return Some((pair, model.pair_wrench(states, a, b), None));
            }
            let contact = model.pair_of([a, b], [&states[a], &states[b]])?;
            let (wrench, linearized) = contact.wrench_and_linearized();
            Some((pair, wrench, Some(linearized)))
        });
        let mut contact = vec![Wrench::zero(); states.len()];
        let mut contacts = Vec::new();
        for (pair, ContactWrench { on_a, on_b }, linearized) in results.into_iter().flatten() {
            for (participant, wrench) in pair.into_iter().zip([on_a, on_b]) {
                let body = island.body(participant);
                let inertia = model.bodies[body].inertia();
                contact[body] += inertia.map_or(wrench, |inertia| {
                    let arm = states[body].pose.rotated_constant(&inertia.center_of_mass);
                    wrench.about(&arm)
                });
            }
            contacts.extend(linearized.map(|linearized| (pair, linearized)));
        }
        let mut all = contact.clone();
        let inputs = (equations.start.time, states, &*contact);
        model.with_forces(inputs, &mut all, |wrenches, now| {
            self.world.add_forces(wrenches, now);
        });
        let dynamic = island.dynamic.iter();
        (
            dynamic.map(|&body| all[body].to_vector()).collect(),
            contacts,
        )
    }
}

/// Inverse J⁻¹ at the real solution of a stage.
fn inverse_at(
    equations: &StageEquations,
    root: &DVector<f64>,
    contacts: &[Linearized],
) -> Result<DMatrix<f64>, StepError> {
    let states = equations.states_with(|index| six_of(root, index));
    let contacts = contacts.iter().map(|(bodies, contact)| (*bodies, contact));
    let matrix = equations.exact_matrix(&states, contacts);
    let factors = matrix.factorized(equations.step.context.symbolic_cache);
    factors.inverse().ok_or_else(|| equations.singular())
}

/// Subtracts J⁻¹·(r − re r) from the velocities.
fn correct<T: Scalar>(
    velocities: &mut [Vector6<T>],
    inverse: &DMatrix<f64>,
    residual: &[Vector6<T>],
) {
    let changes: Vec<T> = residual
        .iter()
        .flatten()
        .map(|&number| change(number))
        .collect();
    for (index, velocities_of_body) in velocities.iter_mut().enumerate() {
        let mut step: Vector6<T> = zero6();
        for (column, number) in changes.iter().enumerate() {
            for row in 0..6 {
                step[row] += *number * inverse[(6 * index + row, column)];
            }
        }
        *velocities_of_body -= step;
    }
}
