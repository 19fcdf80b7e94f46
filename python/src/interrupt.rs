//! Long jobs on a thread of their own, while the calling thread watches for signals and shows progress.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

/// How often signals are looked for.
const PERIOD: Duration = Duration::from_millis(20);

/// What a job and its watcher share.
#[derive(Clone, Default)]
pub struct Shared {
    /// Set when the job should end.
    pub stop: Arc<AtomicBool>,
    /// How many parts of the job are done.
    pub done: Arc<AtomicUsize>,
}

/// A function of Python that is told how many parts are done.
pub struct Progress<'py>(Bound<'py, PyAny>);

impl<'py> Progress<'py> {
    /// From the argument `progress`: False, True for a bar, or a function of (done, total).
    pub fn of(
        py: Python<'py>,
        argument: Option<&Bound<'py, PyAny>>,
        total: usize,
    ) -> PyResult<Option<Self>> {
        let is_off =
            |argument: &&Bound<'py, PyAny>| argument.cast::<PyBool>().is_ok_and(|it| !it.is_true());
        let Some(argument) = argument.filter(|argument| !is_off(argument)) else {
            return Ok(None);
        };
        let function = py.import("hydroelastic._progress")?.getattr("shown")?;
        Ok(Some(Self(function.call1((argument, total))?)))
    }

    fn tell(&self, done: usize) -> PyResult<()> {
        self.0.call1((done,)).map(|_| ())
    }

    fn close(&self) -> PyResult<()> {
        self.0.call_method0("close").map(|_| ())
    }
}

/// The result of a job that runs without the GIL. Ctrl-C, another signal whose handler raises, or an exception of the progress
/// function asks the job to stop, and is raised when it has.
pub fn run<O: Send>(
    py: Python<'_>,
    shared: &Shared,
    progress: Option<&Progress<'_>>,
    job: impl FnOnce() -> O + Send,
) -> PyResult<O> {
    let watched = thread::scope(|scope| {
        let (watcher, has_ended) = (thread::current(), Arc::new(AtomicBool::new(false)));
        let ended = Arc::clone(&has_ended);
        let worker = scope.spawn(move || {
            let result = job();
            ended.store(true, Ordering::Release);
            watcher.unpark();
            result
        });
        let mut told = 0;
        let mut watch = || {
            // A worker that panics is finished without having said so.
            while !(has_ended.load(Ordering::Acquire) || worker.is_finished()) {
                py.detach(|| thread::park_timeout(PERIOD));
                py.check_signals()?;
                told = tell(progress, shared, told)?;
            }
            Ok(())
        };
        let seen: PyResult<()> = watch();
        if seen.is_err() {
            shared.stop.store(true, Ordering::Relaxed);
        }
        let result = py.detach(|| worker.join());
        let seen = seen.and_then(|()| tell(progress, shared, told).map(|_| ()));
        (seen, result)
    });
    let (seen, result) = watched;
    let closed = progress.map_or(Ok(()), Progress::close);
    seen?;
    closed?;
    result.map_err(|_| {
        PyRuntimeError::new_err("internal error: the library panicked; please report it")
    })
}

/// Tells of progress, if there is any.
fn tell(progress: Option<&Progress<'_>>, shared: &Shared, told: usize) -> PyResult<usize> {
    let done = shared.done.load(Ordering::Relaxed);
    match progress {
        Some(progress) if done != told => progress.tell(done).map(|()| done),
        _ => Ok(told),
    }
}
