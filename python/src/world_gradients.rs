//! Derivatives of rollouts.

use crate::arrays::{Floats, array};
use crate::errors::not_differentiated;
use crate::interrupt::{Shared, run};
use crate::jacobian::{AllStates, DifferenceCheck, TrajectoryJacobian, both};
use crate::parameter::{Parameter, inner};
use crate::plan::Plan;
use crate::trajectory::Trajectory;
use crate::world::World;
use hydroelastic::gradient::{Experiment, GradientError};
use hydroelastic::nalgebra::DMatrix;
use pyo3::prelude::*;
use std::sync::Arc;

impl World {
    /// What is read from an experiment, which Ctrl-C stops.
    fn experiment<O: Send>(
        &self,
        py: Python<'_>,
        plan: &Plan,
        read: impl FnOnce(&Experiment) -> Result<O, GradientError> + Send,
    ) -> PyResult<O> {
        let shared = Shared::default();
        let experiment = Experiment::new(&self.inner, &plan.0).stopped_by(Arc::clone(&shared.stop));
        let found = run(py, &shared, None, || read(&experiment))?;
        found.map_err(|why| not_differentiated(&why))
    }
}

/// A matrix as an array.
fn by_rows<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Floats<'py>> {
    let values = matrix.transpose().as_slice().to_vec();
    array(py, values, &[matrix.nrows(), matrix.ncols()])
}

#[pymethods]
impl World {
    /// The recorded states of a rollout and their derivatives by p numbers of parameters: in forward mode, in one rollout for up
    /// to 96 numbers. With jacobian.poses[-1, i, :3, 3] the last position of body i is differentiated, by each number.
    ///
    /// Derivatives are constants to whoever takes them: there are no second ones.
    ///
    /// Raises
    /// ------
    /// HydroelasticError if a parameter is not one of the world's, or a derivative is not finite; RolloutError, without a
    /// trajectory, if the rollout ends early.
    fn jacobian(
        &self,
        py: Python<'_>,
        plan: &Plan,
        parameters: Vec<Bound<'_, Parameter>>,
    ) -> PyResult<(Trajectory, TrajectoryJacobian)> {
        let by = inner(&parameters);
        let found = self.experiment(py, plan, |it| it.jacobian(&by, &AllStates))?;
        both(py, &found, self.inner.bodies().len())
    }

    /// The end of a rollout to first order in local coordinates, 12 numbers for each of d dynamic bodies as of displacement: A
    /// (12 d, 12 d), by the start, and B (12 d, p), by the parameters. A plan of one step gives that of the step.
    #[pyo3(signature = (plan, parameters=vec![]))]
    fn linearised<'py>(
        &self,
        py: Python<'py>,
        plan: &Plan,
        parameters: Vec<Bound<'py, Parameter>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let by = inner(&parameters);
        let found = self.experiment(py, plan, |it| it.linearised(&by))?;
        Ok((
            by_rows(py, &found.by_state)?,
            by_rows(py, &found.by_parameters)?,
        ))
    }

    /// Compares the derivatives of the recorded states with central differences at seven steps. Takes 1 + 14 p rollouts.
    fn difference_check(
        &self,
        py: Python<'_>,
        plan: &Plan,
        parameters: Vec<Bound<'_, Parameter>>,
    ) -> PyResult<DifferenceCheck> {
        let by = inner(&parameters);
        let found = self.experiment(py, plan, |it| it.difference_check(&by, &AllStates))?;
        Ok(DifferenceCheck(found))
    }
}
