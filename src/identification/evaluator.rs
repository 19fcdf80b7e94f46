use super::equations::Equations;
use super::error::check_count;
use super::trial::{Point, Trial};
use super::{Checkpoint, Identification, IdentificationError, Measurement};
use crate::dynamics::RolloutError;
use crate::gradient::GradientError;
use crate::parallel;

/// One result for each measurement, in order. An inner error means that the rollout of the measurement ended early. The outer error means
/// that no result could be computed.
pub type Evaluated<V> = Result<Vec<Result<V, IdentificationError>>, IdentificationError>;

/// Simulator of the measurements of a fit: see [`Identification::resume_with`].
///
/// Measurements are given by their indices. The point has the coordinates of the unknowns and of the nuisances of all measurements, and
/// the index of the horizon. The outer error ends the fit.
pub trait Evaluator {
    /// Costs of measurements at a point, as [`Identification::costs`].
    ///
    /// # Errors
    /// If the costs cannot be computed.
    fn costs(&self, point: &Checkpoint, measurements: &[usize]) -> Evaluated<f64>;

    /// Normal equations of measurements at a point, as [`Identification::equations`].
    ///
    /// # Errors
    /// If the equations cannot be computed.
    fn equations(&self, point: &Checkpoint, measurements: &[usize]) -> Evaluated<Equations>;
}

/// Evaluator on the threads of this machine.
pub(super) struct Threads<'a> {
    pub problem: &'a Identification,
    pub measurements: &'a [Measurement],
}

impl Evaluator for Threads<'_> {
    fn costs(&self, point: &Checkpoint, measurements: &[usize]) -> Evaluated<f64> {
        let duration = self.problem.duration(point);
        self.map(point, measurements, duration, Trial::cost)
    }

    fn equations(&self, point: &Checkpoint, measurements: &[usize]) -> Evaluated<Equations> {
        let duration = self.problem.duration(point);
        self.map(point, measurements, duration, Trial::equations)
    }
}

impl<'a> Threads<'a> {
    /// Values of a function of the beginnings of measurements, with a duration (s).
    ///
    /// # Errors
    /// If the cancel flag is set.
    pub fn map<V: Send>(
        &self,
        point: &Checkpoint,
        measurements: &[usize],
        duration: f64,
        function: impl Fn(&Trial<'a>, Point) -> Result<V, GradientError> + Sync,
    ) -> Evaluated<V> {
        let results = parallel::map(measurements, |&index| {
            let trial = Trial::new(self.problem, &self.measurements[index], duration)?;
            Ok(function(&trial, point.of(index))?)
        });
        let stopped = IdentificationError::from(GradientError::from(RolloutError::Stopped));
        if results
            .iter()
            .any(|result| result.as_ref().err() == Some(&stopped))
        {
            return Err(stopped);
        }
        Ok(results)
    }
}

impl Identification {
    /// Costs of measurements at a checkpoint, with the priors of their nuisances, in units of ½χ². The simulations run on all threads.
    ///
    /// # Errors
    /// - If a measurement does not fit the world or the time steps of the plan.
    /// - If the checkpoint has another number of unknowns, nuisances or measurements, or its horizon index is too large.
    /// - If the cancel flag is set.
    pub fn costs(&self, measurements: &[Measurement], point: &Checkpoint) -> Evaluated<f64> {
        let (threads, all) = self.threads(measurements, point)?;
        threads.costs(point, &all)
    }

    /// Costs of measurements at a checkpoint with their derivatives, for an [`Evaluator`].
    ///
    /// # Errors
    /// As [`Self::costs`].
    pub fn equations(
        &self,
        measurements: &[Measurement],
        point: &Checkpoint,
    ) -> Evaluated<Equations> {
        let (threads, all) = self.threads(measurements, point)?;
        threads.equations(point, &all)
    }

    /// Evaluator on the threads of this machine, and the indices of all measurements.
    ///
    /// # Errors
    /// If a measurement or the checkpoint does not fit the identification.
    pub(super) fn threads<'a>(
        &'a self,
        measurements: &'a [Measurement],
        point: &Checkpoint,
    ) -> Result<(Threads<'a>, Vec<usize>), IdentificationError> {
        self.check(measurements, point)?;
        let threads = Threads {
            problem: self,
            measurements,
        };
        Ok((threads, (0..measurements.len()).collect()))
    }

    /// Checks that measurements and a checkpoint fit the identification.
    fn check(
        &self,
        measurements: &[Measurement],
        checkpoint: &Checkpoint,
    ) -> Result<(), IdentificationError> {
        if measurements.is_empty() {
            return Err(IdentificationError::NoMeasurement);
        }
        let Checkpoint {
            horizon,
            unknowns,
            nuisances,
        } = checkpoint;
        let (found, count) = (*horizon, self.horizons.len());
        if found > count {
            return Err(IdentificationError::HorizonIndex { found, count });
        }
        check_count("unknowns", unknowns.len(), self.unknowns.len())?;
        check_count("measurements", nuisances.len(), measurements.len())?;
        let mut nuisances = nuisances.iter();
        nuisances.try_for_each(|nuisances| {
            check_count("nuisances", nuisances.len(), self.nuisances.len())
        })?;
        let mut measurements = measurements.iter();
        measurements
            .try_for_each(|measurement| Trial::new(self, measurement, f64::INFINITY).map(|_| ()))
    }
}
