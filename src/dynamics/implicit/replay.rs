//! Replay of a recorded step in `f64`, for the reverse sweep.

use super::island_step::{IslandRecord, IslandStep, StepError, Substep};
use super::scheme::{Scheme, Stage};
use super::stage::{StageEquations, StageStart, Stages, concatenated, six_of};
use super::{Island, StepContext};
use crate::contact::LinearizedContact;
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia};
use nalgebra::Vector6;

/// Recorded step of an island.
pub(in crate::dynamics) struct Replay<'a> {
    step: IslandStep<'a>,
    substeps: &'a [Substep],
}

/// Replayed substep.
pub(in crate::dynamics) struct ReplayedSubstep<'a> {
    /// States of the dynamic bodies at the start of the substep.
    pub from: Vec<BodyState>,
    pub stages: Vec<ReplayedStage<'a>>,
}

/// Replayed stage.
pub(in crate::dynamics) struct ReplayedStage<'a> {
    pub stage: Stage,
    equations: StageEquations<'a>,
    /// States of all participants at the end of the stage.
    pub states: Vec<BodyState>,
}

impl<'a> Replay<'a> {
    /// Replay of the record of a step that begins at a time (s).
    pub fn new(
        context: &'a StepContext<'a>,
        record: &'a IslandRecord,
        scheme: &'a Scheme,
        start: f64,
    ) -> Self {
        Self {
            step: IslandStep::new(context, &record.island, scheme, start),
            substeps: &record.substeps,
        }
    }

    pub fn island(&self) -> &'a Island {
        self.step.island
    }

    /// Inertias of the dynamic bodies.
    pub fn inertias(&self) -> &[&'a Inertia] {
        &self.step.inertias
    }

    /// Substeps in the order of time.
    pub fn substeps(&self) -> Vec<ReplayedSubstep<'_>> {
        let bodies = self.step.island.dynamic.iter();
        let mut states: Vec<_> = bodies.map(|&body| self.step.context.start[body]).collect();
        let replayed = self.substeps.iter().map(|substep| {
            let replayed = self.substep(substep, states.clone());
            if let Some(last) = replayed.stages.last() {
                states = last.states[..states.len()].to_vec();
            }
            replayed
        });
        replayed.collect()
    }

    fn substep(&self, substep: &Substep, from: Vec<BodyState>) -> ReplayedSubstep<'_> {
        let mut stages = Stages::new(&self.step, &self.step.inertias, substep.offset, from);
        let mut replayed = Vec::new();
        for (stage, root) in self
            .step
            .scheme
            .stages(substep.duration)
            .zip(&substep.roots)
        {
            let equations = StageEquations::new(&self.step, stages.start(&stage));
            let states = equations.states_with(|index| six_of(root, index));
            stages.push(&equations.start, &states);
            replayed.push(ReplayedStage {
                stage,
                equations,
                states,
            });
        }
        ReplayedSubstep {
            from: stages.from,
            stages: replayed,
        }
    }
}

impl ReplayedStage<'_> {
    /// Start of the stage.
    pub fn start(&self) -> &StageStart {
        &self.equations.start
    }

    /// Pairs of participants that may touch, A first.
    pub fn close_pairs(&self) -> Vec<(usize, usize)> {
        let IslandStep {
            context, island, ..
        } = self.equations.step;
        let mut sweep = Sweep::default();
        context
            .close_pairs(island, &self.states, &mut sweep)
            .to_vec()
    }

    /// Solves the transposed linearization of the stage: returns J⁻ᵀ times the gradient with respect to the velocities of each body.
    /// `contacts` has all contacts of the stage, each with its two participants.
    pub fn solve_transposed<'c>(
        &self,
        contacts: impl Iterator<Item = ([usize; 2], &'c LinearizedContact)>,
        by_velocities: &[Vector6<f64>],
    ) -> Result<Vec<Vector6<f64>>, StepError> {
        let context = self.equations.step.context;
        if context.is_stopped() {
            return Err(StepError::Stopped);
        }
        let matrix = self.equations.exact_matrix(&self.states, contacts);
        let factors = matrix.transposed().factorized(context.symbolic_cache);
        let right = concatenated(by_velocities.iter().copied());
        let solution = factors.solve(&right);
        let solution = solution.ok_or_else(|| self.equations.singular())?;
        let indices = 0..by_velocities.len();
        Ok(indices.map(|index| six_of(&solution, index)).collect())
    }
}
