//! Long jobs on a worker thread, while the calling thread handles signals and reports progress.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

/// Period of the checks for signals.
const PERIOD: Duration = Duration::from_millis(20);

/// Data that a job and the calling thread share.
#[derive(Clone, Default)]
pub struct Shared {
    /// Set when the job should end.
    pub stop: Arc<AtomicBool>,
    /// Number of completed parts of the job.
    pub done: Arc<AtomicUsize>,
}

/// Python function that receives the number of completed parts.
pub struct Progress<'py>(Bound<'py, PyAny>);

impl<'py> Progress<'py> {
    /// Reads the argument `progress`: `None` or `False`, `True` for a progress bar, or a function of (done, total).
    pub fn of(
        py: Python<'py>,
        argument: Option<&Bound<'py, PyAny>>,
        total: usize,
    ) -> PyResult<Option<Self>> {
        let is_off = |argument: &&Bound<'py, PyAny>| {
            argument.cast::<PyBool>().is_ok_and(|flag| !flag.is_true())
        };
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

/// Runs a job without the GIL and returns its result. If a signal handler (such as that of Ctrl-C) or the progress function raises an
/// exception, the stop flag is set, and the exception is raised after the job has ended.
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
            // A worker that panics finishes without setting the flag.
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

/// Reports progress if the number of completed parts has changed. Returns the last reported number.
fn tell(progress: Option<&Progress<'_>>, shared: &Shared, told: usize) -> PyResult<usize> {
    let done = shared.done.load(Ordering::Relaxed);
    match progress {
        Some(progress) if done != told => progress.tell(done).map(|()| done),
        _ => Ok(told),
    }
}
