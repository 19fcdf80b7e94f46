use super::outcome_covectors::RecordedCovectors;
use super::slots::Slots;
use super::{Experiment, GradientError, Parameter};
use crate::dynamics::{DynWorld, StateGradient, Tape, Trajectory};
use crate::parallel::contained;
use nalgebra::DVector;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Vector–Jacobian product of a rollout: maps derivatives of a scalar with respect to the recorded states to its derivatives with
/// respect to parameters.
///
/// It keeps the recorded steps of the rollout, in the memory of [`Experiment::with_memory`]. [`Self::pull_back`] uses them
/// up: clone the product for several losses of one rollout.
#[derive(Clone)]
pub struct VectorJacobianProduct {
    experiment: Experiment,
    world: Arc<dyn DynWorld<f64>>,
    slots: Slots,
    trajectory: Trajectory,
    tape: Tape,
}

impl Experiment {
    /// Runs the rollout and returns its vector–Jacobian product with respect to parameters, for losses that another program for
    /// automatic differentiation differentiates. The cost of a product does not depend on the number of parameters.
    ///
    /// ```
    /// # use hydroelastic::contact::Shape;
    /// # use hydroelastic::dynamics::{Body, Mass, Material, Plan, StateGradient, World};
    /// # use hydroelastic::gradient::{Experiment, Parameter};
    /// # use hydroelastic::mesh::shapes;
    /// let ball = Shape::new(shapes::icosphere(0.1, 1)?);
    /// let world = World::new(vec![Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?])?;
    /// let experiment = Experiment::new(&world, &Plan::new(1e-3, 500)?.recording_ends());
    /// let vjp = experiment.vjp(&[Parameter::initial_velocity("ball")])?;
    /// // Half the square of the last position.
    /// let last = vjp.trajectory().last();
    /// let mut by_states = vec![StateGradient::zero(last); 2];
    /// by_states[1].bodies[0].shift = *last.bodies[0].position();
    /// let by_velocity = vjp.pull_back(&by_states)?;
    /// assert_eq!(by_velocity.norm(), 0.0); // the ball stays at the origin
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// - If a parameter does not belong to the world, or the rollout ends early.
    /// - [`GradientError::NoFriction`] as in [`Self::jacobian`].
    pub fn vjp(&self, parameters: &[Parameter]) -> Result<VectorJacobianProduct, GradientError> {
        let (slots, world) = self.world_of(parameters)?;
        let (trajectory, tape) = contained(|| self.taped(&world))?;
        Ok(VectorJacobianProduct {
            experiment: self.clone(),
            world,
            slots,
            trajectory,
            tape,
        })
    }
}

impl VectorJacobianProduct {
    /// Recorded states of the rollout.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// Replaces the cancel flag of the experiment. Copies that are pulled back at the same time can have a flag each.
    #[must_use]
    pub fn with_cancel_flag(self, flag: Arc<AtomicBool>) -> Self {
        let experiment = self.experiment.with_cancel_flag(flag);
        Self { experiment, ..self }
    }

    /// Derivatives of a scalar with respect to the parameters. `by_states` has the derivatives of the scalar with respect to each recorded
    /// state, in the order of [`Self::trajectory`]. Derivatives with respect to kinematic bodies are ignored.
    ///
    /// # Errors
    /// - [`GradientError::CovectorCount`] if there is not one gradient for each body and each joint of each recorded state.
    /// - [`GradientError::BackwardNotFinite`] if one of the given derivatives, or a derivative
    ///   during the sweep, is not finite.
    /// - [`RolloutError::Stopped`](crate::dynamics::RolloutError::Stopped) if the cancel flag is true.
    pub fn pull_back(self, by_states: &[StateGradient]) -> Result<DVector<f64>, GradientError> {
        let by_states = RecordedCovectors::new(by_states, &self.trajectory)?;
        let (world, tape) = (self.world, self.tape);
        let gradient = contained(|| self.experiment.sweep(&*world, tape, by_states, false))?;
        Ok(DVector::from_vec(
            self.slots.gradient(self.experiment.model(), &gradient),
        ))
    }
}

impl fmt::Debug for VectorJacobianProduct {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = formatter.debug_struct("VectorJacobianProduct");
        parts.field("slots", &self.slots).finish_non_exhaustive()
    }
}
