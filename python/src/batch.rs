//! Batches of independent rollouts.

use crate::arrays::{Numbers, array, numbers, numbers_of_shape, wrong_shape};
use crate::errors::{gradient_error, rollout_error, value_error};
use crate::interrupt::{Progress, Shared, run};
use crate::jacobian::{AllStates, both};
use crate::lists::list_of;
use crate::parameter::{Parameter, inner};
use crate::plan::Plan;
use crate::state::State;
use crate::state_arrays::shapes_of;
use crate::state_cotangents::StateCotangents;
use crate::states::States;
use crate::trajectory::Trajectory;
use crate::world::{Inner, World};
use hydroelastic::dynamics::{self, RolloutResult};
use hydroelastic::gradient::{self, GradientError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Batch of independent rollouts with one plan, on all cores and without the GIL.
///
/// Every method returns a list with the results in the order of its inputs. Each result has the same bits as that of a single
/// rollout. If a rollout fails, its result is the exception, and the other rollouts continue.
///
/// Ctrl-C ends a batch: running rollouts end before their next step, or during an implicit step. The environment variable
/// RAYON_NUM_THREADS=1 limits a batch to one core. A batch can be pickled if its progress function can be pickled.
///
/// Parameters
/// ----------
/// plan : Plan
///     Plan of each rollout.
/// progress : bool or callable, optional
///     True for a progress bar of tqdm if tqdm is installed, or a function of (done, total) rollouts.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Batch {
    plan: dynamics::Plan,
    progress: Option<Py<PyAny>>,
}

impl Batch {
    /// Runs a job on the batch of the library. Reports how many of `total` rollouts have ended.
    fn results<O: Send>(
        &self,
        py: Python<'_>,
        total: usize,
        job: impl FnOnce(&dynamics::Batch) -> O + Send,
    ) -> PyResult<O> {
        let progress = self.progress.as_ref().map(|callback| callback.bind(py));
        let progress = Progress::of(py, progress, total)?;
        let shared = Shared::default();
        let done = Arc::clone(&shared.done);
        let batch = dynamics::Batch::new(&self.plan).with_cancel_flag(Arc::clone(&shared.stop));
        let batch = batch.with_progress(move |_| {
            done.fetch_add(1, Ordering::Relaxed);
            ControlFlow::Continue(())
        });
        run(py, &shared, progress.as_ref(), || job(&batch))
    }
}

/// Converts a result to a Python object. An error becomes an exception object, which is not raised.
fn shown<'py, T>(py: Python<'py>, result: PyResult<T>) -> PyResult<Bound<'py, PyAny>>
where
    T: IntoPyObject<'py, Output = Bound<'py, <T as IntoPyObject<'py>>::Target>, Error = PyErr>,
{
    match result {
        Ok(value) => value.into_pyobject(py).map(Bound::into_any),
        Err(error) => Ok(error.into_value(py).into_bound(py).into_any()),
    }
}

fn trajectory(py: Python<'_>, recorded: RolloutResult) -> PyResult<Trajectory> {
    match recorded {
        Ok(trajectory) => Ok(trajectory.into()),
        Err(why) => Err(rollout_error(py, &why.error, why.trajectory)),
    }
}

/// Initial state of the first world. Returns an error if another world has other numbers of bodies or joints.
fn common_state(worlds: &[Inner]) -> PyResult<Option<dynamics::State>> {
    let mut states = worlds.iter().map(Inner::initial_state);
    let Some(first) = states.next() else {
        return Ok(None);
    };
    let counts = |state: &dynamics::State| {
        let [poses, _, scalars, _, balls, _] = shapes_of(state);
        let [bodies, scalars, balls] = [poses[0], scalars[0], balls[0]];
        format!(
            "{bodies} bodies, {scalars} joints with one degree of freedom and {balls} ball joints"
        )
    };
    match states.find(|state| shapes_of(state) != shapes_of(&first)) {
        None => Ok(Some(first)),
        Some(different) => Err(value_error(format!(
            "the worlds must have the same numbers of bodies and joints, but one has {} and another {}",
            counts(&first),
            counts(&different)
        ))),
    }
}

/// Converts parameters to those of Rust. Returns an error if a parameter does not belong to the world.
fn parameters_of(
    world: &World,
    parameters: &[Bound<'_, Parameter>],
) -> PyResult<Vec<gradient::Parameter>> {
    let by = inner(parameters);
    let values = world.inner.values(&by);
    values.map_err(|why| gradient_error(&why))?;
    Ok(by)
}

/// Reads n rows of changes of parameters.
fn samples_of(argument: &Bound<'_, PyAny>, by: &[gradient::Parameter]) -> PyResult<Vec<Vec<f64>>> {
    let width: usize = by.iter().map(gradient::Parameter::dimension).sum();
    let Numbers { values, shape } = numbers(argument, "samples")?;
    match shape[..] {
        [count, 0] if width == 0 => Ok(vec![Vec::new(); count]),
        [_, found] if found == width => Ok(values.chunks(width).map(<[f64]>::to_vec).collect()),
        _ => Err(wrong_shape("samples", &format!("(n, {width})"), &shape)),
    }
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (plan, *, progress=None))]
    fn new(plan: &Plan, progress: Option<Py<PyAny>>) -> Self {
        Self {
            plan: plan.0,
            progress,
        }
    }

    /// Plan of each rollout.
    #[getter]
    fn plan(&self) -> Plan {
        Plan(self.plan)
    }

    /// Runs a rollout of one world from each of several states.
    ///
    /// Parameters
    /// ----------
    /// world : World
    ///     World of all rollouts.
    /// states : list of State
    ///     Initial state of each rollout.
    ///
    /// Returns
    /// -------
    /// list of Trajectory or RolloutError
    ///     Result of each rollout.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a state does not fit the world.
    fn rollouts_from<'py>(
        &self,
        py: Python<'py>,
        world: &World,
        #[pyo3(from_py_with = list_of)] states: Vec<Bound<'py, State>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let start = |state: &Bound<'py, State>| {
            let world = world.inner.clone().with_initial_state(&state.get().0);
            world.map_err(value_error)
        };
        let worlds: Vec<Inner> = states.iter().map(start).collect::<PyResult<_>>()?;
        let results = self.results(py, worlds.len(), |batch| batch.rollouts(&worlds))?;
        let results = results.into_iter();
        results
            .map(|recorded| shown(py, trajectory(py, recorded)))
            .collect()
    }

    /// Runs a rollout of each of several worlds from its initial state.
    ///
    /// Parameters
    /// ----------
    /// worlds : list of World
    ///     World of each rollout.
    ///
    /// Returns
    /// -------
    /// list of Trajectory or RolloutError
    ///     Result of each rollout.
    fn rollouts<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] worlds: Vec<Bound<'py, World>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let worlds: Vec<Inner> = worlds
            .iter()
            .map(|world| world.get().inner.clone())
            .collect();
        let results = self
            .results(py, worlds.len(), |batch| batch.rollouts(&worlds))?
            .into_iter();
        results
            .map(|recorded| shown(py, trajectory(py, recorded)))
            .collect()
    }

    /// Simulates k copies of a world, each from its own state, and returns their last states.
    ///
    /// Only the last states are kept, so this is the fastest way to step many worlds. Controls and paths depend on the times of the states.
    /// A control with one long interval acts at all times.
    ///
    /// Parameters
    /// ----------
    /// world : World
    ///     World that is copied.
    /// states : States
    ///     Initial state of each copy.
    /// parameters : list of Parameter
    ///     Parameters whose values differ between the copies, with p components in total, for example the wrench of a control. A
    ///     parameter of the initial state replaces this part of the state.
    /// values : (k, p) array_like, optional
    ///     Values of the parameters in each copy, as in World.with_values.
    ///
    /// Returns
    /// -------
    /// states : States
    ///     Last state of each copy. A copy with an error keeps the last state before the error.
    /// errors : dict of int to HydroelasticError
    ///     Errors by the indices of the copies.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If values has an unexpected shape, or a parameter does not belong to the world.
    #[pyo3(signature = (world, states, parameters=vec![], values=None))]
    fn advance(
        &self,
        py: Python<'_>,
        world: &World,
        states: &States,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
        values: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(States, BTreeMap<usize, PyErr>)> {
        let by = parameters_of(world, &parameters)?;
        let width = by.iter().map(gradient::Parameter::dimension).sum();
        let values = match values {
            Some(values) => numbers_of_shape(values, "values", &[states.0.len(), width])?,
            None if width == 0 => Vec::new(),
            None => {
                let rows = states.0.len();
                return Err(value_error(format!(
                    "parameters need values: give an array of the shape ({rows}, {width})"
                )));
            }
        };
        let rows: Vec<_> = states.0.iter().enumerate().collect();
        let job = |batch: &dynamics::Batch| {
            batch.map(&rows, |job, &(row, state)| {
                let mut world = world.inner.clone().with_initial_state(state)?;
                if width > 0 {
                    world = world.with_values(&by, &values[row * width..(row + 1) * width])?;
                }
                Ok::<_, GradientError>(job.rollout(world).run())
            })
        };
        let only_end = Self {
            plan: self.plan.recording_every(self.plan.steps()),
            progress: self
                .progress
                .as_ref()
                .map(|progress| progress.clone_ref(py)),
        };
        let mut errors = BTreeMap::new();
        let mut ends = Vec::with_capacity(rows.len());
        for (row, result) in only_end
            .results(py, rows.len(), job)?
            .into_iter()
            .enumerate()
        {
            ends.push(match result {
                Ok(Ok(trajectory)) => trajectory.last().clone(),
                Ok(Err(failure)) => {
                    let last = failure.trajectory.last().clone();
                    errors.insert(row, rollout_error(py, &failure.error, failure.trajectory));
                    last
                }
                Err(why) => {
                    errors.insert(row, gradient_error(&why));
                    states.0[row].clone()
                }
            });
        }
        Ok((States(ends), errors))
    }

    /// Runs a rollout of one world at each of n perturbations of its parameters.
    ///
    /// Parameters
    /// ----------
    /// world : World
    ///     World before the perturbation.
    /// parameters : list of Parameter
    ///     Parameters to perturb, with p components in total.
    /// samples : (n, p) array_like
    ///     Changes that are added to the parameters, as in World.perturbed.
    ///
    /// Returns
    /// -------
    /// list of Trajectory or HydroelasticError
    ///     Result of each rollout.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If samples has an unexpected shape, or a parameter does not belong to the world.
    /// TypeError
    ///     If samples is not an array of numbers.
    fn rollouts_perturbed<'py>(
        &self,
        py: Python<'py>,
        world: &World,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
        samples: &Bound<'py, PyAny>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let by = parameters_of(world, &parameters)?;
        let samples = samples_of(samples, &by)?;
        let changed = samples
            .iter()
            .map(|sample| world.inner.perturbed(&by, sample));
        let (mut worlds, mut refusals) = (Vec::new(), Vec::new());
        for outcome in changed {
            match outcome {
                Ok(world) => {
                    worlds.push(world);
                    refusals.push(None);
                }
                Err(why) => refusals.push(Some(gradient_error(&why))),
            }
        }
        let mut recordings = self
            .results(py, worlds.len(), |batch| batch.rollouts(&worlds))?
            .into_iter();
        let results = refusals.into_iter().map(|refusal| match refusal {
            Some(error) => shown(py, PyResult::<Trajectory>::Err(error)),
            None => recordings.next().map_or_else(
                || Err(value_error("a rollout has no result")),
                |recorded| shown(py, trajectory(py, recorded)),
            ),
        });
        results.collect()
    }

    /// Runs World.jacobian for one world at each of n perturbations of its parameters.
    ///
    /// Parameters
    /// ----------
    /// world : World
    ///     World before the perturbation.
    /// parameters : list of Parameter
    ///     Parameters to perturb and to differentiate with respect to, with p components in total.
    /// samples : (n, p) array_like
    ///     Changes that are added to the parameters, as in World.perturbed.
    ///
    /// Returns
    /// -------
    /// list of (Trajectory, TrajectoryJacobian) or HydroelasticError
    ///     Result of each rollout.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If samples has an unexpected shape, or a parameter does not belong to the world.
    /// TypeError
    ///     If samples is not an array of numbers.
    fn jacobians_perturbed<'py>(
        &self,
        py: Python<'py>,
        world: &World,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
        samples: &Bound<'py, PyAny>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let by = parameters_of(world, &parameters)?;
        let samples = samples_of(samples, &by)?;
        let job = |batch: &dynamics::Batch| {
            batch.map(&samples, |job, sample| {
                let world = world.inner.perturbed(&by, sample)?;
                job.experiment(world).jacobian(&by, &AllStates)
            })
        };
        let like = world.inner.initial_state();
        let outcomes = self.results(py, samples.len(), job)?.into_iter();
        let results = outcomes.map(|outcome| match outcome {
            Ok(outcome) => shown(py, Ok(both(py, &outcome, &like)?)),
            Err(why) => shown(py, PyResult::<Trajectory>::Err(gradient_error(&why))),
        });
        results.collect()
    }

    /// Runs World.jacobian for each of several worlds from its initial state.
    ///
    /// Parameters
    /// ----------
    /// worlds : list of World
    ///     World of each rollout.
    /// parameters : list of Parameter
    ///     Parameters to differentiate with respect to.
    ///
    /// Returns
    /// -------
    /// list of (Trajectory, TrajectoryJacobian) or HydroelasticError
    ///     Result of each rollout.
    fn jacobians<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] worlds: Vec<Bound<'py, World>>,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let by = inner(&parameters);
        let worlds: Vec<Inner> = worlds
            .iter()
            .map(|world| world.get().inner.clone())
            .collect();
        let job = |batch: &dynamics::Batch| {
            batch.map(&worlds, |job, world| {
                job.experiment(world).jacobian(&by, &AllStates)
            })
        };
        let outcomes = self.results(py, worlds.len(), job)?;
        let results = outcomes.iter().zip(&worlds).map(|(outcome, world)| {
            let outcome = outcome.as_ref().map_err(gradient_error);
            shown(
                py,
                outcome.and_then(|outcome| both(py, outcome, &world.initial_state())),
            )
        });
        results.collect()
    }

    /// Runs World.vjp for each of m worlds from its initial state.
    ///
    /// Parameters
    /// ----------
    /// worlds : list of World
    ///     World of each rollout. All worlds must have the same numbers of bodies and of joints of each kind.
    /// parameters : list of Parameter
    ///     Parameters to differentiate with respect to, with p components in total.
    /// by_poses : (m, k, n, 4, 4) array_like
    ///     Derivatives of each loss with respect to the poses of the k recorded states.
    /// by_twists : (m, k, n, 6) array_like
    ///     Derivatives of each loss with respect to the twists of the k recorded states.
    /// by_joint_positions, by_joint_velocities : (m, k, j) array_like, optional
    ///     Derivatives with respect to the positions and velocities of the revolute and prismatic joints. Default: zero.
    /// by_ball_joint_rotations : (m, k, b, 3, 3) array_like, optional
    ///     Derivatives with respect to the rotations of the ball joints. Default: zero.
    /// by_ball_joint_velocities : (m, k, b, 3) array_like, optional
    ///     Derivatives with respect to the angular velocities of the ball joints. Default: zero.
    ///
    /// Returns
    /// -------
    /// list of (p,) ndarray of float64 or HydroelasticError
    ///     Gradient of each loss.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the worlds have different numbers of bodies or joints, or an array has an unexpected shape.
    #[pyo3(signature = (worlds, parameters, by_poses, by_twists, *, by_joint_positions=None, by_joint_velocities=None,
                        by_ball_joint_rotations=None, by_ball_joint_velocities=None))]
    fn vjps<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] worlds: Vec<Bound<'py, World>>,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'py, Parameter>>,
        by_poses: &Bound<'py, PyAny>,
        by_twists: &Bound<'py, PyAny>,
        by_joint_positions: Option<&Bound<'py, PyAny>>,
        by_joint_velocities: Option<&Bound<'py, PyAny>>,
        by_ball_joint_rotations: Option<&Bound<'py, PyAny>>,
        by_ball_joint_velocities: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let by = inner(&parameters);
        let worlds: Vec<Inner> = worlds
            .iter()
            .map(|world| world.get().inner.clone())
            .collect();
        let arrays = [
            Some(by_poses),
            Some(by_twists),
            by_joint_positions,
            by_joint_velocities,
            by_ball_joint_rotations,
            by_ball_joint_velocities,
        ];
        let Some(like) = common_state(&worlds)? else {
            return Ok(Vec::new());
        };
        let cotangents = StateCotangents::of(arrays, &self.plan, &like, Some(worlds.len()))?;
        let job = |batch: &dynamics::Batch| {
            let items: Vec<_> = worlds.iter().enumerate().collect();
            batch.map(&items, |job, &(index, world)| {
                let vjp = job.experiment(world).vjp(&by)?;
                let by_states = cotangents.covectors(index, vjp.trajectory());
                vjp.pull_back(&by_states)
            })
        };
        let outcomes = self.results(py, worlds.len(), job)?.into_iter();
        let results = outcomes.map(|outcome| match outcome {
            Ok(gradient) => {
                Ok(array(py, gradient.as_slice().to_vec(), &[gradient.len()])?.into_any())
            }
            Err(why) => shown(py, PyResult::<Trajectory>::Err(gradient_error(&why))),
        });
        results.collect()
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((Plan,), Bound<'py, PyDict>)> {
        let keywords = PyDict::new(py);
        keywords.set_item("progress", self.progress.as_ref())?;
        Ok(((self.plan(),), keywords))
    }

    fn __repr__(&self) -> String {
        format!("Batch({})", Plan(self.plan).__repr__())
    }
}
