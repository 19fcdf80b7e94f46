//! Worlds and their rollouts.

mod conservation;
mod contacts;
mod failures;
mod forces;
mod heap;
mod long_runs;
mod motion;
mod reference_trajectory;
mod rollout;
mod stability;
mod world;

#[path = "../support/mod.rs"]
mod support;
