//! The threads of this process. A child process made by `fork` has none of its parent's threads, so it starts its own pool.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Maximum depth of nested forks in which each process has its own threads. Deeper processes use one thread.
const MAX_PROCESSES: usize = 64;

/// A process that has used threads, and its pool. The first process uses rayon's global pool instead.
struct Process {
    /// Process id; 0 for an unused entry.
    id: AtomicU32,
    pool: OnceLock<Option<ThreadPool>>,
}

/// Entries of the ancestors of this process, then the entry of this process. A child process gets a copy and uses the next entry, so
/// it never waits for a lock that another thread of its parent held during the fork.
static PROCESSES: [Process; MAX_PROCESSES] = [const {
    Process {
        id: AtomicU32::new(0),
        pool: OnceLock::new(),
    }
}; MAX_PROCESSES];

/// Threads that can run jobs: the threads of a pool, or of rayon's current pool if `None`.
pub(super) struct Threads(Option<&'static ThreadPool>);

impl Threads {
    /// Returns the threads of the pool that the caller runs in, or else the threads of this process. Returns `None` if they cannot be
    /// started.
    pub fn available() -> Option<Self> {
        if rayon::current_thread_index().is_some() {
            return Some(Self(None));
        }
        let id = process::id();
        let depth = PROCESSES.iter().position(|process| {
            if process.id.load(Ordering::SeqCst) == 0 {
                process.id.store(id, Ordering::SeqCst);
            }
            process.id.load(Ordering::SeqCst) == id
        })?;
        if depth == 0 {
            return Some(Self(None));
        }
        let start = || ThreadPoolBuilder::new().build().ok();
        let pool = PROCESSES[depth].pool.get_or_init(start).as_ref()?;
        Some(Self(Some(pool)))
    }

    /// Returns the number of threads.
    pub fn count(&self) -> usize {
        self.0
            .map_or_else(rayon::current_num_threads, ThreadPool::current_num_threads)
    }

    /// Runs a job on one of the threads. Parallel iterators in the job use all of them.
    pub fn run<O: Send>(&self, job: impl FnOnce() -> O + Send) -> O {
        match self.0 {
            Some(pool) => pool.install(job),
            None => job(),
        }
    }
}
