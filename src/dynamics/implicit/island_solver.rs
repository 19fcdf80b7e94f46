//! State of the solver of an island through a time step.

use super::error_control::ErrorControl;
use super::island_step::{IslandStep, Substep};
use super::report::{BodyErrors, EnergyBalance, Work};
use super::stage::concatenated;
use crate::dynamics::BodyState;
use crate::geometry::Aabb;
use nalgebra::{DVector, Vector6};

/// Motion of an island through a time step.
#[derive(Debug)]
pub(super) struct SolvedStep {
    pub substeps: Vec<Substep>,
    pub bodies: Vec<BodyProgress>,
    pub work: Work,
    pub energy: EnergyBalance,
    /// Estimated errors of the dynamic bodies.
    pub errors: Vec<BodyErrors>,
    /// Box around each participant in all substeps.
    pub swept: Vec<Aabb>,
}

/// State of a dynamic body between two substeps.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyProgress {
    pub state: BodyState,
    /// Wrench of contacts and forces in the last stage, without gravity and controls, or `None`
    /// before the first stage.
    pub wrench: Option<Vector6<f64>>,
    /// Duration (s) that the errors of the last substep allow for the next substep.
    pub allowed: f64,
}

/// Solver of the step of an island in the real pass.
pub(super) struct IslandSolver<'a> {
    pub step: &'a IslandStep<'a>,
    /// Tolerance of velocities in a stage, relative to the velocities.
    pub tolerance: f64,
    pub control: ErrorControl,
    pub solved: SolvedStep,
}

impl<'a> IslandSolver<'a> {
    pub fn new(
        step: &'a IslandStep<'a>,
        tolerance: f64,
        control: ErrorControl,
        bodies: Vec<BodyProgress>,
    ) -> Self {
        Self {
            step,
            tolerance,
            control,
            solved: SolvedStep {
                substeps: Vec::new(),
                errors: vec![BodyErrors::default(); bodies.len()],
                bodies,
                work: Work::default(),
                energy: EnergyBalance::default(),
                swept: Vec::new(),
            },
        }
    }
}

/// Velocities of the bodies.
pub(super) fn velocities_of(bodies: &[BodyProgress]) -> DVector<f64> {
    concatenated(bodies.iter().map(|body| body.state.twist.to_vector()))
}
