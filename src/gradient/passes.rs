use super::dual_widths::{DifferentiableOutcome, MIDDLE, NARROW, OutcomeIn, WIDE};
use super::error::same_length;
use super::non_finite::{NonFinite, columns_not_finite};
use super::slots::Slots;
use super::{Experiment, GradientError, OutcomeJacobian, Parameter};
use crate::dynamics::{DynWorld, Rollout, WithModel};
use crate::parallel::contained;
use crate::scalar::{DenseDual, lift};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;

/// The outcome, its derivatives, and the first derivative that is not finite.
type Pass = (OutcomeJacobian, Option<NonFinite>);

impl Experiment {
    /// Outcome and its derivatives with respect to the parameters, which may not be finite.
    pub(super) fn jacobian_unchecked(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Pass, GradientError> {
        let slots = Slots::resolve(parameters, self.model())?;
        slots.check_friction(self.model())?;
        let count = slots.dimension();
        let passes = (0..count)
            .step_by(WIDE)
            .map(|first| self.pass(&slots, first..count.min(first + WIDE), outcome))
            .collect::<Result<Vec<_>, _>>()?;
        let (jacobians, non_finite): (Vec<_>, Vec<_>) = passes.into_iter().unzip();
        same_length(jacobians.iter().map(|part| &part.value))?;
        // The real parts of the dual numbers are the rollout in `f64`, so the first pass contains its value.
        let Some(OutcomeJacobian { value, .. }) = jacobians.first() else {
            let value = DVector::from_vec(self.value_of(outcome)?);
            let jacobian = DMatrix::zeros(value.len(), 0);
            return Ok((OutcomeJacobian { value, jacobian }, None));
        };
        let columns: Vec<_> = jacobians
            .iter()
            .flat_map(|part| part.jacobian.column_iter())
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let value = value.clone();
        let non_finite = non_finite.into_iter().flatten();
        let earliest = non_finite.min_by_key(NonFinite::step);
        Ok((OutcomeJacobian { value, jacobian }, earliest))
    }

    /// Runs one pass for a range of at most [`WIDE`] parameter components, with dual numbers of the smallest sufficient width.
    fn pass(
        &self,
        slots: &Slots,
        range: Range<usize>,
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Pass, GradientError> {
        let world = self.world();
        if range.len() <= NARROW {
            self.pass_of::<NARROW>(world, slots, range, outcome)
        } else if range.len() <= MIDDLE {
            self.pass_of::<MIDDLE>(world, slots, range, outcome)
        } else {
            self.pass_of::<WIDE>(world, slots, range, outcome)
        }
    }

    /// Runs one pass for a range of at most `WIDTH` parameter components.
    fn pass_of<const WIDTH: usize>(
        &self,
        world: &dyn WithModel<DenseDual<WIDTH>>,
        slots: &Slots,
        range: Range<usize>,
        outcome: &dyn OutcomeIn<DenseDual<WIDTH>>,
    ) -> Result<Pass, GradientError> {
        // Numbers beyond the range get indices of at least `WIDTH`, so they have no derivative: only a full range is followed by
        // other numbers.
        let seed = |number: usize| match number.checked_sub(range.start) {
            Some(index) => DenseDual::variable(0.0, index),
            None => lift(0.0),
        };
        let seeds: Vec<DenseDual<WIDTH>> = (0..slots.dimension()).map(seed).collect();
        let model = slots.differentiated(self.model());
        let world = world.with_model(slots.perturbed(&model, &seeds));
        let numbers = self.outcome_of(Arc::clone(&world), outcome)?;
        let derivative = |row: usize, column: usize| numbers[row].eps[column];
        let part = OutcomeJacobian {
            value: DVector::from_iterator(numbers.len(), numbers.iter().map(|number| number.re)),
            jacobian: DMatrix::from_fn(numbers.len(), range.len(), derivative),
        };
        let non_finite = self.first_non_finite(world, &part.jacobian)?;
        let non_finite = non_finite.map(|non_finite| non_finite.with_column_offset(range.start));
        Ok((part, non_finite))
    }

    /// First derivative that is not finite, if there is one. Repeats the rollout and examines the state after each step.
    fn first_non_finite<const WIDTH: usize>(
        &self,
        world: Arc<dyn DynWorld<DenseDual<WIDTH>>>,
        jacobian: &DMatrix<f64>,
    ) -> Result<Option<NonFinite>, GradientError> {
        let Some(in_outcome) = NonFinite::in_outcome(jacobian) else {
            return Ok(None);
        };
        let columns = columns_not_finite(jacobian);
        let mut rollout = Rollout::of(world, self.plan()).with_cancel_flag(self.stop());
        for step in 0..=self.plan().steps() {
            if step > 0 {
                contained(|| rollout.advance().map(|_| ()))?;
            }
            let in_state = NonFinite::in_state(step, rollout.state(), &columns);
            if in_state.is_some() {
                return Ok(in_state);
            }
        }
        Ok(Some(in_outcome))
    }
}
