use super::advance::{BodyProgress, IslandSolver, SolvedStep};
use super::dual_pass::DualPass;
use super::error_control::ErrorControl;
use super::island::Island;
use super::island_step::IslandStep;
use super::matrix::Patterns;
use super::report::{BodyErrors, StepReport};
use super::scheme::Scheme;
use super::{Scene, StepError, Trace};
use crate::dynamics::any_world::{BodyDual, DynForce, DynWorld};
use crate::dynamics::system::System;
use crate::dynamics::{Accuracy, BodyState, State, TimeSpan};
use crate::geometry::Aabb;
use crate::parallel::mapped_into;
use crate::scalar::{Scalar, carries_derivatives};
use nalgebra::Vector6;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What implicit steps keep from one to the next.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Memory {
    /// The system without derivatives.
    system: System,
    /// The system once more, for the derivatives of forces; none if there are no forces.
    lifted: Option<System<BodyDual>>,
    coupled: Vec<Vec<usize>>,
    patterns: Patterns,
    pub last: LastStep,
    /// All islands in the last step.
    pub traces: Vec<Trace>,
    pub report: StepReport,
    /// Ends a step once it is true.
    pub stop: Arc<AtomicBool>,
}

/// What is carried from one step to the next.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct LastStep {
    /// The wrench of contacts and forces on each body at the end of the step; none before the first step.
    acting: Vec<Option<Vector6<f64>>>,
    /// Duration (s) that the errors of each body allow for its next substep.
    allowed: Vec<f64>,
}

/// One time step.
pub(in crate::dynamics) struct Step {
    pub scheme: &'static Scheme,
    pub tolerance: f64,
    pub accuracy: Accuracy,
    pub duration: f64,
    /// The time it leads to (s).
    pub end: f64,
}

impl Memory {
    pub fn of<T: Scalar>(world: &dyn DynWorld<T>, stop: Arc<AtomicBool>) -> Self {
        let system = world.system().real();
        let forces = world.real_forces();
        Self {
            lifted: (!forces.is_empty()).then(|| system.lifted()),
            coupled: forces.coupling_groups(&system.bodies),
            patterns: Patterns::default(),
            last: LastStep {
                acting: vec![None; system.bodies.len()],
                allowed: vec![f64::INFINITY; system.bodies.len()],
            },
            traces: Vec::new(),
            report: StepReport::default(),
            stop,
            system,
        }
    }

    /// The same after a step.
    pub fn after(self, last: LastStep) -> Self {
        Self { last, ..self }
    }

    /// The world from a state on, in a time step.
    pub fn scene<'a>(
        &'a self,
        forces: &'a dyn DynForce,
        start: &'a [BodyState],
        span: TimeSpan,
    ) -> Scene<'a> {
        Scene::new(
            (&self.system, forces),
            (self.lifted.as_ref(), &self.coupled, &self.patterns),
            start,
            span,
            &self.stop,
        )
    }

    /// Takes a state through a step; if that fails, the state and the memory stay as they are.
    pub fn advance<T: Scalar>(
        &mut self,
        world: &dyn DynWorld<T>,
        state: &mut State<T>,
        step: &Step,
    ) -> Result<(), StepError> {
        let start: Vec<BodyState> = state.bodies.iter().map(BodyState::real).collect();
        let span = TimeSpan::new(state.time, step.duration);
        let scene = self.scene(world.real_forces(), &start, span);
        let solved = self.solved(&scene, state.time, step)?;
        if carries_derivatives::<T>() {
            let mut bodies = state.bodies.clone();
            let given = world.system().given(span);
            for (island, solved) in &solved {
                let step = IslandStep::new(&scene, island, step.scheme, state.time);
                let pass = DualPass::new(world, &step, &given);
                for substep in &solved.substeps {
                    pass.advance(substep, &mut bodies)?;
                }
            }
            state.bodies = bodies;
        } else {
            for (island, solved) in &solved {
                for (&body, moved) in island.dynamic.iter().zip(&solved.bodies) {
                    state.bodies[body] = moved.state.lifted();
                }
            }
        }
        self.keep(solved);
        state.time = step.end;
        world.system().place(state);
        Ok(())
    }

    fn keep(&mut self, solved: Vec<(Island, SolvedStep)>) {
        let count = self.system.bodies.len();
        self.report = StepReport {
            errors: vec![BodyErrors::default(); count],
            ..StepReport::default()
        };
        self.traces.clear();
        for (island, step) in solved {
            for (place, (&body, moved)) in island.dynamic.iter().zip(&step.bodies).enumerate() {
                self.last.acting[body] = moved.acting;
                self.last.allowed[body] = moved.allowed;
                self.report.errors[body] = step.errors[place];
            }
            self.report.islands += 1;
            self.report.work += step.work;
            self.report.energy += step.energy;
            self.traces.push(Trace {
                island,
                substeps: step.substeps,
            });
        }
    }

    /// Solves all islands. Islands whose bodies reach each other's swept boxes are joined and solved again.
    fn solved(
        &self,
        scene: &Scene,
        start: f64,
        step: &Step,
    ) -> Result<Vec<(Island, SolvedStep)>, StepError> {
        let mut boxes = scene.reach(start, step.duration);
        let mut solved: Vec<(Island, SolvedStep)> = Vec::new();
        loop {
            let islands = scene.islands(&boxes);
            let mut kept: Vec<(Island, SolvedStep)> = Vec::new();
            let mut due: Vec<Island> = Vec::new();
            for island in islands {
                match solved.iter().position(|(other, _)| *other == island) {
                    Some(place) => kept.push(solved.swap_remove(place)),
                    None => due.push(island),
                }
            }
            let mut results = Vec::new();
            mapped_into(&mut results, &due, |island| {
                let bodies = island.dynamic.iter().map(|&body| BodyProgress {
                    state: scene.start[body],
                    acting: self.last.acting[body],
                    allowed: self.last.allowed[body],
                });
                let island_step = IslandStep::new(scene, island, step.scheme, start);
                let control = ErrorControl::new(scene, island, step.accuracy);
                let solver =
                    IslandSolver::new(&island_step, step.tolerance, control, bodies.collect());
                solver.solve(step.duration)
            });
            let is_done = due.is_empty();
            for (island, result) in due.into_iter().zip(results) {
                let result = result?;
                for (participant, swept) in result.swept.iter().enumerate() {
                    let body = island.body(participant);
                    boxes[body] = boxes[body].union(swept);
                }
                kept.push((island, result));
            }
            kept.sort_by_key(|(island, _)| island.dynamic[0]);
            solved = kept;
            if is_done {
                return Ok(solved);
            }
        }
    }
}

impl Scene<'_> {
    /// Boxes that bodies are likely to stay in during a step.
    fn reach(&self, start: f64, duration: f64) -> Vec<Aabb> {
        let fall = self.system.gravity.norm() * duration * duration;
        let of_body = |(body, state): (usize, &BodyState)| {
            let here = self.bounds(body, &state.pose);
            let Some(inertia) = self.system.bodies[body].inertia() else {
                let later = [0.5, 1.0]
                    .map(|part| self.system.kinematic_state(body, start + part * duration));
                return later.into_iter().flatten().fold(here, |all, state| {
                    all.union(&self.bounds(body, &state.pose))
                });
            };
            let displacement = state.twist.to_vector() * duration;
            let there = self.bounds(body, &inertia.displaced(&state.pose, &displacement));
            let turn = state.twist.angular.norm() * duration * here.half_extents().norm();
            let margin = fall + 0.1 * (state.twist.linear.norm() * duration + turn);
            here.union(&there).inflated(margin)
        };
        self.start.iter().enumerate().map(of_body).collect()
    }
}
