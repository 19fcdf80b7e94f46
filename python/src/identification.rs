//! Identification of a world from measured motions.

use crate::arrays::{
    Floats, Numbers, Whole, array, check_finite, copied, count, list, named_real, numbers,
    optional_real, row, whole, wrong_shape,
};
use crate::errors::{gradient_error, value_error};
use crate::interrupt::{Shared, run};
use crate::parameter::Parameter;
use crate::plan::Plan;
use crate::trajectory::Trajectory;
use crate::world::World;
use crate::world_gradients::by_rows;
use hydroelastic::dynamics::Trajectory as States;
use hydroelastic::identification::{
    self, IdentificationError, Iteration, Measurement, Noise, Nuisance, RobustLoss, StartingState,
    Termination,
};
use hydroelastic::nalgebra::DVector;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

/// Unknown parameter of a world, which all measurements share. The value in the world is the initial guess.
///
/// A fit changes the coordinate of an unknown: the value, its logarithm, or the logit of the value between bounds. Covariances refer to
/// coordinates. The value of an orientation is a component of a rotation vector (rad) from the orientation in the world.
///
/// Parameters
/// ----------
/// parameter : Parameter
///     Parameter.
/// component : int
///     Component of the parameter, counted from 0.
/// logarithmic : bool
///     True if the coordinate is the logarithm of the value. The value then stays positive.
/// bounds : (2,) array_like, optional
///     Lower and upper bound of the value, both excluded.
/// prior : (2,) array_like, optional
///     Expected value, and the standard deviation of the coordinate.
/// tied_to : list of Parameter
///     Other parameters, whose first component has the same value.
/// name : str, optional
///     Name. The default names the parameter.
///
/// Raises
/// ------
/// HydroelasticError
///     If the unknown has bounds and is logarithmic.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Unknown(identification::Unknown);

#[pymethods]
impl Unknown {
    #[new]
    #[pyo3(signature = (parameter, *, component=0, logarithmic=false, bounds=None, prior=None, tied_to=vec![], name=None))]
    fn new(
        parameter: &Parameter,
        #[pyo3(from_py_with = whole)] component: Whole,
        logarithmic: bool,
        bounds: Option<Bound<'_, PyAny>>,
        prior: Option<Bound<'_, PyAny>>,
        tied_to: Vec<Bound<'_, Parameter>>,
        name: Option<String>,
    ) -> PyResult<Self> {
        let component = count(component, "component")?;
        let mut unknown = identification::Unknown::new(parameter.0.clone()).component(component);
        for parameter in tied_to {
            unknown = unknown.tied_to(parameter.get().0.clone());
        }
        if let Some(bounds) = bounds {
            if logarithmic {
                return Err(value_error(
                    "an unknown is logarithmic or has bounds, not both",
                ));
            }
            let [lower, upper] = row(&bounds, "bounds")?;
            unknown = unknown.bounded(lower, upper);
        }
        if logarithmic {
            unknown = unknown.logarithmic();
        }
        if let Some(prior) = prior {
            let [value, deviation] = row(&prior, "prior")?;
            unknown = unknown.with_prior(value, deviation);
        }
        Ok(Self(match name {
            Some(name) => unknown.named(name),
            None => unknown,
        }))
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    fn __repr__(&self) -> String {
        format!("Unknown({:?})", self.0.name())
    }
}

/// Estimation of unknown parameters of a world from measured motions.
///
/// The fit minimizes the deviations of simulated from measured poses, with exact derivatives. A measurement is a Trajectory of the
/// world. Its rollout begins at the first state, with its velocities. Later states are compared by the poses of the observed bodies.
/// Their times after the first state are multiples of the time step of the plan.
///
/// Parameters
/// ----------
/// world : World
///     World with the initial guess of each unknown.
/// plan : Plan
///     Time step, integrator and tolerances. The number of steps is not used.
/// unknowns : list of Unknown
///     Unknowns that all measurements share.
/// nuisances : sequence of (Parameter, float)
///     Parameters with an error of its own in each measurement, such as initial velocities, and the standard deviation of the error of each
///     component.
/// noise : (2,) array_like, optional
///     Standard deviations of each component of measured positions (m) and rotations (rad). If the world is only approximate, use the errors
///     that are expected of it.
/// huber, cauchy : float, optional
///     Threshold of Huber's loss, or scale of Cauchy's loss, in units of the noise. The default is least squares.
/// horizons : list of float, optional
///     Durations (s) of the beginnings of the measurements that are fitted first.
/// max_iterations : int
///     Largest number of iterations for each horizon.
/// bodies : list of str, optional
///     Names of the observed bodies. The default is all dynamic bodies.
///
/// Raises
/// ------
/// HydroelasticError
///     If the world does not have a parameter or a body, an initial guess is out of range, two unknowns set the same component, or a deviation,
///     threshold or duration is not positive.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Identification(identification::Identification);

/// Loss for the arguments `huber` and `cauchy`.
fn loss(huber: Option<f64>, cauchy: Option<f64>) -> PyResult<RobustLoss> {
    match (huber, cauchy) {
        (None, None) => Ok(RobustLoss::Squared),
        (Some(threshold), None) => Ok(RobustLoss::Huber(threshold)),
        (None, Some(scale)) => Ok(RobustLoss::Cauchy(scale)),
        (Some(_), Some(_)) => Err(value_error("huber and cauchy exclude each other")),
    }
}

#[pymethods]
impl Identification {
    #[new]
    #[pyo3(signature = (world, plan, unknowns, *, nuisances=vec![], noise=None, huber=None, cauchy=None, horizons=None, max_iterations=50,
        bodies=None))]
    fn new(
        world: &World,
        plan: &Plan,
        unknowns: Vec<Bound<'_, Unknown>>,
        nuisances: Vec<(Bound<'_, Parameter>, Bound<'_, PyAny>)>,
        noise: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = optional_real)] huber: Option<f64>,
        #[pyo3(from_py_with = optional_real)] cauchy: Option<f64>,
        horizons: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = whole)] max_iterations: Whole,
        bodies: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let unknowns: Vec<_> = unknowns
            .iter()
            .map(|unknown| unknown.get().0.clone())
            .collect();
        let nuisance = |(parameter, deviation): &(Bound<'_, Parameter>, Bound<'_, PyAny>)| {
            let deviation = named_real(deviation, "the deviation of a nuisance")?;
            Ok(Nuisance::new(parameter.get().0.clone(), deviation))
        };
        let nuisances = nuisances
            .iter()
            .map(nuisance)
            .collect::<PyResult<Vec<_>>>()?;
        let horizons = horizons.map_or(Ok(vec![]), |horizons| list(&horizons, "horizons"))?;
        let loss = loss(huber, cauchy)?;
        let noise = noise.map(|noise| row(&noise, "noise")).transpose()?;
        let create = || {
            let noise = noise.map_or(Ok(Noise::default()), |[position, rotation]| {
                Noise::new(position, rotation)
            })?;
            let created = identification::Identification::new(&world.inner, &plan.0, &unknowns)?
                .with_nuisances(&nuisances)?
                .with_noise(noise)
                .with_loss(loss)?
                .with_horizons(&horizons)?;
            let Some(bodies) = &bodies else {
                return Ok(created);
            };
            let bodies: Vec<&str> = bodies.iter().map(String::as_str).collect();
            created.with_observed_bodies(&bodies)
        };
        let created = create().map_err(|why| error(&why))?;
        let max_iterations = count(max_iterations, "max_iterations")?;
        Ok(Self(created.with_max_iterations(max_iterations)))
    }

    /// Fits the unknowns to measurements. Rollouts run on all threads. Ctrl-C ends the fit.
    ///
    /// Measurements whose rollouts end early at the beginning are omitted, and listed in Fit.errors.
    ///
    /// Parameters
    /// ----------
    /// trajectories : list of Trajectory
    ///     Measurements.
    /// start : Checkpoint, optional
    ///     Checkpoint of an earlier fit to the same measurements, from which this fit continues. The default is the initial guess.
    /// progress : function of iterations, optional
    ///     Function of (index, cost, values, checkpoint), called at the beginning of each iteration. If it returns True, the fit ends with
    ///     its present result.
    ///
    /// Returns
    /// -------
    /// Fit
    ///     Estimates and their uncertainty.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a trajectory does not fit the world or the time step, or no measurement can be simulated.
    #[pyo3(signature = (trajectories, *, start=None, progress=None))]
    fn fit(
        &self,
        py: Python<'_>,
        trajectories: Vec<Bound<'_, Trajectory>>,
        start: Option<&Checkpoint>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Fit> {
        let trajectories = trajectories
            .iter()
            .map(|trajectory| &trajectory.get().inner);
        let measurements: Vec<_> = trajectories.enumerate().map(measurement).collect();
        let shared = Shared::default();
        let raised = Arc::new(Mutex::new(None));
        let mut inner = self.0.clone().with_cancel_flag(Arc::clone(&shared.stop));
        if let Some(progress) = progress {
            let raised = Arc::clone(&raised);
            inner = inner.with_progress(move |iteration| told(&progress, iteration, &raised));
        }
        let checkpoint = start.map(|start| start.0.clone());
        let fit = run(py, &shared, None, || match checkpoint {
            None => inner.fit(&measurements),
            Some(checkpoint) => inner.resume(&measurements, checkpoint),
        })?;
        let raised = raised.lock().map_or(None, |mut raised| raised.take());
        match raised {
            Some(exception) => Err(exception),
            None => fit.map(Fit).map_err(|why| error(&why)),
        }
    }

    /// Simulates a measurement with values of the unknowns, and compares all of its states. Use this method for measurements that were not
    /// fitted.
    ///
    /// Parameters
    /// ----------
    /// values : (u,) array_like
    ///     Values of the unknowns.
    /// trajectory : Trajectory
    ///     Measurement.
    /// fitted_duration : float, optional
    ///     Duration (s) at the beginning to which the nuisances are fitted. The default starts at the first measured state as it is.
    ///
    /// Returns
    /// -------
    /// trajectory : Trajectory
    ///     Simulated states at the measured times.
    /// position_errors : (k, b) ndarray of float64
    ///     Distances (m) of the simulated from the measured position of each observed body, in each state.
    /// rotation_errors : (k, b) ndarray of float64
    ///     Angles (rad) of the rotations from the measured to the simulated orientation.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a value is out of range, the trajectory does not fit the world or the time step, or the rollout ends early.
    #[pyo3(signature = (values, trajectory, *, fitted_duration=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        values: &Bound<'py, PyAny>,
        trajectory: &Trajectory,
        #[pyo3(from_py_with = optional_real)] fitted_duration: Option<f64>,
    ) -> PyResult<(Trajectory, Floats<'py>, Floats<'py>)> {
        let values = list(values, "values")?;
        let start = fitted_duration.map_or(StartingState::Measured, StartingState::Fitted);
        let measurement = measurement((0, &trajectory.inner));
        let shared = Shared::default();
        let inner = self.0.clone().with_cancel_flag(Arc::clone(&shared.stop));
        let prediction = run(py, &shared, None, || {
            inner.predict(&values, &measurement, start)
        })?;
        let prediction = prediction.map_err(|why| error(&why))?;
        let by_state = |errors: &[Vec<f64>]| {
            let shape = [errors.len(), errors.first().map_or(0, Vec::len)];
            array(py, errors.concat(), &shape)
        };
        Ok((
            prediction.trajectory.clone().into(),
            by_state(&prediction.position_errors)?,
            by_state(&prediction.rotation_errors)?,
        ))
    }
}

fn measurement((index, trajectory): (usize, &States)) -> Measurement {
    Measurement::new(format!("trajectory {index}"), trajectory.clone())
}

/// Calls the progress function. Keeps an exception, and ends the fit after an exception or the result True.
fn told(
    progress: &Py<PyAny>,
    iteration: &Iteration,
    raised: &Mutex<Option<PyErr>>,
) -> ControlFlow<()> {
    let result = Python::attach(|py| {
        let values = array(py, iteration.values.clone(), &[iteration.values.len()])?;
        let checkpoint = Checkpoint(iteration.checkpoint.clone());
        let result = progress.call1(py, (iteration.index, iteration.cost, values, checkpoint))?;
        result.bind(py).is_truthy()
    });
    match result {
        Ok(false) => ControlFlow::Continue(()),
        Ok(true) => ControlFlow::Break(()),
        Err(exception) => {
            if let Ok(mut raised) = raised.lock() {
                *raised = Some(exception);
            }
            ControlFlow::Break(())
        }
    }
}

fn error(why: &IdentificationError) -> PyErr {
    match why {
        IdentificationError::Gradient(why) => gradient_error(why),
        why => value_error(why),
    }
}

/// Checkpoint from which a fit can continue: coordinates of the u unknowns, and of the n nuisances of each of m measurements. A checkpoint
/// can be pickled.
///
/// Parameters
/// ----------
/// horizon : int
///     Index of the horizon that is fitted. If it is the number of horizons, whole measurements are fitted.
/// unknowns : (u,) array_like
///     Coordinates of the unknowns.
/// nuisances : (m, n) array_like
///     Coordinates of the nuisances of each measurement.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is not finite, or an array has an unexpected shape.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Checkpoint(identification::Checkpoint);

#[pymethods]
impl Checkpoint {
    #[new]
    fn new(
        #[pyo3(from_py_with = whole)] horizon: Whole,
        unknowns: &Bound<'_, PyAny>,
        nuisances: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let unknowns = list(unknowns, "unknowns")?;
        check_finite(&unknowns, "unknowns")?;
        let Numbers { values, shape } = numbers(nuisances, "nuisances")?;
        check_finite(&values, "nuisances")?;
        let [measurements, width] = shape[..] else {
            return Err(wrong_shape("nuisances", "(m, n)", &shape));
        };
        let row = |row: usize| DVector::from_column_slice(&values[row * width..(row + 1) * width]);
        Ok(Self(identification::Checkpoint {
            horizon: count(horizon, "horizon")?,
            unknowns: unknowns.into(),
            nuisances: (0..measurements).map(row).collect(),
        }))
    }

    /// Index of the horizon that is fitted.
    #[getter]
    fn horizon(&self) -> usize {
        self.0.horizon
    }

    /// Coordinates of the unknowns, (u,) float64.
    #[getter]
    fn unknowns<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let unknowns = &self.0.unknowns;
        copied(py, unknowns.as_slice(), &[unknowns.len()])
    }

    /// Coordinates of the nuisances of each measurement, (m, n) float64.
    #[getter]
    fn nuisances<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let rows = &self.0.nuisances;
        let values = rows.iter().flat_map(|row| row.iter().copied()).collect();
        array(
            py,
            values,
            &[rows.len(), rows.first().map_or(0, DVector::len)],
        )
    }

    fn __repr__(&self) -> String {
        let (unknowns, measurements) = (self.0.unknowns.len(), self.0.nuisances.len());
        format!("Checkpoint({unknowns} unknowns, {measurements} measurements)")
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(usize, Floats<'py>, Floats<'py>)> {
        Ok((self.horizon(), self.unknowns(py)?, self.nuisances(py)?))
    }
}

/// Result of Identification.fit, with u unknowns and m measurements.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Fit(identification::Fit);

#[pymethods]
impl Fit {
    /// Names of the unknowns.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.0
            .estimates
            .iter()
            .map(|estimate| estimate.name.clone())
            .collect()
    }

    /// Estimates, (u,) float64.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let values = self.0.values();
        let shape = [values.len()];
        array(py, values, &shape)
    }

    /// 95 % intervals of the estimates, for a right world and right deviations of the noise, (u, 2) float64.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let ends = self
            .0
            .estimates
            .iter()
            .flat_map(|estimate| estimate.interval);
        array(py, ends.collect(), &[self.0.estimates.len(), 2])
    }

    /// 95 % intervals of the estimates from the spread between measurements, (u, 2) float64. They remain valid if the world is only
    /// approximate, and need many more measurements than unknowns.
    #[getter]
    fn sandwich_intervals<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let estimates = self.0.estimates.iter();
        let ends = estimates.flat_map(|estimate| estimate.sandwich_interval);
        array(py, ends.collect(), &[self.0.estimates.len(), 2])
    }

    /// Covariance of the coordinates of the unknowns, (u, u) float64. Infinite if a direction is not determined.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_rows(py, &self.0.covariance)
    }

    /// Covariance of the coordinates from the spread between measurements (sandwich estimator), (u, u) float64.
    #[getter]
    fn sandwich_covariance<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_rows(py, &self.0.sandwich_covariance)
    }

    /// Unit vectors along the principal directions of the information about the coordinates, the least known first, (u, u) float64. Each row
    /// is a direction.
    #[getter]
    fn directions<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let directions = self.0.directions.iter();
        let weights =
            directions.flat_map(|direction| direction.weights.iter().map(|(_, weight)| *weight));
        array(py, weights.collect(), &[self.0.directions.len(); 2])
    }

    /// Standard deviation of the coordinates along each direction, (u,) float64. Infinite if the measurements do not determine it. For
    /// logarithms, 1 is an uncertainty by a factor of e.
    #[getter]
    fn direction_deviations<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let directions = self.0.directions.iter();
        let deviations = directions.map(|direction| direction.standard_deviation);
        array(py, deviations.collect(), &[self.0.directions.len()])
    }

    /// Cost, in units of ½χ².
    #[getter]
    fn cost(&self) -> f64 {
        self.0.cost
    }

    /// Cost of each measurement, (m,) float64. Zero if it was omitted.
    #[getter]
    fn costs<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let costs = self
            .0
            .measurements
            .iter()
            .map(|measurement| measurement.cost);
        array(py, costs.collect(), &[self.0.measurements.len()])
    }

    /// Reason why each measurement was omitted, or None.
    #[getter]
    fn errors(&self) -> Vec<Option<String>> {
        let measurements = self.0.measurements.iter();
        measurements
            .map(|measurement| measurement.error.as_ref().map(ToString::to_string))
            .collect()
    }

    /// Checkpoint from which another fit can continue.
    #[getter]
    fn checkpoint(&self) -> Checkpoint {
        Checkpoint(self.0.checkpoint.clone())
    }

    /// Number of iterations, over all horizons.
    #[getter]
    fn iterations(&self) -> usize {
        self.0.iterations
    }

    /// Reason why the fit ended: "converged", "stalled", "iteration limit" or "stopped".
    #[getter]
    fn termination(&self) -> &'static str {
        match self.0.termination {
            Termination::Converged => "converged",
            Termination::Stalled => "stalled",
            Termination::IterationLimit => "iteration limit",
            _ => "stopped",
        }
    }

    fn __repr__(&self) -> String {
        let estimates: Vec<String> = self.0.estimates.iter().map(ToString::to_string).collect();
        format!("Fit({})", estimates.join(", "))
    }
}
