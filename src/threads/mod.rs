//! All that knows of threads: the values of many items at once, in the order of the items. Without
//! the feature `parallel` the same values come one after another.

#[cfg(feature = "parallel")]
mod pool;

#[cfg(feature = "parallel")]
use pool::Threads;
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The fewest short values that are worth spreading over threads. Waking these took about 20 µs; the contact of two
/// coarse bodies takes a few if they do not touch, and some ten if they do (`cargo bench --bench
/// crowd`, with this at 1 and at its value, 4 and 9 bodies).
const WORTH_THREADS: usize = 16;

/// From so many pieces on, they are shared out: of contact polygons in `f64`, each is some 20 µs of work.
#[cfg(feature = "parallel")]
const WORTH_PIECES: usize = 4;

/// So many of the values that come one for each index are one thread's, or more.
#[cfg(feature = "parallel")]
const LEAST_VALUES: usize = 512;

thread_local! {
    /// Whether this thread works on a job, one of many, that it must not wait in.
    static HAS_JOB: Cell<bool> = const { Cell::new(false) };
}

/// The short values of many items, into room that is used again: by several threads where that
/// pays.
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

/// The results of many long jobs, in the order of their items: over all threads, each job on one thread alone. For many contacts
/// or rollouts at once; jobs of a few µs are better handed over in chunks.
///
/// ```
/// use hydroelastic::contact::{BodyError, ContactBody, ContactPair, Shape, results_of};
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::vector;
///
/// let ball = Shape::new(shapes::icosphere(0.1, 2)?);
/// let forces = results_of(&[0.17, 0.18, 0.19], |&height| {
///     let above = Pose::from_translation(vector![0.0, 0.0, height]);
///     let a = ContactBody::new(&ball, above, 1e5)?;
///     let b = ContactBody::new(&ball, Pose::identity(), 1e5)?;
///     Ok::<_, BodyError>(ContactPair::new(a, b).wrench().on_a.force.z)
/// });
/// let forces = forces.into_iter().collect::<Result<Vec<_>, _>>()?;
/// assert!(forces[0] > forces[1] && forces[1] > forces[2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn results_of<I: Sync, O: Send>(items: &[I], job: impl Fn(&I) -> O + Sync) -> Vec<O> {
    let mut results = Vec::with_capacity(items.len());
    spread_into(&mut results, items, |item| alone(|| job(item)));
    results
}

/// Does one of many jobs on this thread alone.
///
/// A thread that waited for help in a job would be given other jobs to do meanwhile, whole ones, one
/// on top of the other on its stack.
fn alone<O>(job: impl FnOnce() -> O) -> O {
    let _until_dropped = Job {
        had_job: HAS_JOB.replace(true),
    };
    job()
}

/// Ends a job when dropped, after a panic too.
struct Job {
    had_job: bool,
}

impl Drop for Job {
    fn drop(&mut self) {
        HAS_JOB.set(self.had_job);
    }
}

/// Why a job has no result: it panicked, with this message.
#[derive(Debug)]
pub(crate) struct Panicked(pub String);

/// Turns a panic into an error. State that the job mutates must stay valid if a function panics that was passed in, or be
/// discarded.
pub(crate) fn contained<O, E: From<Panicked>>(job: impl FnOnce() -> Result<O, E>) -> Result<O, E> {
    let result = catch_unwind(AssertUnwindSafe(job));
    result.unwrap_or_else(|payload| Err(Panicked(panic_message(&*payload)).into()))
}

/// Threads that share a list of items in pieces of this length; `None` if the list is too short.
#[cfg(feature = "parallel")]
fn threads_for(items: usize, length: usize) -> Option<Threads> {
    if items < WORTH_PIECES * length || HAS_JOB.get() {
        return None;
    }
    Threads::available().filter(|threads| threads.count() > 1)
}

/// Appends, in order, what is found in each piece of `length` items, which may change: by several threads where so many items
/// pay.
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

/// The short values of 0, 1, 2 and so on to before `count`, each some 0.1 to 10 µs of work: by several threads where so many
/// pay.
pub(crate) fn values_of<O: Send>(count: usize, value: impl Fn(usize) -> O + Sync + Send) -> Vec<O> {
    #[cfg(feature = "parallel")]
    if let Some(threads) = threads_for(count, LEAST_VALUES) {
        let indices = (0..count).into_par_iter().with_min_len(LEAST_VALUES);
        return threads.run(|| indices.map(value).collect());
    }
    (0..count).map(value).collect()
}

/// The results of two long jobs: by two threads, if there are.
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

/// Hands on, in order, a value for each piece of `length` items: by several threads where so many items pay.
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

/// An item at a time for each thread: items differ widely in what they take.
fn spread_into<I: Sync, O: Send>(values: &mut Vec<O>, items: &[I], value: impl Fn(&I) -> O + Sync) {
    #[cfg(feature = "parallel")]
    if let Some(threads) = Threads::available() {
        let singly = items.par_iter().with_max_len(1);
        return threads.run(|| singly.map(&value).collect_into_vec(values));
    }
    values.clear();
    values.extend(items.iter().map(value));
}
