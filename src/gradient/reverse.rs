use super::dual_widths::{DifferentiableOutcome, MIDDLE, WIDE};
use super::outcome_covectors::{RecordedCovectors, loss_covectors};
use super::slots::Slots;
use super::{Experiment, GradientError, Mode, Outcome, Parameter, RolloutGradient};
use crate::dynamics::{
    DynWorld, KinkSummary, Model, ModelGradient, ReverseSweep, RolloutError, StateGradient, Tape,
    Trajectory, WithModel,
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

    /// Vector–Jacobian product: derivatives of a scalar with respect to the parameters, from its derivatives with respect to the
    /// recorded states. Use this for losses that another program for automatic differentiation differentiates. The cost does not
    /// depend on the number of parameters.
    ///
    /// `by_states` gets the trajectory. It returns the derivatives with respect to the recorded states, starting with the initial
    /// state: for each state one [`StateGradient`] per body, in the order of the world. Derivatives with respect to kinematic
    /// bodies are ignored.
    ///
    /// ```
    /// # use hydroelastic::contact::Shape;
    /// # use hydroelastic::dynamics::{Body, Mass, Material, Plan, StateGradient, World};
    /// # use hydroelastic::gradient::{Experiment, Parameter};
    /// # use hydroelastic::mesh::shapes;
    /// let ball = Shape::new(shapes::icosphere(0.1, 1)?);
    /// let world = World::new(vec![Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?])?;
    /// let experiment = Experiment::new(&world, &Plan::new(1e-3, 500)?.recording_every(500));
    /// // The scalar is half the squared norm of the final position. Two states are recorded.
    /// let by_velocity = experiment.vjp(&[Parameter::initial_velocity("ball")], |trajectory| {
    ///     let shift = *trajectory.last().bodies[0].position();
    ///     let last = StateGradient { shift, ..StateGradient::zero() };
    ///     vec![vec![StateGradient::zero()], vec![last]]
    /// })?;
    /// assert_eq!(by_velocity.norm(), 0.0); // the ball stays at the origin
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// - If the world does not have one of the parameters.
    /// - If the rollout ends early.
    /// - [`GradientError::CovectorCount`] if there is not one [`StateGradient`] for each body in each recorded state.
    /// - [`GradientError::BackwardNotFinite`] if a derivative from `by_states` or of the reverse sweep is not finite.
    /// - [`GradientError::NoFriction`] as in [`Self::jacobian`].
    pub fn vjp(
        &self,
        parameters: &[Parameter],
        by_states: impl FnOnce(&Trajectory) -> Vec<Vec<StateGradient>>,
    ) -> Result<DVector<f64>, GradientError> {
        let ((), gradient) = self.parameter_gradient(parameters, |_, trajectory| {
            let by_states = by_states(trajectory);
            Ok(((), RecordedCovectors::new(by_states, trajectory)?))
        })?;
        Ok(gradient)
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

    /// Nonsmooth points of the rollout, by kind and bodies, with the steps. At these points the rollout has no unique derivative, and both
    /// modes use one of several. If there are many, differences may not agree with a gradient. This method costs as much as a reverse-mode
    /// gradient.
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
        let slots = Slots::resolve(parameters, self.model())?;
        slots.check_friction(self.model())?;
        // Contact laws are dissipative if dissipation or friction is a parameter, even if its value is zero.
        let model = slots.perturbed(self.model(), &vec![0.0; slots.dimension()]);
        let world = WithModel::<f64>::with_model(self.world(), model);
        let (value, gradient) = self.reverse_sweep(&world, false, read)?;
        Ok((value, DVector::from_vec(slots.gradient(&gradient))))
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
            let mut reversal = ReverseSweep::of(&**world, self.plan(), self.stop());
            if by_shapes {
                reversal = reversal.with_shapes();
            }
            let mut tape = Tape::new(&**world, self.plan(), self.memory(), self.stop());
            let trajectory = self.taped(world, &mut tape)?;
            let (value, by_states) = read(world.model(), &trajectory)?;
            Ok((value, self.sweep(reversal, tape, by_states)?))
        })
    }

    /// Derivatives with respect to all inputs of a rollout, from the derivatives with respect to its recorded states.
    fn sweep(
        &self,
        mut reversal: ReverseSweep,
        mut tape: Tape,
        mut by_states: RecordedCovectors,
    ) -> Result<ModelGradient, GradientError> {
        let plan = self.plan();
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

    /// Runs the rollout of a world and records its steps on a tape.
    fn taped(
        &self,
        world: &Arc<dyn DynWorld<f64>>,
        tape: &mut Tape,
    ) -> Result<Trajectory, GradientError> {
        let rollout = self.rollout_of(Arc::clone(world));
        Ok(rollout.run_with_observer(|step, steps| tape.record(step, steps))?)
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
