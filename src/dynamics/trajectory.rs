use super::{RolloutError, State, WorldError};
use crate::scalar::Scalar;
use std::ops::Range;

/// Recorded states in the order of time.
#[derive(Debug, Clone)]
pub struct Trajectory<T = f64> {
    states: Vec<State<T>>,
}

/// Error of a rollout that ended early, with the states that it had recorded.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct RolloutFailure<T> {
    /// Reason of the end.
    pub error: RolloutError,
    /// Recorded states before the end.
    pub trajectory: Trajectory<T>,
}

/// Result of a rollout: the whole trajectory, or an error with the trajectory up to the error.
pub type RolloutResult<T = f64> = Result<Trajectory<T>, RolloutFailure<T>>;

impl<T: Scalar> Trajectory<T> {
    pub(super) fn starting_with(state: State<T>) -> Self {
        Self {
            states: vec![state],
        }
    }

    /// Trajectory of states of the same bodies, in the order of time.
    ///
    /// # Errors
    /// - If there is no state.
    /// - If the states have different numbers of bodies or of joints, or joints of different kinds.
    /// - If a state is earlier than the state before it.
    pub fn new(states: Vec<State<T>>) -> Result<Self, WorldError> {
        let first = states.first().ok_or(WorldError::NoState)?;
        let expected = first.bodies.len();
        for (state, pair) in (1..).zip(states.windows(2)) {
            let found = pair[1].bodies.len();
            if found != expected {
                return Err(WorldError::BodyCount {
                    state,
                    found,
                    expected,
                });
            }
            let kinds = |state: &State<T>| -> Vec<bool> {
                let joints = state.joints.iter();
                joints.map(|joint| joint.position().is_some()).collect()
            };
            if kinds(&pair[1]) != kinds(&pair[0]) {
                return Err(WorldError::TrajectoryJoints(state));
            }
            let [previous, time] = [pair[0].time, pair[1].time];
            if time < previous {
                return Err(WorldError::StateOrder {
                    state,
                    time,
                    previous,
                });
            }
        }
        Ok(Self { states })
    }

    pub(super) fn push(&mut self, state: State<T>) {
        self.states.push(state);
    }

    /// Mutable reference to a recorded state.
    pub(crate) fn state_mut(&mut self, record: usize) -> &mut State<T> {
        &mut self.states[record]
    }

    /// States. The first is the initial state.
    #[must_use]
    pub fn states(&self) -> &[State<T>] {
        &self.states
    }

    /// Last state.
    #[must_use]
    pub fn last(&self) -> &State<T> {
        &self.states[self.states.len() - 1]
    }

    /// Trajectory with the first state and every `every`th state after it.
    #[must_use]
    pub fn thinned(&self, every: usize) -> Self {
        let states = self.states.iter().step_by(every.max(1)).cloned().collect();
        Self { states }
    }

    /// Trajectory with a range of the states, which must not be empty.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        let states = self.states[range].to_vec();
        Self { states }
    }

    /// The trajectory without its derivatives.
    #[must_use]
    pub fn real(&self) -> Trajectory<f64> {
        Trajectory {
            states: self.states.iter().map(State::real).collect(),
        }
    }
}

impl Trajectory {
    /// The trajectory with zero derivatives.
    pub(crate) fn lifted<T: Scalar>(&self) -> Trajectory<T> {
        Trajectory {
            states: self.states.iter().map(State::lifted).collect(),
        }
    }
}
