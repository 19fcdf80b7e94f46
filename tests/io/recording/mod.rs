//! Recordings, read back: what the file shows is what the states and contacts say.

mod arrows;
mod contact_surfaces;
mod motion;
mod recorded_worlds;
mod refusals;
mod scene;
mod targets_and_paths;
