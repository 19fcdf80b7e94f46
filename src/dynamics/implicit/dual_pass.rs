//! Derivative pass of a step: repeats the stages that were solved in `f64` in a scalar that carries derivatives.
//!
//! Let u₀ be the real solution of a stage, and J the real matrix. Each iteration u = u₀ − J⁻¹·(r(u) − re r(u)) makes the residual r vanish
//! to one more order. By the implicit function theorem, the first iteration gives all first derivatives. All parameters share one
//! factorization.

use super::island_step::{IslandStep, StepError, Substep};
use super::stage::{StageEquations, Stages};
use crate::contact::{ContactWrench, LinearizedContact};
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::multibody::{Kinematics, Multibody};
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, State};
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
    multibody: Multibody<T>,
}

impl<'a, T: Scalar> DualPass<'a, T> {
    pub fn new(
        world: &'a dyn DynWorld<T>,
        step: &'a IslandStep<'a>,
        applied: &'a [Vector6<T>],
    ) -> Self {
        let island = step.island;
        Self {
            world,
            step,
            applied,
            multibody: world
                .model()
                .multibody(island.participants(), step.context.span),
        }
    }

    /// Advances the bodies of the island by a substep, in a state of the world.
    pub fn advance(&self, substep: &Substep, state: &mut State<T>) -> Result<(), StepError> {
        if self.step.context.is_stopped() {
            return Err(StepError::Stopped);
        }
        let neighbors = self.neighbors_at(self.step.start + substep.offset, state);
        let mut end = self
            .multibody
            .kinematics(self.multibody.coordinates(state), &neighbors);
        let mut stages = Stages::new(self.step, &self.multibody, substep.offset, &end);
        let schedule = self.step.scheme.stages(substep.duration);
        for (stage, root) in schedule.zip(&substep.roots) {
            let start = stages.start(&stage);
            let equations = StageEquations {
                step: self.step,
                multibody: &self.multibody,
                applied: self.applied,
                neighbors: self.neighbors_at(start.time, state),
                start,
            };
            end = self.solve(&equations, root, state)?;
            stages.push(&equations.start, &end);
        }
        self.multibody.store(&end, state);
        Ok(())
    }

    /// Sets kinematic neighbors to their states at a time (s), and returns the states of all neighbors. A path carries no derivatives, but
    /// the pose of a fixed body may.
    fn neighbors_at(&self, time: f64, state: &mut State<T>) -> Vec<BodyState<T>> {
        let (context, island) = (self.step.context, self.step.island);
        let neighbors = context.neighbors_at(island, time);
        for (&body, neighbor) in island.neighbors.iter().zip(&neighbors) {
            if context.model.bodies[body].motion.is_kinematic() {
                state.bodies[body] = neighbor.lifted();
            }
        }
        island
            .neighbors
            .iter()
            .map(|&body| state.bodies[body])
            .collect()
    }

    /// Adds the derivatives to the real solution of a stage, and sets the states of the bodies at its end.
    fn solve(
        &self,
        equations: &StageEquations<'_, T>,
        root: &DVector<f64>,
        state: &mut State<T>,
    ) -> Result<Kinematics<T>, StepError> {
        let end = |velocities: &DVector<T>, state: &mut State<T>| {
            let end = equations.end(velocities.clone());
            for (&body, moved) in self.step.island.dynamic.iter().zip(&end.states) {
                state.bodies[body] = *moved;
            }
            end
        };
        let mut velocities = root.map(lift::<T>);
        let mut inverse: Option<DMatrix<f64>> = None;
        for _ in 0..T::NDERIV {
            let moved = end(&velocities, state);
            let (wrenches, contacts) =
                self.wrenches_and_contacts(equations, &state.bodies, inverse.is_none());
            let residual = equations.residual(&moved, &wrenches);
            let inverse = match inverse.take() {
                Some(known) => inverse.insert(known),
                None => inverse.insert(inverse_at(&equations.real(), root, &contacts)?),
            };
            correct(&mut velocities, inverse, &residual);
        }
        Ok(end(&velocities, state))
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
    let end = equations.end(root.clone());
    let contacts = contacts.iter().map(|(bodies, contact)| (*bodies, contact));
    let exact = equations.exact_matrix(&end, contacts);
    let factors = exact
        .matrix
        .factorized(equations.step.context.symbolic_cache);
    factors.inverse().ok_or_else(|| equations.singular())
}

/// Subtracts J⁻¹·(r − re r) from the velocities.
fn correct<T: Scalar>(velocities: &mut DVector<T>, inverse: &DMatrix<f64>, residual: &DVector<T>) {
    for (column, number) in residual.iter().enumerate() {
        let change = change(*number);
        for (velocity, factor) in velocities.iter_mut().zip(&inverse.column(column)) {
            *velocity -= change * *factor;
        }
    }
}
