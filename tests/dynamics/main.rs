//! Worlds and their rollouts.

mod body_kinds;
mod conservation;
mod contacts;
mod custom_forces;
mod failures;
mod forces;
mod free_rotation;
mod gradient_refusals;
mod heap;
mod implicit;
mod joints;
mod kinetics;
mod long_runs;
mod motion;
mod partners;
mod reference_trajectory;
mod refusals;
mod rollout;
mod scenes;
mod stability;
mod starts_and_endings;
mod stopping;

#[path = "../support/mod.rs"]
mod support;
