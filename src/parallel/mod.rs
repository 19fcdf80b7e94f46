//! All use of threads: computes the values of many items at once, in the order of the items. Without the feature `parallel`, the same
//! values are computed sequentially.

#[cfg(feature = "parallel")]
mod pool;

#[cfg(feature = "parallel")]
use pool::Threads;
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Smallest number of short values that are worth spreading over threads. Waking the threads took about 20 µs. The contact of two coarse
/// bodies takes a few µs if they do not touch, and some ten µs if they do (`cargo bench --bench crowd`, with this constant at 1 and at its
/// value, 4 and 9 bodies).
const WORTH_THREADS: usize = 16;

/// Smallest number of pieces that are spread over threads. For contact polygons in `f64`, each piece is about 20 µs of work.
#[cfg(feature = "parallel")]
const WORTH_PIECES: usize = 4;

/// Smallest number of indexed values for one thread.
#[cfg(feature = "parallel")]
const LEAST_VALUES: usize = 512;

thread_local! {
    /// Whether this thread works on one of many jobs, in which it must not wait.
    static HAS_JOB: Cell<bool> = const { Cell::new(false) };
}

/// Computes the short values of many items into memory that is used again. Uses several threads if this is faster.
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

/// Returns the results of many long jobs, in the order of their items. The jobs are spread over all threads, and each job runs on a single
/// thread. Use this for many contacts or rollouts at once. Jobs of a few µs should be grouped into chunks.
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
/// A thread that waits for help in a job would be given other whole jobs meanwhile, nested on its stack.
fn alone<O>(job: impl FnOnce() -> O) -> O {
    let _until_dropped = Job {
        had_job: HAS_JOB.replace(true),
    };
    job()
}

/// Ends a job when dropped, also after a panic.
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

/// Converts a panic to an error. If a function that was passed in panics, the state that the job mutates must stay valid or be discarded.
pub(crate) fn contained<O, E: From<Panicked>>(job: impl FnOnce() -> Result<O, E>) -> Result<O, E> {
    let result = catch_unwind(AssertUnwindSafe(job));
    result.unwrap_or_else(|payload| Err(Panicked(panic_message(&*payload)).into()))
}

/// Returns threads that share a list of items in pieces of this length, or `None` if the list is too short.
#[cfg(feature = "parallel")]
fn threads_for(items: usize, length: usize) -> Option<Threads> {
    if items < WORTH_PIECES * length || HAS_JOB.get() {
        return None;
    }
    Threads::available().filter(|threads| threads.count() > 1)
}

/// Appends, in order, the results for each piece of `length` items, which may be changed. Uses several threads if there are enough items.
pub(crate) fn collect_pieces<I: Send, C: Send>(
    items: &mut [I],
    length: usize,
    find: impl Fn(&mut [I], &mut Vec<C>) + Sync + Send,
    found: &mut Vec<C>,
) {
    #[cfg(feature = "parallel")]
    if let Some(threads) = threads_for(items.len(), length) {
        let find_in = |items: &mut [I]| {
            let mut found = Vec::new();
            find(items, &mut found);
            found
        };
        let finds: Vec<Vec<C>> =
            threads.run(|| items.par_chunks_mut(length).map(find_in).collect());
        return finds
            .into_iter()
            .for_each(|mut find| found.append(&mut find));
    }
    let _ = length;
    find(items, found);
}

/// Returns the short values of the indices from 0 to before `count`, each about 0.1 to 10 µs of work. Uses several threads if there are
/// enough values.
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

/// Passes on, in order, a value for each piece of `length` items. Uses several threads if there are enough items.
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

/// Computes values with one item at a time for each thread, because the time for an item varies widely.
fn spread_into<I: Sync, O: Send>(values: &mut Vec<O>, items: &[I], value: impl Fn(&I) -> O + Sync) {
    #[cfg(feature = "parallel")]
    if let Some(threads) = Threads::available() {
        let singly = items.par_iter().with_max_len(1);
        return threads.run(|| singly.map(&value).collect_into_vec(values));
    }
    values.clear();
    values.extend(items.iter().map(value));
}
