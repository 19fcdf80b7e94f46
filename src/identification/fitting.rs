use super::minimizer::Minimizer;
use super::{
    Checkpoint, Evaluator, Fit, Identification, IdentificationError, Measurement, Termination,
};
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
        self.resume(measurements, self.first_checkpoint(measurements.len()))
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
        let (threads, _) = self.threads(measurements, &checkpoint)?;
        self.minimized(measurements, checkpoint, &threads)
    }

    /// Continues a fit from a checkpoint, as [`Self::resume`]. An evaluator simulates the measurements, for example on other machines.
    ///
    /// # Errors
    /// - As [`Self::resume`].
    /// - Errors of the evaluator.
    pub fn resume_with(
        &self,
        measurements: &[Measurement],
        checkpoint: Checkpoint,
        evaluator: &dyn Evaluator,
    ) -> Result<Fit, IdentificationError> {
        self.threads(measurements, &checkpoint)?;
        self.minimized(measurements, checkpoint, evaluator)
    }

    /// Checkpoint at the initial guess, for a number of measurements.
    #[must_use]
    pub fn first_checkpoint(&self, measurements: usize) -> Checkpoint {
        Checkpoint {
            horizon: 0,
            unknowns: self.unknowns.start(),
            nuisances: vec![DVector::zeros(self.nuisances.len()); measurements],
        }
    }

    fn minimized(
        &self,
        measurements: &[Measurement],
        checkpoint: Checkpoint,
        evaluator: &dyn Evaluator,
    ) -> Result<Fit, IdentificationError> {
        let (mut point, mut iterations) = (checkpoint, 0);
        loop {
            let is_whole = point.horizon == self.horizons.len();
            let mut minimizer = Minimizer::new(self, measurements, evaluator, (point, iterations))?;
            let termination = minimizer.run()?;
            if is_whole || termination == Termination::Stopped {
                return Ok(Fit::new(&self.unknowns, minimizer, termination));
            }
            iterations = minimizer.iterations;
            point = minimizer.point;
            point.horizon += 1;
        }
    }
}
