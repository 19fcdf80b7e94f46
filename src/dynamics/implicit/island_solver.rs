//! State of the solver of an island through a time step.

use super::error_control::ErrorControl;
use super::island_step::{IslandStep, Substep};
use super::report::{BodyErrors, EnergyBalance, Work};
use crate::dynamics::multibody::Kinematics;
use crate::geometry::Aabb;
use nalgebra::DVector;

/// Motion of an island through a time step.
#[derive(Debug)]
pub(super) struct SolvedStep {
    pub substeps: Vec<Substep>,
    pub progress: Progress,
    /// Duration (s) that the errors of the last substep allow for the next substep.
    pub allowed: f64,
    pub work: Work,
    pub energy: EnergyBalance,
    /// Estimated errors of the dynamic bodies.
    pub errors: Vec<BodyErrors>,
    /// Box around each participant in all substeps.
    pub swept: Vec<Aabb>,
}

/// State of an island between two substeps.
#[derive(Debug, Clone)]
pub(super) struct Progress {
    pub kinematics: Kinematics,
    /// Generalized forces of contacts and forces in the last stage. `None` before the first stage. Gravity, controls and joint forces may
    /// change between steps, so they are not included.
    pub forces: Option<DVector<f64>>,
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
    /// Creates a solver from the forces of the last stage and the duration (s) that the last step allowed.
    pub fn new(
        step: &'a IslandStep<'a>,
        tolerance: f64,
        control: ErrorControl,
        (forces, allowed): (Option<DVector<f64>>, f64),
    ) -> Self {
        let (context, multibody) = (step.context, &step.multibody);
        let neighbors = context.neighbors_at(step.island, step.start);
        let kinematics = multibody.kinematics(multibody.coordinates(context.start), &neighbors);
        Self {
            step,
            tolerance,
            control,
            solved: SolvedStep {
                substeps: Vec::new(),
                errors: vec![BodyErrors::default(); multibody.links.len()],
                progress: Progress { kinematics, forces },
                allowed,
                work: Work::default(),
                energy: EnergyBalance::default(),
                swept: Vec::new(),
            },
        }
    }
}
