//! Which states of a trajectory are shown, and when.

use super::drawing::single;
use crate::dynamics::{Contact, Model, State, Trajectory};

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

/// The states that are shown, time passing so many times slower.
pub(super) fn frames<'a>(
    system: &Model,
    trajectory: &'a Trajectory,
    slowdown: f64,
) -> Vec<Frame<'a>> {
    let states = trajectory.states();
    let start = states[0].time;
    let times: Vec<f64> = states
        .iter()
        .map(|state| (state.time - start) * slowdown)
        .collect();
    let frame = |place: usize| Frame {
        time: times[place],
        state: &states[place],
        contacts: system.contacts(&states[place]),
    };
    shown(&times).into_iter().map(frame).collect()
}

/// Which of these times are shown: the first, those that come no sooner after the one shown before than
/// the frame rate allows, and the last, instead of one that it comes sooner after.
fn shown(times: &[f64]) -> Vec<usize> {
    let mut shown = vec![0];
    for place in 1..times.len() {
        let before = times[shown[shown.len() - 1]];
        if is_frame_after(before, times[place]) {
            shown.push(place);
        }
    }
    let last = times.len() - 1;
    if shown.len() > 1 {
        shown.pop();
    }
    if single([times[shown[shown.len() - 1]]]) < single([times[last]]) {
        shown.push(last);
    }
    shown
}

/// Whether a time is as much later as the frame rate asks, and later in single precision too.
fn is_frame_after(before: f64, time: f64) -> bool {
    time - before >= (1.0 - ROUNDING) / RATE && single([before]) < single([time])
}
