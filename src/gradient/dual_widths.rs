//! Widths of the dual numbers of forward mode, and traits that erase the types of forces and outcomes.
//!
//! Only forces and outcomes are compiled in the crate of the user, once for each width. The rest of an experiment is compiled
//! once, in this library.

use super::Outcome;
use crate::dynamics::{DynWorld, Force, Model, State, Trajectory, WithModel, World, WorldError};
use crate::scalar::{DenseDual, Scalar};
use std::sync::Arc;

/// Widths of the dual numbers that parameters are seeded in. A rollout uses the narrowest width that holds all parameters, or
/// several passes of the widest. Each pass evaluates all contacts, so one wide pass is cheaper than several narrow ones. There
/// are only three widths, because each is compiled separately.
pub(super) const NARROW: usize = 6;
pub(super) const MIDDLE: usize = 12;
pub(super) const WIDE: usize = 96;

/// A world that steps in `f64`, and that can be rebuilt with a changed model in `f64` and in every dual width.
pub(super) trait DifferentiableWorld:
    DynWorld<f64>
    + WithModel<f64>
    + WithModel<DenseDual<NARROW>>
    + WithModel<DenseDual<MIDDLE>>
    + WithModel<DenseDual<WIDE>>
{
    /// The world with another model.
    ///
    /// # Errors
    /// If the forces cannot act on the model.
    fn rebuilt(&self, model: Model) -> Result<Arc<dyn DifferentiableWorld>, WorldError>;
}

impl<F: Force> DifferentiableWorld for World<f64, F> {
    fn rebuilt(&self, model: Model) -> Result<Arc<dyn DifferentiableWorld>, WorldError> {
        let world = World::with_model(self, model);
        Ok(Arc::new(world.with_checked_forces()?))
    }
}

/// An outcome evaluated in the scalar `T`.
pub(super) trait OutcomeIn<T>: Sync {
    /// Numbers of the outcome.
    fn of_trajectory(&self, trajectory: &Trajectory<T>) -> Vec<T>;

    /// Contribution of one recorded state, or `None` if the outcome is not a sum over the recorded states.
    fn share_of(&self, times: &[f64], record: usize, state: &State<T>) -> Option<Vec<T>>;
}

impl<T: Scalar, O: Outcome> OutcomeIn<T> for O {
    fn of_trajectory(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        self.of(trajectory)
    }

    fn share_of(&self, times: &[f64], record: usize, state: &State<T>) -> Option<Vec<T>> {
        self.share(times, record, state)
    }
}

/// An outcome that can be evaluated in `f64` and in every dual width.
pub(super) trait DifferentiableOutcome:
    OutcomeIn<f64>
    + OutcomeIn<DenseDual<NARROW>>
    + OutcomeIn<DenseDual<MIDDLE>>
    + OutcomeIn<DenseDual<WIDE>>
{
}

impl<O> DifferentiableOutcome for O where
    O: OutcomeIn<f64>
        + OutcomeIn<DenseDual<NARROW>>
        + OutcomeIn<DenseDual<MIDDLE>>
        + OutcomeIn<DenseDual<WIDE>>
{
}
