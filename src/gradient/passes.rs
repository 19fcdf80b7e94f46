use super::breakdown::{Breakdown, columns_not_finite};
use super::error::same_length;
use super::slots::Slots;
use super::widths::{DifferentiableOutcome, MIDDLE, NARROW, OutcomeIn, WIDE};
use super::{Experiment, GradientError, OutcomeJacobian, Parameter};
use crate::dynamics::{DynWorld, Rollout, WithModel};
use crate::parallel::contained;
use crate::scalar::{DenseDual, lift};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;

/// The outcome, its derivatives, and where one of them stopped being finite.
type Pass = (OutcomeJacobian, Option<Breakdown>);

impl Experiment {
    /// The outcome and its derivatives by the parameters, whether finite or not.
    pub(super) fn differentiated(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<Pass, GradientError> {
        let slots = Slots::resolve(parameters, self.system())?;
        slots.check_friction(self.system())?;
        let count = slots.dimension();
        let passes = (0..count)
            .step_by(WIDE)
            .map(|first| self.pass(&slots, first..count.min(first + WIDE), outcome))
            .collect::<Result<Vec<_>, _>>()?;
        let (found, breakdowns): (Vec<_>, Vec<_>) = passes.into_iter().unzip();
        same_length(found.iter().map(|pass| &pass.value))?;
        // Real parts of dual numbers are the rollout in `f64`, so its value comes with the first pass.
        let Some(OutcomeJacobian { value, .. }) = found.first() else {
            let value = DVector::from_vec(self.value_of(outcome)?);
            let jacobian = DMatrix::zeros(value.len(), 0);
            return Ok((OutcomeJacobian { value, jacobian }, None));
        };
        let columns: Vec<_> = found
            .iter()
            .flat_map(|pass| pass.jacobian.column_iter())
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let value = value.clone();
        let breakdowns = breakdowns.into_iter().flatten();
        let earliest = breakdowns.min_by_key(Breakdown::step);
        Ok((OutcomeJacobian { value, jacobian }, earliest))
    }

    /// The same by up to [`WIDE`] numbers of the parameters.
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

    /// The same by the numbers of the parameters in a range, at most `WIDTH`.
    fn pass_of<const WIDTH: usize>(
        &self,
        world: &dyn WithModel<DenseDual<WIDTH>>,
        slots: &Slots,
        range: Range<usize>,
        outcome: &dyn OutcomeIn<DenseDual<WIDTH>>,
    ) -> Result<Pass, GradientError> {
        // Numbers beyond the range have indices beyond the width, and so no derivative: only a full range has any behind it.
        let seed = |number: usize| match number.checked_sub(range.start) {
            Some(index) => DenseDual::variable(0.0, index),
            None => lift(0.0),
        };
        let seeds: Vec<DenseDual<WIDTH>> = (0..slots.dimension()).map(seed).collect();
        let world = world.with_model(slots.perturbed(self.system(), &seeds));
        let numbers = self.outcome_of(Arc::clone(&world), outcome)?;
        let derivative = |row: usize, column: usize| numbers[row].eps[column];
        let found = OutcomeJacobian {
            value: DVector::from_iterator(numbers.len(), numbers.iter().map(|number| number.re)),
            jacobian: DMatrix::from_fn(numbers.len(), range.len(), derivative),
        };
        let breakdown = self.breakdown(world, &found.jacobian)?;
        Ok((found, breakdown.map(|it| it.by_later_number(range.start))))
    }

    /// Where a derivative of the outcome stopped being finite, if one did: the same steps once more, and
    /// a look at every state.
    fn breakdown<const WIDTH: usize>(
        &self,
        world: Arc<dyn DynWorld<DenseDual<WIDTH>>>,
        jacobian: &DMatrix<f64>,
    ) -> Result<Option<Breakdown>, GradientError> {
        let Some(in_outcome) = Breakdown::in_outcome(jacobian) else {
            return Ok(None);
        };
        let columns = columns_not_finite(jacobian);
        let mut rollout = Rollout::of(world, self.plan()).with_cancel_flag(self.stop());
        for step in 0..=self.plan().steps() {
            if step > 0 {
                contained(|| rollout.advance().map(|_| ()))?;
            }
            let in_state = Breakdown::in_state(step, rollout.state(), &columns);
            if in_state.is_some() {
                return Ok(in_state);
            }
        }
        Ok(Some(in_outcome))
    }
}
