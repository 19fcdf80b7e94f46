use super::outcome_covectors::{RecordedCovectors, of_outcome};
use super::slots::Slots;
use super::widths::{DifferentiableOutcome, MIDDLE, WIDE};
use super::{Experiment, GradientError, Outcome, Parameter, RolloutGradient};
use crate::dynamics::{
    DynWorld, KinkSummary, Model, ModelGradient, ReverseSweep, RolloutError, StateGradient, Tape,
    Trajectory, WithModel,
};
use crate::parallel::contained;
use nalgebra::DVector;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// From which end a rollout is differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mode {
    /// By dual numbers, from the parameters to all later states: the time grows with the numbers of the parameters, up to 96
    /// of which share one rollout, and not with the numbers of the outcome.
    Forward,
    /// From the outcome back to the start, step by step, from states that were kept or are computed again: for an outcome of one
    /// number, in a time that does not depend on the number of parameters.
    Reverse,
}

impl Experiment {
    /// Mode of [`Self::gradient`] for these parameters: reverse for more than 12 numbers, or for more than 96 if steps are implicit,
    /// because solving an implicit step costs more than carrying derivatives along (`cargo bench --bench reverse`).
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

    /// The derivatives of a number by the parameters, from those by the recorded states: the transpose of the Jacobian of all
    /// states, times a vector, in a time that does not depend on the number of parameters. For losses that are differentiated
    /// elsewhere, by a program for automatic differentiation.
    ///
    /// `by_states` gets the trajectory and returns the derivatives by its states, the initial one first: for each state those by
    /// all bodies, in the order of the world's. Those by bodies that follow a path are ignored.
    ///
    /// ```
    /// # use hydroelastic::contact::Shape;
    /// # use hydroelastic::dynamics::{Body, Mass, Material, Plan, StateGradient, World};
    /// # use hydroelastic::gradient::{Experiment, Parameter};
    /// # use hydroelastic::mesh::shapes;
    /// let ball = Shape::new(shapes::icosphere(0.1, 1)?);
    /// let world = World::new(vec![Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?])?;
    /// let experiment = Experiment::new(&world, &Plan::new(1e-3, 500)?.recording_every(500));
    /// // Half the square of the last position, of two recorded states.
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
    /// - If a parameter is not one of the world's, or the rollout ends early.
    /// - [`GradientError::CovectorCount`] if there is not one [`StateGradient`] for each body in each recorded state.
    /// - [`GradientError::BackwardNotFinite`] if one is not finite, or the sweep meets one that is not.
    /// - [`GradientError::NoFriction`] as of [`Self::jacobian`].
    pub fn vjp(
        &self,
        parameters: &[Parameter],
        by_states: impl FnOnce(&Trajectory) -> Vec<Vec<StateGradient>>,
    ) -> Result<DVector<f64>, GradientError> {
        let ((), found) = self.pulled_back(parameters, |_, trajectory| {
            let by_states = by_states(trajectory);
            Ok(((), RecordedCovectors::new(by_states, trajectory)?))
        })?;
        Ok(found)
    }

    /// A loss and its gradient, by a sweep back from the outcome.
    pub(super) fn swept_back(
        &self,
        parameters: &[Parameter],
        loss: &dyn DifferentiableOutcome,
    ) -> Result<(f64, DVector<f64>), GradientError> {
        self.pulled_back(parameters, |system, trajectory| {
            of_outcome(loss, system, trajectory)
        })
    }

    /// A loss and its derivatives by all that the rollout depends on, the shapes of all bodies among them: by a sweep back from
    /// the outcome.
    ///
    /// Where neither of two bodies has dissipation or friction, their contact is taken as elastic: it then adds nothing to the
    /// derivatives by dissipation and friction, although there may be some.
    ///
    /// # Errors
    /// As [`Self::gradient_with_mode`] backwards.
    pub fn full_gradient(&self, loss: &impl Outcome) -> Result<RolloutGradient, GradientError> {
        let world = WithModel::<f64>::with_model(self.world(), self.system().clone());
        let (value, gradient) = self.swept(&world, true, |system, trajectory| {
            of_outcome(loss, system, trajectory)
        })?;
        Ok(RolloutGradient {
            value,
            system: self.system().clone(),
            gradient,
            has_forces: world.has_forces(),
        })
    }

    /// Where the rollout has no derivative, or one of several is taken, forwards and backwards alike: by kind and bodies, with the
    /// steps. Where there are many, differences may not agree with a gradient. Takes as long as a gradient swept back.
    ///
    /// # Errors
    /// If the rollout ends early.
    pub fn kinks(&self) -> Result<Vec<KinkSummary>, GradientError> {
        let world = WithModel::<f64>::with_model(self.world(), self.system().clone());
        let ((), gradient) =
            self.swept(&world, false, |_, _| Ok(((), RecordedCovectors::none())))?;
        Ok(gradient.kinks())
    }

    /// What is read from the trajectory, and the derivatives by the parameters.
    fn pulled_back<V>(
        &self,
        parameters: &[Parameter],
        read: impl FnOnce(&Model, &Trajectory) -> Result<(V, RecordedCovectors), GradientError>,
    ) -> Result<(V, DVector<f64>), GradientError> {
        let slots = Slots::resolve(parameters, self.system())?;
        slots.check_friction(self.system())?;
        // Contact laws are dissipative if dissipation or friction is a parameter, even if its value is zero.
        let system = slots.perturbed(self.system(), &vec![0.0; slots.dimension()]);
        let world = WithModel::<f64>::with_model(self.world(), system);
        let (value, gradient) = self.swept(&world, false, read)?;
        Ok((value, DVector::from_vec(slots.gradient(&gradient))))
    }

    /// What is read from the trajectory of a world, and the derivatives by all that the rollout depends on, with or without
    /// shapes.
    fn swept<V>(
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

    /// The derivatives by all that a rollout depends on, from those by its recorded states.
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

    /// The rollout of a world, with its states on a tape.
    fn taped(
        &self,
        world: &Arc<dyn DynWorld<f64>>,
        tape: &mut Tape,
    ) -> Result<Trajectory, GradientError> {
        let rollout = self.rollout_of(Arc::clone(world));
        Ok(rollout.run_with_observer(|taken, steps| tape.record(taken, steps))?)
    }

    fn check_finite(&self, reversal: &ReverseSweep, step: usize) -> Result<(), GradientError> {
        match reversal.non_finite_body() {
            None => Ok(()),
            Some(body) => Err(GradientError::BackwardNotFinite {
                step,
                body: self.system().bodies[body].name().to_owned(),
            }),
        }
    }
}
