//! Replay of a recorded step in `f64`, for the reverse sweep.

use super::evaluation::ExactMatrix;
use super::island_step::{IslandRecord, IslandStep, StepError, Substep};
use super::scheme::{Scheme, Stage};
use super::stage::{StageEquations, StageStart, Stages};
use super::{Island, StepContext};
use crate::contact::LinearizedContact;
use crate::dynamics::multibody::{Kinematics, Multibody};
use crate::dynamics::sweep::Sweep;
use nalgebra::{DVector, Vector6};

/// Recorded step of an island.
pub(in crate::dynamics) struct Replay<'a> {
    step: IslandStep<'a>,
    substeps: &'a [Substep],
}

/// Replayed substep.
pub(in crate::dynamics) struct ReplayedSubstep<'a> {
    /// Kinematics at the start of the substep.
    pub from: Kinematics,
    pub stages: Vec<ReplayedStage<'a>>,
}

/// Replayed stage.
pub(in crate::dynamics) struct ReplayedStage<'a> {
    pub stage: Stage,
    equations: StageEquations<'a>,
    pub end: Kinematics,
}

/// Solution of the adjoint equation of a stage.
pub(in crate::dynamics) struct StageAdjoint {
    /// λ = J⁻ᵀū: gradient with respect to the negative residual of the equation of motion.
    pub adjoint: DVector<f64>,
    /// Gradient with respect to the negative residuals of loops.
    pub by_loops: DVector<f64>,
    /// Contribution of λ to the gradient with respect to displacements of the positions at the end. Velocities and wrenches are constant.
    pub by_position: DVector<f64>,
    /// Total wrench on each dynamic body about its center of mass.
    pub wrenches: Vec<Vector6<f64>>,
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

    pub fn multibody(&self) -> &Multibody {
        &self.step.multibody
    }

    /// Gradient with respect to the values of constraints, from the gradient with respect to the closing rates of loops.
    pub fn closing_back(&self, by_closing_rates: &DVector<f64>) -> DVector<f64> {
        let mut by_values = by_closing_rates.clone();
        let loops = self.step.multibody.loops.iter();
        for (joint, matrices) in loops.zip(self.step.loop_regularizations()) {
            let (first, count) = (joint.multipliers.start, joint.multipliers.len());
            let product = matrices
                .closing
                .tr_mul(&by_closing_rates.rows(first, count));
            by_values.rows_mut(first, count).copy_from(&product);
        }
        by_values
    }

    /// Substeps in the order of time.
    pub fn substeps(&self) -> Vec<ReplayedSubstep<'_>> {
        let (context, multibody) = (self.step.context, &self.step.multibody);
        let mut coordinates = multibody.coordinates(context.start);
        let replayed = self.substeps.iter().map(|substep| {
            let time = self.step.start + substep.offset;
            let neighbors = context.neighbors_at(self.step.island, time);
            let replayed = self.substep(
                substep,
                multibody.kinematics(coordinates.clone(), &neighbors),
            );
            if let Some(last) = replayed.stages.last() {
                coordinates = last.end.coordinates.clone();
            }
            replayed
        });
        replayed.collect()
    }

    fn substep(&self, substep: &Substep, from: Kinematics) -> ReplayedSubstep<'_> {
        let mut stages = Stages::new(&self.step, &self.step.multibody, substep.offset, &from);
        let mut replayed = Vec::new();
        let schedule = self.step.scheme.stages(substep.duration);
        for (stage, root) in schedule.zip(&substep.roots) {
            let equations = StageEquations::new(&self.step, stages.start(&stage));
            let end = equations.end(root.clone());
            stages.push(&equations.start, &end);
            replayed.push(ReplayedStage {
                stage,
                equations,
                end,
            });
        }
        ReplayedSubstep {
            from,
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
            .close_pairs(island, &self.end.states, &mut sweep)
            .to_vec()
    }

    /// Solves the adjoint equation of the stage for a gradient with respect to the generalized velocities. `contacts` has all contacts of the
    /// stage, each with its two participants.
    pub fn solve_transposed<'c>(
        &self,
        contacts: impl Iterator<Item = ([usize; 2], &'c LinearizedContact)>,
        by_velocities: &DVector<f64>,
    ) -> Result<StageAdjoint, StepError> {
        let context = self.equations.step.context;
        if context.is_stopped() {
            return Err(StepError::Stopped);
        }
        let ExactMatrix { matrix, wrenches } = self.equations.exact_matrix(&self.end, contacts);
        let factors = matrix.transposed().factorized(context.symbolic_cache);
        let multibody = self.equations.multibody;
        let (width, count) = (multibody.width(), multibody.constraint_count());
        let by_unknowns = by_velocities.clone().resize_vertically(width + count, 0.0);
        let adjoint = factors.solve(by_unknowns);
        let adjoint = adjoint.ok_or_else(|| self.equations.singular())?;
        let by_loops = adjoint.rows(width, count).into_owned();
        let adjoint = adjoint.resize_vertically(width, 0.0);
        let slopes = self.equations.position_slopes(&self.end, &wrenches);
        let by_position = -multibody.transposed_product(&slopes, &adjoint);
        Ok(StageAdjoint {
            adjoint,
            by_loops,
            by_position,
            wrenches: self.equations.total_wrenches(&self.end, &wrenches),
        })
    }
}
