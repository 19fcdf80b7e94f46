//! Selection of the states of a trajectory that a recording shows.

use super::precision::single;
use crate::dynamics::{Contact, Model, State, Trajectory};

/// Maximum frame rate of the recording (1/s).
const RATE: f64 = 60.0;
/// Rounding error of times, relative to the time between frames.
const ROUNDING: f64 = 1e-6;

/// A shown state.
pub(super) struct Frame<'a> {
    /// Time since the start of the recording (s).
    pub time: f64,
    pub state: &'a State,
    pub contacts: Vec<Contact>,
}

/// Shown states of a trajectory, with the times multiplied by `slowdown`.
pub(super) fn frames<'a>(
    model: &Model,
    trajectory: &'a Trajectory,
    slowdown: f64,
) -> Vec<Frame<'a>> {
    let states = trajectory.states();
    let start = states[0].time;
    let times: Vec<f64> = states
        .iter()
        .map(|state| (state.time - start) * slowdown)
        .collect();
    let frame = |index: usize| Frame {
        time: times[index],
        state: &states[index],
        contacts: model.contacts(&states[index]),
    };
    shown_indices(&times).into_iter().map(frame).collect()
}

/// Indices of the shown times: the first time, each time that is at least one frame period after
/// the previous shown time, and the last time. If the last time follows too soon, it replaces the
/// previous shown time, unless this is the first time.
fn shown_indices(times: &[f64]) -> Vec<usize> {
    let mut shown = vec![0];
    for index in 1..times.len() {
        let before = times[shown[shown.len() - 1]];
        if is_frame_after(before, times[index]) {
            shown.push(index);
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

/// Whether a time is at least one frame period after another time, and is also later in single
/// precision.
fn is_frame_after(before: f64, time: f64) -> bool {
    time - before >= (1.0 - ROUNDING) / RATE && single([before]) < single([time])
}
