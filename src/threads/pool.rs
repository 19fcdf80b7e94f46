//! The threads of this process. A child that `fork` made has none of its parent's threads, so it starts a pool of its own.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Longest line of forks in which each process has threads. Later processes work on one thread.
const MOST_PROCESSES: usize = 64;

/// A process that has used threads, and its pool. The first process uses rayon's global pool instead.
struct Process {
    /// 0 for none.
    id: AtomicU32,
    pool: OnceLock<Option<ThreadPool>>,
}

/// This process after its ancestors. A child gets a copy and takes the next entry, so it never waits for a lock that another
/// thread of its parent held during the fork.
static PROCESSES: [Process; MOST_PROCESSES] = [const {
    Process {
        id: AtomicU32::new(0),
        pool: OnceLock::new(),
    }
}; MOST_PROCESSES];

/// Threads that jobs can be given to: those of a pool, or of rayon's current pool.
pub(super) struct Threads(Option<&'static ThreadPool>);

impl Threads {
    /// The threads of the pool that the caller runs in, or else those of this process; none if they cannot be started.
    pub fn available() -> Option<Self> {
        if rayon::current_thread_index().is_some() {
            return Some(Self(None));
        }
        let id = process::id();
        let place = PROCESSES.iter().position(|process| {
            if process.id.load(Ordering::SeqCst) == 0 {
                process.id.store(id, Ordering::SeqCst);
            }
            process.id.load(Ordering::SeqCst) == id
        })?;
        if place == 0 {
            return Some(Self(None));
        }
        let start = || ThreadPoolBuilder::new().build().ok();
        let pool = PROCESSES[place].pool.get_or_init(start).as_ref()?;
        Some(Self(Some(pool)))
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        self.0
            .map_or_else(rayon::current_num_threads, ThreadPool::current_num_threads)
    }

    /// Does a job on one of the threads, from which rayon reaches the others.
    pub fn run<O: Send>(&self, job: impl FnOnce() -> O + Send) -> O {
        match self.0 {
            Some(pool) => pool.install(job),
            None => job(),
        }
    }
}
