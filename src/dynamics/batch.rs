use super::{
    Force, Interrupted, Plan, Recorded, Rollout, RolloutError, State, Trajectory, World, WorldError,
};
use crate::scalar::Scalar;
use crate::threads::{Panicked, contained, results_of};
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// How far a batch has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Rollouts that have ended, well or not.
    pub finished: usize,
    /// Rollouts in the batch.
    pub total: usize,
}

/// Many independent rollouts of one kind, over all threads: of one world from many states, of many
/// worlds, or of a world after many changes of its parameters ([`crate::gradient`]).
///
/// Results come in the order of what they belong to, with the same bits whatever the number of
/// threads. A rollout that fails has an error for its result, one in which a function that was
/// passed in panics too, and the others go on.
///
/// ```
/// # use hydroelastic::contact::Shape;
/// # use hydroelastic::dynamics::{Batch, Body, Mass, Material, Plan, World};
/// # use hydroelastic::mesh::shapes;
/// # let ball = Shape::new(shapes::icosphere(0.1, 1)?);
/// # let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// # let world = World::new(vec![ball])?;
/// # use std::ops::ControlFlow;
/// let starts = (0..10).map(|speed| {
///     let mut state = world.initial_state();
///     state.bodies[0].twist.linear.x = f64::from(speed);
///     state
/// });
/// let batch = Batch::new(&Plan::new(1e-3, 500)?).with_progress(|progress| {
///     println!("{}/{}", progress.finished, progress.total);
///     ControlFlow::Continue(()) // Break(()) would leave out the rollouts that are not begun.
/// });
/// let flights = batch.starting_from(&world, &starts.collect::<Vec<_>>())?;
/// for (speed, flight) in (0..10).zip(flights) {
///     let x = flight?.last().bodies[0].position().x;
///     assert!((x - 0.5 * f64::from(speed)).abs() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Batch {
    pub(crate) plan: Plan,
    progress: Option<Arc<ProgressFunction>>,
    pub(crate) stop: Arc<AtomicBool>,
}

type ProgressFunction = dyn Fn(Progress) -> ControlFlow<()> + Send + Sync;

impl Batch {
    /// Rollouts by a plan.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        Self {
            plan: *plan,
            progress: None,
            stop: Arc::default(),
        }
    }

    /// The same batch, telling a function of each rollout that has ended. Where the function returns
    /// [`ControlFlow::Break`], the batch ends: rollouts that run go on to their end, others are not begun and have the error
    /// [`RolloutError::Stopped`].
    ///
    /// The function is called on the thread of that rollout: with each count once, but two of them
    /// may come at the same time or out of order. After a panic in it, it is not called again; the batch
    /// goes on.
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

    /// Ends the batch once the flag is true. Running rollouts end before their next step, or during an implicit step, and no other
    /// rollout begins. Both return the error [`RolloutError::Stopped`]. Another thread or a signal handler can set the flag.
    #[must_use]
    pub fn stopped_by(self, flag: Arc<AtomicBool>) -> Self {
        Self { stop: flag, ..self }
    }

    /// The trajectory of a world from each state; counted from the state's own time.
    ///
    /// # Errors
    /// If a state has another number of bodies than the world, a pose that is not rigid, or a number that is
    /// not finite; no rollout is begun then.
    pub fn starting_from<T: Scalar, F: Force>(
        &self,
        world: &World<T, F>,
        states: &[State<T>],
    ) -> Result<Vec<Recorded<T>>, WorldError> {
        states
            .iter()
            .try_for_each(|state| state.check_fits(world.bodies()))?;
        let world = Arc::new(world.clone());
        let rollout = |state: &State<T>| {
            Rollout::new(Arc::clone(&world), &self.plan)
                .starting_from_fitting(state.clone())
                .stopped_by(Arc::clone(&self.stop))
        };
        Ok(self.results(
            states,
            |state| rollout(state).recorded(),
            |state| Interrupted {
                error: RolloutError::Stopped,
                trajectory: Trajectory::starting_with(state.clone()),
            },
        ))
    }

    /// The trajectory of each world from its initial state.
    pub fn of_worlds<T: Scalar, F: Force>(&self, worlds: &[World<T, F>]) -> Vec<Recorded<T>> {
        let job = |world: &World<T, F>| {
            let rollout = world.rollout(&self.plan);
            rollout.stopped_by(Arc::clone(&self.stop)).recorded()
        };
        self.results(worlds, job, |world| Interrupted {
            error: RolloutError::Stopped,
            trajectory: Trajectory::starting_with(world.initial_state()),
        })
    }

    /// The result of a job for each item, over all threads, or what it is for one that was not begun. The job contains its
    /// panics.
    pub(crate) fn results<I: Sync, O: Send, E: Send>(
        &self,
        items: &[I],
        job: impl Fn(&I) -> Result<O, E> + Sync,
        stopped: impl Fn(&I) -> E + Sync,
    ) -> Vec<Result<O, E>> {
        let (finished, total) = (AtomicUsize::new(0), items.len());
        let (has_panicked, is_stopped) = (AtomicBool::new(false), AtomicBool::new(false));
        results_of(items, |item| {
            if is_stopped.load(Ordering::Relaxed) || self.stop.load(Ordering::Relaxed) {
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
            .field("plan", &self.plan)
            .finish_non_exhaustive()
    }
}
