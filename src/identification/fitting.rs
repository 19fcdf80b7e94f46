use super::error::check_count;
use super::minimizer::Minimizer;
use super::{Checkpoint, Fit, Identification, IdentificationError, Measurement, Termination};
use nalgebra::DVector;

impl Identification {
    /// Fits the unknowns to measurements.
    ///
    /// At the start of each horizon, measurements whose rollouts end early are omitted. [`Fit::measurements`] reports the omissions of
    /// the last horizon.
    ///
    /// # Errors
    /// - If there is no measurement, or a measurement does not fit the world or the time steps of the plan.
    /// - [`IdentificationError::NoRollout`] if no measurement can be simulated.
    /// - [`RolloutError::Stopped`](crate::dynamics::RolloutError::Stopped) if the cancel flag is set.
    pub fn fit(&self, measurements: &[Measurement]) -> Result<Fit, IdentificationError> {
        let checkpoint = Checkpoint {
            horizon: 0,
            unknowns: self.unknowns.start(),
            nuisances: vec![DVector::zeros(self.nuisances.len()); measurements.len()],
        };
        self.resume(measurements, checkpoint)
    }

    /// Continues a fit from a checkpoint with the same measurements. Iterations are counted from zero.
    ///
    /// # Errors
    /// - As [`Self::fit`].
    /// - If the checkpoint has another number of unknowns, nuisances or measurements, or its horizon index is larger than the number of
    ///   horizons.
    pub fn resume(
        &self,
        measurements: &[Measurement],
        checkpoint: Checkpoint,
    ) -> Result<Fit, IdentificationError> {
        self.check(measurements, &checkpoint)?;
        let (mut point, mut iterations) = (checkpoint, 0);
        loop {
            let horizon = self.horizons.get(point.horizon).copied();
            let duration = horizon.unwrap_or(f64::INFINITY);
            let mut minimizer = Minimizer::new(self, measurements, duration, (point, iterations))?;
            let termination = minimizer.run()?;
            if horizon.is_none() || termination == Termination::Stopped {
                return Ok(Fit::new(&self.unknowns, minimizer, termination));
            }
            iterations = minimizer.iterations;
            point = minimizer.point;
            point.horizon += 1;
        }
    }

    /// Checks that a checkpoint fits the identification and its measurements.
    pub(super) fn check(
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
        })
    }
}
