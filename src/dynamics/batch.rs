use super::world::check_time_step;
use super::{ExternalForces, Integrator, Recorded, Rollout, State, World, WorldError};
use crate::scalar::Scalar;
use crate::threads::{Panicked, contained, results_of};
use std::fmt;
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
/// # use hydroelastic::dynamics::{Batch, Body, Mass, Material, World};
/// # use hydroelastic::mesh::shapes;
/// # let ball = Shape::new(shapes::icosphere(0.1, 1)?);
/// # let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// # let world = World::new(vec![ball])?;
/// let starts = (0..10).map(|speed| {
///     let mut state = world.initial_state();
///     state.bodies[0].twist.linear.x = f64::from(speed);
///     state
/// });
/// let batch = Batch::new(1e-3, 500)?.with_progress(|p| println!("{}/{}", p.finished, p.total));
/// let flights = batch.starting_from(&world, &starts.collect::<Vec<_>>())?;
/// for (speed, flight) in (0..10).zip(flights) {
///     let x = flight?.last().bodies[0].position().x;
///     assert!((x - 0.5 * f64::from(speed)).abs() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Batch<'p> {
    pub(crate) time_step: f64,
    pub(crate) steps: usize,
    pub(crate) integrator: Integrator,
    pub(crate) record_every: usize,
    pub(crate) check_every: Option<usize>,
    progress: Option<Box<dyn Fn(Progress) + Sync + 'p>>,
}

impl<'p> Batch<'p> {
    /// Leapfrog steps of `time_step` (s), all of them recorded.
    ///
    /// # Errors
    /// If the time step is not positive and finite.
    pub fn new(time_step: f64, steps: usize) -> Result<Self, WorldError> {
        check_time_step(time_step)?;
        Ok(Self {
            time_step,
            steps,
            integrator: Integrator::default(),
            record_every: 1,
            check_every: None,
            progress: None,
        })
    }

    /// The same batch with another integrator.
    #[must_use]
    pub fn with_integrator(self, integrator: Integrator) -> Self {
        Self { integrator, ..self }
    }

    /// The same batch, recording the initial state, every `every`th after it, and the last.
    #[must_use]
    pub fn recording_every(self, every: usize) -> Self {
        Self {
            record_every: every,
            ..self
        }
    }

    /// The same batch, every rollout of it
    /// [with a stability check](Rollout::with_stability_check).
    #[must_use]
    pub fn with_stability_check(self, every: usize) -> Self {
        Self {
            check_every: Some(every),
            ..self
        }
    }

    /// The same batch, telling a function of each rollout that has ended.
    ///
    /// The function is called on the thread of that rollout: with each count once, but two of them
    /// may come at the same time or out of order. After a panic in it, it is not called again; the batch
    /// goes on.
    #[must_use]
    pub fn with_progress(self, progress: impl Fn(Progress) + Sync + 'p) -> Self {
        Self {
            progress: Some(Box::new(progress)),
            ..self
        }
    }

    /// The trajectory of a world from each state; counted from the state's own time.
    ///
    /// # Errors
    /// If a state has another number of bodies than the world, a pose that is not rigid, or a number that is
    /// not finite; no rollout is begun then.
    pub fn starting_from<T: Scalar, F: ExternalForces>(
        &self,
        world: &World<T, F>,
        states: &[State<T>],
    ) -> Result<Vec<Recorded<T>>, WorldError> {
        states
            .iter()
            .try_for_each(|state| state.check_fits(world))?;
        Ok(self.results(states, |state| {
            let rollout = self.rollout(world);
            self.recorded(rollout.starting_from_fitting(state.clone()))
        }))
    }

    /// The trajectory of each world from its initial state.
    pub fn of_worlds<T: Scalar, F: ExternalForces>(
        &self,
        worlds: &[World<T, F>],
    ) -> Vec<Recorded<T>> {
        self.results(worlds, |world| self.recorded(self.rollout(world)))
    }

    /// The result of a job for each item, over all threads. The job contains its panics.
    pub(crate) fn results<I: Sync, O: Send>(
        &self,
        items: &[I],
        job: impl Fn(&I) -> O + Sync,
    ) -> Vec<O> {
        let (finished, total) = (AtomicUsize::new(0), items.len());
        let has_panicked = AtomicBool::new(false);
        results_of(items, |item| {
            let result = job(item);
            let finished = finished.fetch_add(1, Ordering::Relaxed) + 1;
            if !has_panicked.load(Ordering::Relaxed)
                && self.tell(Progress { finished, total }).is_err()
            {
                has_panicked.store(true, Ordering::Relaxed);
            }
            result
        })
    }

    /// Calls the progress function, if there is one.
    fn tell(&self, progress: Progress) -> Result<(), Panicked> {
        let Some(tell) = &self.progress else {
            return Ok(());
        };
        contained(|| {
            tell(progress);
            Ok(())
        })
    }

    fn rollout<'w, T: Scalar, F: ExternalForces>(
        &self,
        world: &'w World<T, F>,
    ) -> Rollout<'w, T, F> {
        Rollout::new(world, self.time_step, self.integrator).checked_every(self.check_every)
    }

    /// What a rollout records until it ends or fails.
    fn recorded<T: Scalar, F: ExternalForces>(&self, rollout: Rollout<'_, T, F>) -> Recorded<T> {
        rollout.recorded(self.steps, self.record_every)
    }
}

impl fmt::Debug for Batch<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Batch")
            .field("time_step", &self.time_step)
            .field("steps", &self.steps)
            .field("integrator", &self.integrator)
            .field("record_every", &self.record_every)
            .field("check_every", &self.check_every)
            .finish_non_exhaustive()
    }
}
