//! What is allocated: nothing by steps, by sweeps what they are given, and by hostile files no more than they are worth.

mod hostile_files;
mod steps;
mod sweeps;

use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// The allocator that counts is shared by all threads of a program: its tests run one after the other.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}
