use super::Experiment;
use crate::dynamics::{Force, Job, World};
use std::sync::Arc;

impl Job {
    /// Returns an experiment on a world, with the plan and the cancel flag of the job.
    #[must_use]
    pub fn experiment<F: Force>(&self, world: impl Into<Arc<World<f64, F>>>) -> Experiment {
        Experiment::new(world, &self.plan).with_cancel_flag(Arc::clone(&self.stop))
    }
}
