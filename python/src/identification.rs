//! Identification of a world from measured motions.

use crate::arrays::{Whole, array, count, list, named_real, optional_real, parts, row, whole};
use crate::errors::{gradient_error, value_error};
use crate::evaluator::{PythonEvaluator, Raised, store};
use crate::fit::{Checkpoint, Fit, Prediction};
use crate::interrupt::{Shared, run};
use crate::lists::{list_of, names};
use crate::parameter::Parameter;
use crate::pickle::{Reduced, loaded, reduced, to_bytes};
use crate::plan::Plan;
use crate::trajectory::Trajectory;
use crate::world::World;
use hydroelastic::dynamics::Trajectory as States;
use hydroelastic::identification::{
    self, Evaluated, IdentificationError, Iteration, Measurement, Noise, Nuisance, RobustLoss,
    StartingState,
};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
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
        #[pyo3(from_py_with = list_of)] tied_to: Vec<Bound<'_, Parameter>>,
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

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_unknown", &self.0)
    }
}

/// Restores an unknown from a pickle.
#[pyfunction]
pub fn _load_unknown(saved: &[u8]) -> PyResult<Unknown> {
    Ok(Unknown(loaded(saved)?))
}

/// Estimation of unknown parameters of a world from measured motions.
///
/// The fit minimizes the deviations of simulated from measured poses, with exact derivatives. A measurement is a Trajectory of the
/// world. Its rollout begins at the first state, with its velocities. Later states are compared by the poses of the observed bodies.
/// Their times after the first state are multiples of the time step of the plan. An identification can be pickled.
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
///     Names of the observed bodies: at least one, each once, and only dynamic bodies. The default is all dynamic bodies.
///
/// Raises
/// ------
/// HydroelasticError
///     If the world does not have a parameter or a body, an initial guess is out of range, two unknowns set the same component, a duration
///     is not positive, a deviation or threshold is not between 1e-150 and 1e150, or the observed bodies are invalid.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Identification {
    inner: identification::Identification,
    // The arguments of the constructor, for pickles.
    world: Py<World>,
    plan: Py<Plan>,
    unknowns: Vec<Py<Unknown>>,
    settings: Settings,
}

/// Optional arguments of an identification.
struct Settings {
    nuisances: Vec<(Py<Parameter>, f64)>,
    noise: Option<[f64; 2]>,
    huber: Option<f64>,
    cauchy: Option<f64>,
    horizons: Vec<f64>,
    max_iterations: usize,
    bodies: Option<Vec<String>>,
}

impl Settings {
    fn applied_to(
        &self,
        created: identification::Identification,
    ) -> Result<identification::Identification, IdentificationError> {
        let nuisances = self.nuisances.iter();
        let nuisances = nuisances
            .map(|(parameter, deviation)| Nuisance::new(parameter.get().0.clone(), *deviation));
        let noise = self
            .noise
            .map(|[position, rotation]| Noise::new(position, rotation));
        let loss = match (self.huber, self.cauchy) {
            (Some(threshold), _) => RobustLoss::Huber(threshold),
            (None, Some(scale)) => RobustLoss::Cauchy(scale),
            (None, None) => RobustLoss::Squared,
        };
        let created = created
            .with_nuisances(&nuisances.collect::<Vec<_>>())?
            .with_noise(noise.transpose()?.unwrap_or_default())
            .with_loss(loss)?
            .with_horizons(&self.horizons)?
            .with_max_iterations(self.max_iterations);
        let Some(bodies) = &self.bodies else {
            return Ok(created);
        };
        let bodies: Vec<&str> = bodies.iter().map(String::as_str).collect();
        created.with_observed_bodies(&bodies)
    }

    /// Keyword arguments of the constructor.
    fn keywords<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let nuisances = self.nuisances.iter();
        let nuisances = nuisances.map(|(parameter, deviation)| (parameter.bind(py), *deviation));
        let keywords = PyDict::new(py);
        keywords.set_item("nuisances", nuisances.collect::<Vec<_>>())?;
        keywords.set_item("noise", self.noise)?;
        keywords.set_item("huber", self.huber)?;
        keywords.set_item("cauchy", self.cauchy)?;
        keywords.set_item("horizons", &self.horizons)?;
        keywords.set_item("max_iterations", self.max_iterations)?;
        keywords.set_item("bodies", &self.bodies)?;
        Ok(keywords)
    }
}

#[pymethods]
impl Identification {
    #[new]
    #[pyo3(signature = (world, plan, unknowns, *, nuisances=vec![], noise=None, huber=None, cauchy=None, horizons=None, max_iterations=50,
        bodies=None))]
    fn new(
        world: &Bound<'_, World>,
        plan: &Bound<'_, Plan>,
        #[pyo3(from_py_with = list_of)] unknowns: Vec<Bound<'_, Unknown>>,
        nuisances: Vec<Bound<'_, PyAny>>,
        noise: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = optional_real)] huber: Option<f64>,
        #[pyo3(from_py_with = optional_real)] cauchy: Option<f64>,
        horizons: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = whole)] max_iterations: Whole,
        bodies: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        if huber.is_some() && cauchy.is_some() {
            return Err(value_error("huber and cauchy exclude each other"));
        }
        let settings = Settings {
            nuisances: nuisances.iter().map(nuisance).collect::<PyResult<_>>()?,
            noise: noise.map(|noise| row(&noise, "noise")).transpose()?,
            huber,
            cauchy,
            horizons: horizons.map_or(Ok(vec![]), |horizons| list(&horizons, "horizons"))?,
            max_iterations: count(max_iterations, "max_iterations")?,
            bodies: bodies.map(|bodies| names(&bodies)).transpose()?,
        };
        let inner: Vec<_> = unknowns
            .iter()
            .map(|unknown| unknown.get().0.clone())
            .collect();
        let inner = identification::Identification::new(&world.get().inner, &plan.get().0, &inner);
        let inner = inner.and_then(|inner| settings.applied_to(inner));
        Ok(Self {
            inner: inner.map_err(|why| error(&why))?,
            world: world.clone().unbind(),
            plan: plan.clone().unbind(),
            unknowns: unknowns.into_iter().map(Bound::unbind).collect(),
            settings,
        })
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
        #[pyo3(from_py_with = list_of)] trajectories: Vec<Bound<'_, Trajectory>>,
        start: Option<&Checkpoint>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Fit> {
        let Job {
            inner,
            measurements,
            checkpoint,
            raised,
        } = self.job(&trajectories, start, progress);
        let fit = cancelable(py, inner, |inner| inner.resume(&measurements, checkpoint))?;
        ended(fit, &raised)
    }

    /// Fits the unknowns as fit does. The methods costs and equations of the evaluator receive a checkpoint and a list of indices of
    /// measurements, and return a result of _costs or _equations for each index. They run on the calling thread.
    ///
    /// Parameters
    /// ----------
    /// evaluator : object
    /// progress : function of iterations, optional
    #[pyo3(signature = (trajectories, evaluator, start=None, progress=None))]
    fn _fit_with(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = list_of)] trajectories: Vec<Bound<'_, Trajectory>>,
        evaluator: Py<PyAny>,
        start: Option<&Checkpoint>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Fit> {
        let Job {
            inner,
            measurements,
            checkpoint,
            raised,
        } = self.job(&trajectories, start, progress);
        let evaluator = PythonEvaluator {
            evaluator,
            raised: Arc::clone(&raised),
        };
        let fit = py.detach(|| inner.resume_with(&measurements, checkpoint, &evaluator));
        ended(fit, &raised)
    }

    /// Costs of measurements at a checkpoint: a number or the text of an error for each.
    ///
    /// Returns
    /// -------
    /// list of float or str
    fn _costs<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] trajectories: Vec<Bound<'py, Trajectory>>,
        checkpoint: &Checkpoint,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let costs = |inner: &identification::Identification, measurements: &[Measurement]| {
            inner.costs(measurements, &checkpoint.0)
        };
        self.evaluated(py, &trajectories, costs, |cost| match cost {
            Ok(cost) => cost.into_bound_py_any(py),
            Err(why) => why.to_string().into_bound_py_any(py),
        })
    }

    /// Normal equations of measurements at a checkpoint: bytes or the text of an error for each.
    ///
    /// Returns
    /// -------
    /// list of bytes or str
    fn _equations<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] trajectories: Vec<Bound<'py, Trajectory>>,
        checkpoint: &Checkpoint,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let equations = |inner: &identification::Identification, measurements: &[Measurement]| {
            inner.equations(measurements, &checkpoint.0)
        };
        self.evaluated(py, &trajectories, equations, |equations| match equations {
            Ok(equations) => Ok(to_bytes(py, &equations)?.into_any()),
            Err(why) => why.to_string().into_bound_py_any(py),
        })
    }

    /// Simulates the measurements of a fit with the unknowns and nuisances of a checkpoint, and compares all of their states. The
    /// simulations run on all threads.
    ///
    /// Parameters
    /// ----------
    /// trajectories : list of Trajectory
    ///     Measurements of the fit.
    /// checkpoint : Checkpoint
    ///     Unknowns, and nuisances of each measurement, usually Fit.checkpoint.
    ///
    /// Returns
    /// -------
    /// list of Prediction or HydroelasticError
    ///     Simulated motion and errors of each measurement. If a rollout ends early, its result is the exception.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a trajectory does not fit the world or the time step, or the checkpoint does not fit the identification or the number of
    ///     trajectories.
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] trajectories: Vec<Bound<'py, Trajectory>>,
        checkpoint: &Checkpoint,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let residuals = |inner: &identification::Identification, measurements: &[Measurement]| {
            inner.residuals(measurements, &checkpoint.0)
        };
        self.evaluated(
            py,
            &trajectories,
            residuals,
            |prediction| match prediction {
                Ok(prediction) => Prediction(prediction).into_bound_py_any(py),
                Err(why) => error(&why).into_bound_py_any(py),
            },
        )
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
    /// Prediction
    ///     Simulated motion, and its errors.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a value is out of range, the trajectory does not fit the world or the time step, or the rollout ends early.
    #[pyo3(signature = (values, trajectory, *, fitted_duration=None))]
    fn predict(
        &self,
        py: Python<'_>,
        values: &Bound<'_, PyAny>,
        trajectory: &Trajectory,
        #[pyo3(from_py_with = optional_real)] fitted_duration: Option<f64>,
    ) -> PyResult<Prediction> {
        let values = list(values, "values")?;
        let start = fitted_duration.map_or(StartingState::Measured, StartingState::Fitted);
        let measurement = measurement((0, &trajectory.inner));
        let prediction = cancelable(py, self.inner.clone(), |inner| {
            inner.predict(&values, &measurement, start)
        })?;
        prediction.map(Prediction).map_err(|why| error(&why))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(
        (
            Bound<'py, World>,
            Bound<'py, Plan>,
            Vec<Bound<'py, Unknown>>,
        ),
        Bound<'py, PyDict>,
    )> {
        let unknowns = self.unknowns.iter().map(|unknown| unknown.bind(py).clone());
        let positional = (
            self.world.bind(py).clone(),
            self.plan.bind(py).clone(),
            unknowns.collect(),
        );
        Ok((positional, self.settings.keywords(py)?))
    }
}

/// Reads a parameter and the standard deviation of its error.
fn nuisance(argument: &Bound<'_, PyAny>) -> PyResult<(Py<Parameter>, f64)> {
    let expected = "a Parameter and a standard deviation, as in (parameter, 0.1)";
    let [parameter, deviation] = parts(argument, "a nuisance", expected)?;
    let deviation = named_real(&deviation, "the deviation of a nuisance")?;
    Ok((parameter.cast_into::<Parameter>()?.unbind(), deviation))
}

/// Inputs of a fit, and the exception of a Python function that the fit calls.
struct Job {
    inner: identification::Identification,
    measurements: Vec<Measurement>,
    checkpoint: identification::Checkpoint,
    raised: Raised,
}

impl Identification {
    fn job(
        &self,
        trajectories: &[Bound<'_, Trajectory>],
        start: Option<&Checkpoint>,
        progress: Option<Py<PyAny>>,
    ) -> Job {
        let raised = Raised::default();
        let mut inner = self.inner.clone();
        if let Some(progress) = progress {
            let raised = Arc::clone(&raised);
            inner = inner.with_progress(move |iteration| told(&progress, iteration, &raised));
        }
        let checkpoint = match start {
            Some(start) => start.0.clone(),
            None => inner.first_checkpoint(trajectories.len()),
        };
        Job {
            inner,
            measurements: measurements(trajectories),
            checkpoint,
            raised,
        }
    }

    /// Returns the results of a function of the identification and measurements, each converted to a Python object.
    fn evaluated<'py, V: Send>(
        &self,
        py: Python<'py>,
        trajectories: &[Bound<'_, Trajectory>],
        function: impl FnOnce(&identification::Identification, &[Measurement]) -> Evaluated<V> + Send,
        converted: impl Fn(Result<V, IdentificationError>) -> PyResult<Bound<'py, PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let measurements = measurements(trajectories);
        let evaluated = cancelable(py, self.inner.clone(), |inner| {
            function(inner, &measurements)
        })?;
        let results = evaluated.map_err(|why| error(&why))?;
        results.into_iter().map(converted).collect()
    }
}

/// Runs a function of an identification without the GIL. Ctrl-C cancels it.
fn cancelable<V: Send>(
    py: Python<'_>,
    inner: identification::Identification,
    function: impl FnOnce(&identification::Identification) -> V + Send,
) -> PyResult<V> {
    let shared = Shared::default();
    let inner = inner.with_cancel_flag(Arc::clone(&shared.stop));
    run(py, &shared, None, || function(&inner))
}

/// Result of a fit, or the exception of a Python function.
fn ended(fit: Result<identification::Fit, IdentificationError>, raised: &Raised) -> PyResult<Fit> {
    let raised = raised.lock().map_or(None, |mut raised| raised.take());
    match raised {
        Some(exception) => Err(exception),
        None => fit.map(Fit).map_err(|why| error(&why)),
    }
}

fn measurement((index, trajectory): (usize, &States)) -> Measurement {
    Measurement::new(format!("trajectory {index}"), trajectory.clone())
}

fn measurements(trajectories: &[Bound<'_, Trajectory>]) -> Vec<Measurement> {
    let trajectories = trajectories.iter();
    let trajectories = trajectories.map(|trajectory| &trajectory.get().inner);
    trajectories.enumerate().map(measurement).collect()
}

/// Calls the progress function. Stores an exception, and ends the fit after an exception or the result True.
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
            store(raised, exception);
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
