use super::dual_widths::{DifferentiableOutcome, MIDDLE, WIDE};
use super::outcome_covectors::{RecordedCovectors, loss_covectors};
use super::slots::Slots;
use super::{Experiment, GradientError, Mode, Outcome, Parameter, RolloutGradient};
use crate::dynamics::{
    DynWorld, KinkSummary, Model, ModelGradient, ReverseSweep, RolloutError, Tape, Trajectory,
    WithModel,
};
use crate::parallel::contained;
use nalgebra::DVector;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Experiment {
    /// Mode of [`Self::gradient`] for these parameters: reverse for more than 12 numbers, or for more than 96 numbers if steps are
    /// implicit. The limit is higher for implicit steps because solving an implicit step costs more than propagating dual numbers
    /// through it (`cargo bench --bench reverse`).
    #[must_use]
    pub fn mode_for(&self, parameters: &[Parameter]) -> Mode {
        let count: usize = parameters.iter().map(Parameter::dimension).sum();
        let is_implicit = self.plan().integrator().is_implicit();
        if count > if is_implicit { WIDE } else { MIDDLE } {
            Mode::Reverse
        } else {
            Mode::Forward
        }
    }

    /// Loss and its gradient in reverse mode.
    pub(super) fn reverse_gradient(
        &self,
        parameters: &[Parameter],
        loss: &dyn DifferentiableOutcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        self.parameter_gradient(parameters, |model, trajectory| {
            loss_covectors(loss, model, trajectory)
        })
    }

    /// Loss and its derivatives with respect to all inputs of the rollout, including the shapes of all bodies, in reverse mode.
    ///
    /// A contact of two bodies without dissipation and friction is treated as elastic. It contributes nothing to the derivatives
    /// with respect to dissipation and friction, even if the true derivatives are nonzero.
    ///
    /// # Errors
    /// As [`Self::gradient_with_mode`] in reverse mode.
    pub fn full_gradient(&self, loss: &impl Outcome) -> Result<RolloutGradient, GradientError> {
        let world = WithModel::<f64>::with_model(self.world(), self.model().clone());
        let (value, gradient) = self.reverse_sweep(&world, true, |model, trajectory| {
            loss_covectors(loss, model, trajectory)
        })?;
        Ok(RolloutGradient {
            value,
            model: self.model().clone(),
            gradient,
            has_forces: world.has_forces(),
        })
    }

    /// Nonsmooth points of the rollout, by kind and bodies, with the steps. At these points the
    /// rollout has no unique derivative, and both modes use one of several derivatives. If there
    /// are many of these points, finite differences may not agree with a gradient. This method
    /// costs as much as a reverse-mode gradient.
    ///
    /// # Errors
    /// If the rollout ends early.
    pub fn kinks(&self) -> Result<Vec<KinkSummary>, GradientError> {
        let world = WithModel::<f64>::with_model(self.world(), self.model().clone());
        let ((), gradient) =
            self.reverse_sweep(&world, false, |_, _| Ok(((), RecordedCovectors::zero())))?;
        Ok(gradient.kinks())
    }

    /// Value that `read` returns for the trajectory, and the derivatives with respect to the parameters.
    fn parameter_gradient<V>(
        &self,
        parameters: &[Parameter],
        read: impl FnOnce(&Model, &Trajectory) -> Result<(V, RecordedCovectors), GradientError>,
    ) -> Result<(V, DVector<f64>), GradientError> {
        let (slots, world) = self.world_of(parameters)?;
        let (value, gradient) = self.reverse_sweep(&world, false, read)?;
        Ok((
            value,
            DVector::from_vec(slots.gradient(self.model(), &gradient)),
        ))
    }

    /// The parameters, resolved, and the world that is differentiated with respect to them.
    pub(super) fn world_of(
        &self,
        parameters: &[Parameter],
    ) -> Result<(Slots, Arc<dyn DynWorld<f64>>), GradientError> {
        let slots = Slots::resolve(parameters, self.model())?;
        slots.check_friction(self.model())?;
        let model = slots.differentiated(self.model());
        Ok((slots, WithModel::<f64>::with_model(self.world(), model)))
    }

    /// Value that `read` returns for the trajectory of a world, and the derivatives with respect to all inputs of the rollout. The
    /// shapes are included if `by_shapes` is true.
    fn reverse_sweep<V>(
        &self,
        world: &Arc<dyn DynWorld<f64>>,
        by_shapes: bool,
        read: impl FnOnce(&Model, &Trajectory) -> Result<(V, RecordedCovectors), GradientError>,
    ) -> Result<(V, ModelGradient), GradientError> {
        contained(|| {
            let (trajectory, tape) = self.taped(world)?;
            let (value, by_states) = read(world.model(), &trajectory)?;
            Ok((value, self.sweep(&**world, tape, by_states, by_shapes)?))
        })
    }

    /// Runs the rollout of a world and records its steps on a tape.
    pub(super) fn taped(
        &self,
        world: &Arc<dyn DynWorld<f64>>,
    ) -> Result<(Trajectory, Tape), GradientError> {
        let mut tape = Tape::new(Arc::clone(world), self.plan(), self.memory(), self.stop());
        let rollout = self.rollout_of(Arc::clone(world));
        let trajectory = rollout.run_with_observer(|step, steps| tape.record(step, steps))?;
        Ok((trajectory, tape))
    }

    /// Derivatives with respect to all inputs of a rollout, from the derivatives with respect to its recorded states.
    pub(super) fn sweep(
        &self,
        world: &dyn DynWorld<f64>,
        mut tape: Tape,
        mut by_states: RecordedCovectors,
        by_shapes: bool,
    ) -> Result<ModelGradient, GradientError> {
        let plan = self.plan();
        let mut reversal = ReverseSweep::of(world, plan, self.stop());
        if by_shapes && self.model().has_loops() {
            return Err(GradientError::LoopsWithShapes);
        }
        if by_shapes {
            reversal = reversal.with_shapes();
        }
        by_states.add_to(plan.steps().div_ceil(plan.record_every()), &mut reversal);
        for step in (1..=plan.steps()).rev() {
            if self.stop().load(Ordering::Relaxed) {
                return Err(RolloutError::Stopped.into());
            }
            self.check_finite(&reversal, step + 1)?;
            reversal.step_back(step, tape.rewind_to(step - 1)?)?;
            if plan.records(step - 1) {
                by_states.add_to((step - 1) / plan.record_every(), &mut reversal);
            }
        }
        self.check_finite(&reversal, 1)?;
        Ok(reversal.into_gradient())
    }

    /// Checks that all derivatives of the sweep are finite. `step` is the step that starts from the current state of the sweep,
    /// counted from 1.
    fn check_finite(&self, reversal: &ReverseSweep, step: usize) -> Result<(), GradientError> {
        match reversal.non_finite_body() {
            None => Ok(()),
            Some(body) => Err(GradientError::BackwardNotFinite {
                step,
                body: self.model().bodies[body].name().to_owned(),
            }),
        }
    }
}
