use super::dual_pass::DualPass;
use super::error_control::ErrorControl;
use super::island::Island;
use super::island_solver::{IslandSolver, SolvedStep};
use super::island_step::IslandStep;
use super::matrix::SymbolicCache;
use super::report::{BodyErrors, StepReport};
use super::scheme::Scheme;
use super::{IslandRecord, StepContext, StepError};
use crate::dynamics::dyn_world::{BodyDual, DynForce, DynWorld};
use crate::dynamics::model::Model;
use crate::dynamics::multibody::Multibody;
use crate::dynamics::{Accuracy, BodyState, State, TimeSpan};
use crate::geometry::Aabb;
use crate::parallel::mapped_into;
use crate::scalar::{Scalar, carries_derivatives};
use nalgebra::{DVector, Vector6};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// State of an implicit integrator that persists between steps.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct ImplicitIntegratorState {
    /// Model without derivatives.
    model: Model,
    /// Model for the derivatives of forces, or `None` if there are no forces.
    lifted: Option<Model<BodyDual>>,
    coupled: Vec<Vec<usize>>,
    symbolic_cache: SymbolicCache,
    pub last: LastStep,
    /// Records of the islands in the last step.
    pub island_records: Vec<IslandRecord>,
    pub report: StepReport,
    /// Cancel flag. Once it is true, the step ends.
    pub stop: Arc<AtomicBool>,
}

/// Data that a step passes to the next step.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct LastStep {
    /// Generalized forces of contacts, forces and joints on each body at the end of the step, padded with zeros, or `None` before the first
    /// step.
    forces: Vec<Option<Vector6<f64>>>,
    /// Duration (s) that the errors of each body allow for its next substep.
    allowed: Vec<f64>,
}

/// Island and its solved step.
struct SolvedIsland {
    island: Island,
    multibody: Multibody,
    step: SolvedStep,
}

/// Settings of one time step.
pub(in crate::dynamics) struct StepSettings {
    pub scheme: &'static Scheme,
    pub tolerance: f64,
    pub accuracy: Accuracy,
    pub duration: f64,
    /// Time at the end of the step (s).
    pub end: f64,
}

impl ImplicitIntegratorState {
    pub fn of<T: Scalar>(world: &dyn DynWorld<T>, stop: Arc<AtomicBool>) -> Self {
        let model = world.model().real();
        let forces = world.real_forces();
        Self {
            lifted: (!forces.is_empty()).then(|| model.lifted()),
            coupled: forces.coupling_groups(&model.bodies),
            symbolic_cache: SymbolicCache::default(),
            last: LastStep {
                forces: vec![None; model.bodies.len()],
                allowed: vec![f64::INFINITY; model.bodies.len()],
            },
            island_records: Vec::new(),
            report: StepReport::default(),
            stop,
            model,
        }
    }

    /// Replaces the data of the last step.
    pub fn after(self, last: LastStep) -> Self {
        Self { last, ..self }
    }

    /// Context of a time step that begins at a state.
    pub fn context<'a>(
        &'a self,
        forces: &'a dyn DynForce,
        start: &'a State,
        span: TimeSpan,
    ) -> StepContext<'a> {
        StepContext::new(
            (&self.model, forces),
            (self.lifted.as_ref(), &self.coupled, &self.symbolic_cache),
            start,
            span,
            &self.stop,
        )
    }

    /// Advances a state by a step. If the step fails, the state and the integrator state do not change.
    pub fn advance<T: Scalar>(
        &mut self,
        world: &dyn DynWorld<T>,
        state: &mut State<T>,
        step: &StepSettings,
    ) -> Result<(), StepError> {
        let start = state.real();
        let span = TimeSpan::new(state.time, step.duration);
        let context = self.context(world.real_forces(), &start, span);
        let solved = self.solve_islands(&context, state.time, step)?;
        if carries_derivatives::<T>() {
            let mut moved = state.clone();
            let applied = world.model().applied_wrenches(span);
            for solved in &solved {
                let step = IslandStep::new(&context, &solved.island, step.scheme, state.time);
                let pass = DualPass::new(world, &step, &applied);
                for substep in &solved.step.substeps {
                    pass.advance(substep, &mut moved)?;
                }
            }
            *state = moved;
        } else {
            let mut moved = start.clone();
            for SolvedIsland {
                multibody, step, ..
            } in &solved
            {
                multibody.store(&step.progress.kinematics, &mut moved);
            }
            *state = moved.lifted();
        }
        self.keep(solved);
        state.time = step.end;
        world.model().set_prescribed_states(state);
        Ok(())
    }

    fn keep(&mut self, solved: Vec<SolvedIsland>) {
        let count = self.model.bodies.len();
        self.report = StepReport {
            errors: vec![BodyErrors::default(); count],
            ..StepReport::default()
        };
        self.island_records.clear();
        for SolvedIsland {
            island,
            multibody,
            step,
        } in solved
        {
            for (link, errors) in multibody.links.iter().zip(&step.errors) {
                let columns = link.columns.clone();
                self.last.forces[link.body] = step.progress.forces.as_ref().map(|forces| {
                    Vector6::from_fn(|i, _| {
                        if i < columns.len() {
                            forces[columns.start + i]
                        } else {
                            0.0
                        }
                    })
                });
                self.last.allowed[link.body] = step.allowed;
                self.report.errors[link.body] = *errors;
            }
            self.report.islands += 1;
            self.report.work += step.work;
            self.report.energy += step.energy;
            self.island_records.push(IslandRecord {
                island,
                substeps: step.substeps,
            });
        }
    }

    /// Solves all islands. Islands whose bodies reach each other's swept boxes are joined and solved again.
    fn solve_islands(
        &self,
        context: &StepContext,
        start: f64,
        step: &StepSettings,
    ) -> Result<Vec<SolvedIsland>, StepError> {
        let mut boxes = context.predicted_bounds(start, step.duration);
        let mut solved: Vec<SolvedIsland> = Vec::new();
        loop {
            let islands = context.islands(&boxes);
            let mut next_solved: Vec<SolvedIsland> = Vec::new();
            let mut pending: Vec<Island> = Vec::new();
            for island in islands {
                match solved.iter().position(|solved| solved.island == island) {
                    Some(index) => next_solved.push(solved.swap_remove(index)),
                    None => pending.push(island),
                }
            }
            let mut results = Vec::new();
            mapped_into(&mut results, &pending, |island| {
                let island_step = IslandStep::new(context, island, step.scheme, start);
                let control = ErrorControl::new(context, island, step.accuracy);
                let last = self.last.of(&island_step.multibody);
                let solver = IslandSolver::new(&island_step, step.tolerance, control, last);
                let solved = solver.solve(step.duration)?;
                Ok((island_step.multibody, solved))
            });
            let is_done = pending.is_empty();
            for (island, result) in pending.into_iter().zip(results) {
                let (multibody, step) = result?;
                for (participant, swept) in step.swept.iter().enumerate() {
                    let body = island.body(participant);
                    boxes[body] = boxes[body].union(swept);
                }
                next_solved.push(SolvedIsland {
                    island,
                    multibody,
                    step,
                });
            }
            next_solved.sort_by_key(|solved| solved.island.dynamic[0]);
            solved = next_solved;
            if is_done {
                return Ok(solved);
            }
        }
    }
}

impl LastStep {
    /// Generalized forces of an island at the end of the step, and the shortest duration (s) that the errors of its bodies allow.
    fn of(&self, multibody: &Multibody) -> (Option<DVector<f64>>, f64) {
        let mut forces = Some(DVector::zeros(multibody.width()));
        let mut allowed = f64::INFINITY;
        for link in &multibody.links {
            allowed = allowed.min(self.allowed[link.body]);
            forces = forces
                .zip(self.forces[link.body])
                .map(|(mut forces, padded)| {
                    let width = link.columns.len();
                    forces
                        .rows_mut(link.columns.start, width)
                        .copy_from(&padded.rows(0, width));
                    forces
                });
        }
        (forces, allowed)
    }
}

impl StepContext<'_> {
    /// Boxes in which the bodies probably stay during a step.
    fn predicted_bounds(&self, start: f64, duration: f64) -> Vec<Aabb> {
        let fall = self.model.gravity.norm() * duration * duration;
        let of_body = |(body, state): (usize, &BodyState)| {
            let bounds = self.bounds(body, &state.pose);
            let Some(inertia) = self.model.bodies[body].inertia() else {
                let later = [0.5, 1.0]
                    .map(|part| self.model.prescribed_state(body, start + part * duration));
                return later.into_iter().flatten().fold(bounds, |all, state| {
                    all.union(&self.bounds(body, &state.pose))
                });
            };
            let displacement = state.twist.to_vector() * duration;
            let end_bounds = self.bounds(body, &inertia.displaced(&state.pose, &displacement));
            let turn = state.twist.angular.norm() * duration * bounds.half_extents().norm();
            let margin = fall + 0.1 * (state.twist.linear.norm() * duration + turn);
            bounds.union(&end_bounds).inflated(margin)
        };
        self.start.bodies.iter().enumerate().map(of_body).collect()
    }
}
