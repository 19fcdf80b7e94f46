use super::coordinates::Coordinates;
use super::error::{check_positive, check_scale};
use super::{Checkpoint, IdentificationError, Iteration, Noise, Nuisance, RobustLoss, Unknown};
use crate::dynamics::{Force, Plan, World};
use crate::gradient::Experiment;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Default of the largest number of iterations for each horizon.
const ITERATIONS: usize = 50;

type ProgressFunction = dyn Fn(&Iteration) -> ControlFlow<()> + Send + Sync;

/// A world with unknown numbers, which measured motions determine: see the [module](super).
#[derive(Clone)]
pub struct Identification {
    /// World of the template, with the plan of the rollouts. The plan's number of steps is not used.
    pub(super) template: Experiment,
    pub(super) unknowns: Coordinates,
    pub(super) nuisances: Coordinates,
    /// Indices of the bodies whose poses are compared.
    pub(super) observed: Vec<usize>,
    pub(super) noise: Noise,
    pub(super) loss: RobustLoss,
    /// Durations (s) of the beginnings of the measurements that are fitted first.
    pub(super) horizons: Vec<f64>,
    pub(super) iterations: usize,
    progress: Option<Arc<ProgressFunction>>,
}

impl Identification {
    /// Creates an identification with a world as the template, without nuisances and with the default noise.
    ///
    /// The values of the unknowns in the world are the initial guess. Rollouts use the time step, the integrator and the tolerances of
    /// the plan, and end at the last state of each measurement. All dynamic bodies are observed.
    ///
    /// # Errors
    /// - If the world has no dynamic body.
    /// - If the world does not have a parameter or a component of an unknown, or the parameter has no effect.
    /// - If the initial guess or the mean of a prior is out of range, or the deviation of a prior is not between 1e-150 and 1e150.
    /// - If two unknowns set the same number.
    pub fn new<F: Force>(
        world: &World<f64, F>,
        plan: &Plan,
        unknowns: &[Unknown],
    ) -> Result<Self, IdentificationError> {
        let template = Experiment::new(world, plan);
        let bodies = world.bodies().iter().enumerate();
        let dynamic = bodies.filter(|(_, body)| body.inertia().is_some());
        let observed: Vec<_> = dynamic.map(|(index, _)| index).collect();
        if observed.is_empty() {
            return Err(IdentificationError::NoDynamicBody(world.bodies().len()));
        }
        Ok(Self {
            unknowns: Coordinates::of_unknowns(unknowns, &template)?,
            nuisances: Coordinates::default(),
            observed,
            noise: Noise::default(),
            loss: RobustLoss::default(),
            horizons: Vec::new(),
            iterations: ITERATIONS,
            progress: None,
            template,
        })
    }

    /// Sets the nuisances of each measurement, such as the errors of its initial state. Replaces earlier nuisances.
    ///
    /// # Errors
    /// - If the world does not have a parameter or a component of a nuisance, or a deviation is not between 1e-150 and 1e150.
    /// - If two nuisances change the same component of a parameter.
    pub fn with_nuisances(self, nuisances: &[Nuisance]) -> Result<Self, IdentificationError> {
        let nuisances = Coordinates::of_nuisances(nuisances, &self.template)?;
        Ok(Self { nuisances, ..self })
    }

    /// Compares the poses of these bodies only.
    ///
    /// # Errors
    /// - If there are no names, or a name is repeated.
    /// - If the world does not have one of the bodies, or the body is not dynamic.
    pub fn with_observed_bodies(self, bodies: &[&str]) -> Result<Self, IdentificationError> {
        let mut observed = Vec::with_capacity(bodies.len());
        for &name in bodies {
            let body = self.template.index_of(name)?;
            if observed.contains(&body) {
                return Err(IdentificationError::ObservedTwice(name.to_owned()));
            }
            if self.template.model().bodies[body].inertia().is_none() {
                return Err(IdentificationError::ObservedNotDynamic(name.to_owned()));
            }
            observed.push(body);
        }
        if observed.is_empty() {
            return Err(IdentificationError::NoObservedBody);
        }
        Ok(Self { observed, ..self })
    }

    /// Sets the noise of measured poses.
    #[must_use]
    pub fn with_noise(self, noise: Noise) -> Self {
        Self { noise, ..self }
    }

    /// Sets the loss of measured poses.
    ///
    /// # Errors
    /// If the threshold or the scale of the loss is not between 1e-150 and 1e150.
    pub fn with_loss(self, loss: RobustLoss) -> Result<Self, IdentificationError> {
        check_scale("the scale of the loss", loss.scale())?;
        Ok(Self { loss, ..self })
    }

    /// Fits the beginnings of the measurements first, with these durations (s) in this order, and the whole measurements at the end.
    /// Each fit begins at the result of the previous fit. Durations usually increase.
    ///
    /// # Errors
    /// If a duration is not positive and finite.
    pub fn with_horizons(self, durations: &[f64]) -> Result<Self, IdentificationError> {
        let mut durations = durations.iter();
        let horizons = durations.clone().copied().collect();
        durations
            .try_for_each(|&duration| check_positive("the duration of a horizon", duration))?;
        Ok(Self { horizons, ..self })
    }

    /// Sets the largest number of iterations for each horizon. The default is 50.
    #[must_use]
    pub fn with_max_iterations(self, iterations: usize) -> Self {
        Self { iterations, ..self }
    }

    /// Sets a function that is called at the beginning of each iteration. [`ControlFlow::Break`] ends the fit with its present result.
    #[must_use]
    pub fn with_progress(
        self,
        progress: impl Fn(&Iteration) -> ControlFlow<()> + Send + Sync + 'static,
    ) -> Self {
        let progress: Option<Arc<ProgressFunction>> = Some(Arc::new(progress));
        Self { progress, ..self }
    }

    /// Cancels the fit once the flag is true. The fit returns the error
    /// [`RolloutError::Stopped`](crate::dynamics::RolloutError::Stopped). To keep a result, save the last checkpoint of the progress
    /// function.
    #[must_use]
    pub fn with_cancel_flag(self, flag: Arc<AtomicBool>) -> Self {
        let template = self.template.with_cancel_flag(flag);
        Self { template, ..self }
    }

    /// Duration (s) of the horizon of a checkpoint, or infinity for whole measurements.
    pub(super) fn duration(&self, point: &Checkpoint) -> f64 {
        let horizon = self.horizons.get(point.horizon).copied();
        horizon.unwrap_or(f64::INFINITY)
    }

    /// Calls the progress function, if there is one.
    pub(super) fn report_progress(&self, iteration: impl FnOnce() -> Iteration) -> ControlFlow<()> {
        match &self.progress {
            None => ControlFlow::Continue(()),
            Some(report) => report(&iteration()),
        }
    }

    /// Returns the identification with known values of the unknowns. Only the nuisances remain to be fitted.
    pub(super) fn with_known_unknowns(&self, values: &[f64]) -> Result<Self, IdentificationError> {
        let coordinates = self.unknowns.of_values(values)?;
        let changes = self.unknowns.changes(&coordinates);
        let template = self
            .template
            .perturbed(&self.unknowns.parameters, &changes)?;
        Ok(Self {
            template,
            unknowns: Coordinates::default(),
            horizons: Vec::new(),
            progress: None,
            ..self.clone()
        })
    }
}

impl fmt::Debug for Identification {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Identification")
            .field("unknowns", &self.unknowns)
            .field("nuisances", &self.nuisances)
            .finish_non_exhaustive()
    }
}
