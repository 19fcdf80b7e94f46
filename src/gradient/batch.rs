use super::{Experiment, GradientError, Outcome, OutcomeJacobian, Parameter};
use crate::dynamics::{Batch, Force, RolloutError, StateCovector, Trajectory, World};
use crate::threads::contained;
use nalgebra::DVector;
use std::sync::Arc;

/// A batch of a world after many changes of its parameters: each sample has a number for each number
/// of the parameters, as in [`World::changed`].
///
/// Errors belong to samples: one that makes no world, or whose rollout ends early, leaves the others
/// as they are. Of a rollout that ends early the error tells why; its states are to be had by
/// [`Experiment::trajectory`] on the same [`World::changed`].
impl Batch {
    /// For each sample the outcome.
    ///
    /// # Errors
    /// Each sample's own: as of [`World::changed`] and [`Experiment::value`], and
    /// [`RolloutError::Stopped`] where the batch was ended before.
    pub fn values_after<F: Force>(
        &self,
        world: &World<f64, F>,
        parameters: &[Parameter],
        samples: &[impl AsRef<[f64]> + Sync],
        outcome: &impl Outcome,
    ) -> Vec<Result<Vec<f64>, GradientError>> {
        self.after(world, parameters, samples, |experiment| {
            experiment.value(outcome)
        })
    }

    /// For each sample the outcome and its derivatives by the parameters, as of
    /// [`Experiment::jacobian`].
    ///
    /// # Errors
    /// Each sample's own: as of [`World::changed`] and [`Experiment::jacobian`], and
    /// [`RolloutError::Stopped`] where the batch was ended before.
    pub fn jacobians_after<F: Force>(
        &self,
        world: &World<f64, F>,
        parameters: &[Parameter],
        samples: &[impl AsRef<[f64]> + Sync],
        outcome: &impl Outcome,
    ) -> Vec<Result<OutcomeJacobian, GradientError>> {
        self.after(world, parameters, samples, |experiment| {
            experiment.jacobian(parameters, outcome)
        })
    }

    /// For each of a list of worlds the outcome of its rollout from its initial state, and the derivatives by the parameters,
    /// as of [`Experiment::jacobian`]: for many starts.
    ///
    /// # Errors
    /// Each world's own: as of [`Experiment::jacobian`], and [`RolloutError::Stopped`] where the batch was ended before.
    pub fn jacobians_of_worlds<F: Force>(
        &self,
        worlds: &[World<f64, F>],
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Vec<Result<OutcomeJacobian, GradientError>> {
        let job = |world: &World<f64, F>| {
            contained(|| self.experiment(world.clone()).jacobian(parameters, outcome))
        };
        self.results(worlds, job, |_| RolloutError::Stopped.into())
    }

    /// For each sample a loss and its gradient, as of [`Experiment::gradient`].
    ///
    /// # Errors
    /// Each sample's own: as of [`World::changed`] and [`Experiment::gradient`], and
    /// [`RolloutError::Stopped`] where the batch was ended before.
    pub fn gradients_after<F: Force>(
        &self,
        world: &World<f64, F>,
        parameters: &[Parameter],
        samples: &[impl AsRef<[f64]> + Sync],
        loss: &impl Outcome,
    ) -> Vec<Result<(f64, DVector<f64>), GradientError>> {
        self.after(world, parameters, samples, |experiment| {
            experiment.gradient(parameters, loss)
        })
    }

    /// For each of a list of worlds the derivatives of a number of its rollout by the parameters, as of
    /// [`Experiment::pullback`]: a function gets the place of the world and its trajectory, and tells the derivatives by the
    /// states.
    ///
    /// # Errors
    /// Each world's own: as of [`Experiment::pullback`], and [`RolloutError::Stopped`] where the batch was ended before.
    pub fn pullbacks_of_worlds<F: Force>(
        &self,
        worlds: &[World<f64, F>],
        parameters: &[Parameter],
        by_states: impl Fn(usize, &Trajectory) -> Vec<Vec<StateCovector>> + Sync,
    ) -> Vec<Result<DVector<f64>, GradientError>> {
        let places: Vec<_> = worlds.iter().enumerate().collect();
        let job = |&(place, world): &(usize, &World<f64, F>)| {
            let experiment = self.experiment(world.clone());
            contained(|| experiment.pullback(parameters, |it| by_states(place, it)))
        };
        self.results(&places, job, |_| RolloutError::Stopped.into())
    }

    /// The experiment on a world, which ends with the batch.
    fn experiment<F: Force>(&self, world: World<f64, F>) -> Experiment {
        Experiment::new(world, &self.plan).stopped_by(Arc::clone(&self.stop))
    }

    /// What is read from the experiment on the world after each sample's changes.
    fn after<F: Force, O: Send>(
        &self,
        world: &World<f64, F>,
        parameters: &[Parameter],
        samples: &[impl AsRef<[f64]> + Sync],
        read: impl Fn(&Experiment) -> Result<O, GradientError> + Sync,
    ) -> Vec<Result<O, GradientError>> {
        let job = |sample: &_| {
            contained(|| {
                let world = world.changed(parameters, AsRef::as_ref(sample))?;
                read(&self.experiment(world))
            })
        };
        self.results(samples, job, |_| RolloutError::Stopped.into())
    }
}
