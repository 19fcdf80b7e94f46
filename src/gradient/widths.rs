//! The dual numbers that rollouts are differentiated in, and what a program brings to them: its world's forces and its
//! outcome. All else of an experiment is compiled once, in this library.

use super::Outcome;
use crate::dynamics::{DynWorld, Force, State, Trajectory, WithModel, World};
use crate::scalar::{DenseDual, Scalar};

/// Widths of the dual numbers that parameters are seeded in: the narrowest that holds them all, or the widest several times.
/// Contacts are evaluated once a pass, so a wide pass is cheaper than several; but each width is compiled, so they are few.
pub(super) const NARROW: usize = 6;
pub(super) const MIDDLE: usize = 12;
pub(super) const WIDE: usize = 96;

/// A world that steps in `f64`, and after a change in `f64` and in every width.
pub(super) trait DifferentiableWorld:
    DynWorld<f64>
    + WithModel<f64>
    + WithModel<DenseDual<NARROW>>
    + WithModel<DenseDual<MIDDLE>>
    + WithModel<DenseDual<WIDE>>
{
}

impl<F: Force> DifferentiableWorld for World<f64, F> {}

/// An outcome in `T`.
pub(super) trait OutcomeIn<T>: Sync {
    /// The numbers of interest.
    fn of_trajectory(&self, trajectory: &Trajectory<T>) -> Vec<T>;

    /// What one recorded state adds to them, if they are a sum.
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

/// An outcome in `f64` and in every width.
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
