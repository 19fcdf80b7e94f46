//! Allocations: steps allocate nothing, reverse sweeps stay within their memory limit, and hostile files need little memory.

mod hostile_files;
mod steps;
mod sweeps;

use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// Locks the counting allocator, which all threads of a program share, so that tests run one after the other.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}
