//! Poses, states, materials, trajectories, plans, fits and whole worlds, saved and loaded with serde.

mod fits;
mod random_worlds;
mod refusals;
mod round_trips;
mod text_and_bits;
mod worlds;

#[path = "../support/mod.rs"]
mod support;
