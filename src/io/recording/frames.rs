//! Which states of a trajectory are shown, and when.

use crate::dynamics::{Contact, ExternalForces, State, Trajectory, World};

/// Frames for each second of the recording, at most.
const RATE: f64 = 60.0;
/// Rounding of times, as a part of the time between frames.
const ROUNDING: f64 = 1e-6;

/// A state that is shown.
pub(super) struct Frame<'a> {
    /// When (s of the recording, from its beginning).
    pub time: f64,
    pub state: &'a State,
    pub contacts: Vec<Contact>,
}

/// The first state, and then those no nearer to each other than the frame rate allows, time passing so
/// many times slower.
pub(super) fn frames<'a, F: ExternalForces>(
    world: &World<f64, F>,
    trajectory: &'a Trajectory,
    slowdown: f64,
) -> Vec<Frame<'a>> {
    let start = trajectory.states()[0].time;
    let mut due = 0.0;
    let mut frames = Vec::new();
    for state in trajectory.states() {
        let time = (state.time - start) * slowdown;
        if time >= due || frames.is_empty() {
            due = time + (1.0 - ROUNDING) / RATE;
            frames.push(Frame {
                time,
                state,
                contacts: world.contacts(state),
            });
        }
    }
    frames
}
