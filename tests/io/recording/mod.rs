//! Recordings: the files agree with the states and contacts.

mod arrows;
mod contact_surfaces;
mod half_spaces;
mod motion;
mod recorded_worlds;
mod refusals;
mod scene;
mod targets_and_paths;
