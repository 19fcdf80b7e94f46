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
mod links;
mod long_runs;
mod loops;
mod mimic;
mod motion;
mod partners;
mod reference_trajectory;
mod refusals;
mod robots;
mod rollout;
mod scenes;
mod schedules;
mod stability;
mod starts_and_endings;
mod stopping;

#[path = "../support/mod.rs"]
mod support;
