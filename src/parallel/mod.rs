//! Parallel computation of the values of many items, in the order of the items. Only this module uses threads. Without the feature
//! `parallel`, it computes the same values sequentially.

#[cfg(feature = "parallel")]
mod pool;

#[cfg(feature = "parallel")]
use pool::Threads;
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Smallest number of short values that are worth spreading over threads. Waking the threads took about 20 µs. The contact of two
/// coarse bodies takes a few µs if they do not touch, and about 10 µs if they do (`cargo bench --bench crowd`, with this constant at
/// 1 and at its value, 4 and 9 bodies).
const WORTH_THREADS: usize = 16;

/// Smallest number of pieces that are spread over threads. For contact polygons in `f64`, each piece is about 20 µs of work.
#[cfg(feature = "parallel")]
const WORTH_PIECES: usize = 4;

/// Smallest number of indexed values for one thread.
#[cfg(feature = "parallel")]
const LEAST_VALUES: usize = 512;

thread_local! {
    /// Whether this thread runs one of many jobs. Within a job it must not wait for other threads.
    static HAS_JOB: Cell<bool> = const { Cell::new(false) };
}

/// Computes the short values of many items into a reused vector. Uses several threads if this is faster.
pub(crate) fn mapped_into<I: Sync, O: Send>(
    values: &mut Vec<O>,
    items: &[I],
    value: impl Fn(&I) -> O + Sync,
) {
    if items.len() >= WORTH_THREADS && !HAS_JOB.get() {
        spread_into(values, items, |item| alone(|| value(item)));
    } else {
        values.clear();
        values.extend(items.iter().map(value));
    }
}

/// Returns the results of many long jobs, in the order of their items. The jobs are spread over all threads, and each job runs on a
/// single thread. Use this function for many contacts or rollouts at once. Group jobs of a few µs into chunks.
///
/// ```
/// use hydroelastic::contact::{BodyError, ContactBody, ContactPair, Shape};
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::parallel;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::vector;
///
/// let ball = Shape::new(shapes::icosphere(0.1, 2)?);
/// let forces = parallel::map(&[0.17, 0.18, 0.19], |&height| {
///     let above = Pose::from_translation(vector![0.0, 0.0, height]);
///     let a = ContactBody::new(&ball, above, 1e5)?;
///     let b = ContactBody::new(&ball, Pose::identity(), 1e5)?;
///     Ok::<_, BodyError>(ContactPair::new(a, b).wrench().on_a.force.z)
/// });
/// let forces = forces.into_iter().collect::<Result<Vec<_>, _>>()?;
/// assert!(forces[0] > forces[1] && forces[1] > forces[2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn map<I: Sync, O: Send>(items: &[I], job: impl Fn(&I) -> O + Sync) -> Vec<O> {
    let mut results = Vec::with_capacity(items.len());
    spread_into(&mut results, items, |item| alone(|| job(item)));
    results
}

/// Runs one of many jobs on this thread alone.
///
/// If the thread waited within the job, rayon would run other whole jobs on this thread meanwhile,
/// nested on its stack.
fn alone<O>(job: impl FnOnce() -> O) -> O {
    let _until_dropped = Job {
        had_job: HAS_JOB.replace(true),
    };
    job()
}

/// Guard that ends a job when it is dropped, even after a panic.
struct Job {
    had_job: bool,
}

impl Drop for Job {
    fn drop(&mut self) {
        HAS_JOB.set(self.had_job);
    }
}

/// Reason why a job has no result: it panicked, with this message.
#[derive(Debug)]
pub(crate) struct Panicked(pub String);

/// Runs a job and converts a panic to an error. The state that the job mutates must stay valid after a panic, or be discarded.
pub(crate) fn contained<O, E: From<Panicked>>(job: impl FnOnce() -> Result<O, E>) -> Result<O, E> {
    let result = catch_unwind(AssertUnwindSafe(job));
    result.unwrap_or_else(|payload| Err(Panicked(panic_message(&*payload)).into()))
}

/// Returns the threads for a list of items in pieces of this length, or `None` if the list is too short.
#[cfg(feature = "parallel")]
fn threads_for(items: usize, length: usize) -> Option<Threads> {
    if items < WORTH_PIECES * length || HAS_JOB.get() {
        return None;
    }
    Threads::available().filter(|threads| threads.count() > 1)
}

/// Appends the results of each piece of `length` items, in order. The function may change the items. Uses several threads if there
/// are enough items.
pub(crate) fn collect_pieces<I: Send, C: Send>(
    items: &mut [I],
    length: usize,
    append_results: impl Fn(&mut [I], &mut Vec<C>) + Sync + Send,
    results: &mut Vec<C>,
) {
    #[cfg(feature = "parallel")]
    if let Some(threads) = threads_for(items.len(), length) {
        let results_of = |piece: &mut [I]| {
            let mut results = Vec::new();
            append_results(piece, &mut results);
            results
        };
        let pieces: Vec<Vec<C>> =
            threads.run(|| items.par_chunks_mut(length).map(results_of).collect());
        return pieces
            .into_iter()
            .for_each(|mut piece| results.append(&mut piece));
    }
    let _ = length;
    append_results(items, results);
}

/// Returns the short values of the indices below `count`, each about 0.1 to 10 µs of work. Uses several threads if there are enough
/// values.
pub(crate) fn values_of<O: Send>(count: usize, value: impl Fn(usize) -> O + Sync + Send) -> Vec<O> {
    #[cfg(feature = "parallel")]
    if let Some(threads) = threads_for(count, LEAST_VALUES) {
        let indices = (0..count).into_par_iter().with_min_len(LEAST_VALUES);
        return threads.run(|| indices.map(value).collect());
    }
    (0..count).map(value).collect()
}

/// Returns the results of two long jobs. Uses two threads if they are available.
pub(crate) fn both<P: Send, Q: Send>(
    first: impl FnOnce() -> P + Send,
    second: impl FnOnce() -> Q + Send,
) -> (P, Q) {
    #[cfg(feature = "parallel")]
    if !HAS_JOB.get()
        && let Some(threads) = Threads::available()
    {
        return threads.run(|| rayon::join(first, second));
    }
    (first(), second())
}

/// Calls `take` in order with the value of each piece of `length` items. Uses several threads if there are enough items.
pub(crate) fn for_pieces<I: Sync, S: Send>(
    items: &[I],
    length: usize,
    value: impl Fn(&[I]) -> S + Sync + Send,
    take: impl FnMut(S),
) {
    #[cfg(feature = "parallel")]
    if let Some(threads) = threads_for(items.len(), length) {
        let values: Vec<S> = threads.run(|| items.par_chunks(length).map(value).collect());
        return values.into_iter().for_each(take);
    }
    items.chunks(length).map(value).for_each(take);
}

fn panic_message(payload: &(dyn Any + Send)) -> String {
    let formatted = payload.downcast_ref::<String>().map(String::as_str);
    let message = formatted.or_else(|| payload.downcast_ref::<&str>().copied());
    message
        .unwrap_or("a payload that is not a string")
        .to_owned()
}

/// Computes values with one item at a time on each thread, because the time for an item varies widely.
fn spread_into<I: Sync, O: Send>(values: &mut Vec<O>, items: &[I], value: impl Fn(&I) -> O + Sync) {
    #[cfg(feature = "parallel")]
    if let Some(threads) = Threads::available() {
        let single_items = items.par_iter().with_max_len(1);
        return threads.run(|| single_items.map(&value).collect_into_vec(values));
    }
    values.clear();
    values.extend(items.iter().map(value));
}
