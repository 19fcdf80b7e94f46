use super::{Force, Plan, Rollout, RolloutError, RolloutFailure, RolloutResult, Trajectory, World};
use crate::parallel::{self, Panicked, contained};
use crate::scalar::Scalar;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Progress of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Number of rollouts that have ended, with or without an error.
    pub finished: usize,
    /// Number of rollouts in the batch.
    pub total: usize,
}

/// Independent jobs with rollouts of one plan, spread over all threads.
///
/// [`Self::rollouts`] returns the trajectories of many worlds. [`Self::map`] calls a function for each item of a list, for example to
/// differentiate each world. Results have the order of their items, and the same bits for any number of threads. If one job fails
/// or panics, its result is an error, and the other jobs continue.
///
/// ```
/// # use hydroelastic::contact::Shape;
/// # use hydroelastic::dynamics::{Batch, Body, Mass, Material, Plan, World};
/// # use hydroelastic::gradient::{FinalPosition, GradientError, Parameter};
/// # use hydroelastic::mesh::shapes;
/// # let ball = Shape::new(shapes::icosphere(0.1, 1)?);
/// # let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// # let world = World::new(vec![ball])?;
/// # use std::ops::ControlFlow;
/// let batch = Batch::new(&Plan::new(1e-3, 500)?).with_progress(|progress| {
///     println!("{}/{}", progress.finished, progress.total);
///     ControlFlow::Continue(()) // Break(()) would skip the jobs that have not begun.
/// });
/// let parameters = [Parameter::initial_velocity("ball")];
/// let velocities = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
/// let end = FinalPosition::of_body(&world, "ball")?;
/// let ends = batch.map(&velocities, |job, velocity| {
///     let thrown = world.with_values(&parameters, velocity)?;
///     job.experiment(thrown).jacobian(&parameters, &end)
/// });
/// for (end, velocity) in ends.into_iter().zip(velocities) {
///     let end = end?;
///     assert!((end.value[0] - 0.5 * velocity[0]).abs() < 1e-12);
///     assert!((end.jacobian[(0, 0)] - 0.5).abs() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Batch {
    job: Job,
    progress: Option<Arc<ProgressFunction>>,
}

/// Plan and cancel flag of one job of a [`Batch`]. It creates rollouts and experiments that end with the batch.
#[derive(Debug, Clone)]
pub struct Job {
    pub(crate) plan: Plan,
    pub(crate) stop: Arc<AtomicBool>,
}

impl Job {
    /// Creates a rollout of a world from its initial state.
    #[must_use]
    pub fn rollout<T: Scalar, F: Force>(&self, world: impl Into<Arc<World<T, F>>>) -> Rollout<T> {
        Rollout::new(world, &self.plan).with_cancel_flag(Arc::clone(&self.stop))
    }
}

type ProgressFunction = dyn Fn(Progress) -> ControlFlow<()> + Send + Sync;

impl Batch {
    /// Creates a batch with a plan.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let (plan, stop) = (*plan, Arc::default());
        Self {
            job: Job { plan, stop },
            progress: None,
        }
    }

    /// Sets a function that is called each time a rollout has ended. If the function returns [`ControlFlow::Break`], the batch ends:
    /// running rollouts continue to their end, and the other rollouts do not begin and return the error [`RolloutError::Stopped`].
    ///
    /// The function is called on the thread of the rollout, once for each count. Two calls may run at the same time or out of order. If the
    /// function panics, it is not called again, and the batch continues.
    #[must_use]
    pub fn with_progress(
        self,
        progress: impl Fn(Progress) -> ControlFlow<()> + Send + Sync + 'static,
    ) -> Self {
        Self {
            progress: Some(Arc::new(progress)),
            ..self
        }
    }

    /// Ends the batch once the flag is true. Running rollouts end before their next step, or during an implicit step, and the other
    /// rollouts do not begin. All of these return the error [`RolloutError::Stopped`]. Another thread or a signal handler can set the flag.
    #[must_use]
    pub fn with_cancel_flag(mut self, flag: Arc<AtomicBool>) -> Self {
        self.job.stop = flag;
        self
    }

    /// Trajectory of each world from its initial state. [`World::with_initial_state`] creates worlds that start from other states.
    pub fn rollouts<T: Scalar, F: Force>(&self, worlds: &[World<T, F>]) -> Vec<RolloutResult<T>> {
        let run = |world: &World<T, F>| self.job.rollout(world).run();
        self.results(worlds, run, |world| RolloutFailure {
            error: RolloutError::Stopped,
            trajectory: Trajectory::starting_with(world.initial_state()),
        })
    }

    /// Calls a function for each item.
    ///
    /// # Errors
    /// - The errors that the function returns.
    /// - [`RolloutError::Panicked`] if the function panics.
    /// - [`RolloutError::Stopped`] if the batch ends before the job of an item begins.
    pub fn map<I: Sync, O: Send, E: From<RolloutError> + Send>(
        &self,
        items: &[I],
        function: impl Fn(&Job, &I) -> Result<O, E> + Sync,
    ) -> Vec<Result<O, E>> {
        let call = |item: &I| {
            let result = contained(|| Ok::<_, RolloutError>(function(&self.job, item)));
            result.map_err(E::from)?
        };
        self.results(items, call, |_| RolloutError::Stopped.into())
    }

    /// Result of the job of each item, or the `stopped` error of an item whose job has not begun. The job must contain its panics.
    fn results<I: Sync, O: Send, E: Send>(
        &self,
        items: &[I],
        job: impl Fn(&I) -> Result<O, E> + Sync,
        stopped: impl Fn(&I) -> E + Sync,
    ) -> Vec<Result<O, E>> {
        let (finished, total) = (AtomicUsize::new(0), items.len());
        let (has_panicked, is_stopped) = (AtomicBool::new(false), AtomicBool::new(false));
        parallel::map(items, |item| {
            if is_stopped.load(Ordering::Relaxed) || self.job.stop.load(Ordering::Relaxed) {
                return Err(stopped(item));
            }
            let result = job(item);
            let finished = finished.fetch_add(1, Ordering::Relaxed) + 1;
            if !has_panicked.load(Ordering::Relaxed) {
                match self.tell(Progress { finished, total }) {
                    Ok(ControlFlow::Continue(())) => {}
                    Ok(ControlFlow::Break(())) => is_stopped.store(true, Ordering::Relaxed),
                    Err(_) => has_panicked.store(true, Ordering::Relaxed),
                }
            }
            result
        })
    }

    /// Calls the progress function, if there is one.
    fn tell(&self, progress: Progress) -> Result<ControlFlow<()>, Panicked> {
        let Some(tell) = &self.progress else {
            return Ok(ControlFlow::Continue(()));
        };
        contained(|| Ok(tell(progress)))
    }
}

impl fmt::Debug for Batch {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Batch")
            .field("plan", &self.job.plan)
            .finish_non_exhaustive()
    }
}
