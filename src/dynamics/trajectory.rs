use super::{RolloutError, State, WorldError};
use crate::scalar::Scalar;

/// Recorded states in the order of time.
#[derive(Debug, Clone)]
pub struct Trajectory<T = f64> {
    states: Vec<State<T>>,
}

/// A rollout that ended early, with what it had recorded.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct RolloutFailure<T> {
    /// Why it ended.
    pub error: RolloutError,
    /// The states before that.
    pub trajectory: Trajectory<T>,
}

/// What a rollout has recorded: all it should, or an error with what there was before.
pub type RolloutResult<T = f64> = Result<Trajectory<T>, RolloutFailure<T>>;

impl<T: Scalar> Trajectory<T> {
    pub(super) fn starting_with(state: State<T>) -> Self {
        Self {
            states: vec![state],
        }
    }

    /// From states of the same bodies in the order of time.
    ///
    /// # Errors
    /// If there is no state, one has more or fewer bodies than the first, or is earlier than the one before it.
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

    /// A state, to be changed.
    pub(crate) fn state_mut(&mut self, record: usize) -> &mut State<T> {
        &mut self.states[record]
    }

    /// The states; the first is the initial one.
    #[must_use]
    pub fn states(&self) -> &[State<T>] {
        &self.states
    }

    /// The last state.
    #[must_use]
    pub fn last(&self) -> &State<T> {
        &self.states[self.states.len() - 1]
    }

    /// Every `every`th state, from the first.
    #[must_use]
    pub fn thinned(&self, every: usize) -> Self {
        let states = self.states.iter().step_by(every.max(1)).cloned().collect();
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
    /// The constant trajectory.
    pub(crate) fn lifted<T: Scalar>(&self) -> Trajectory<T> {
        Trajectory {
            states: self.states.iter().map(State::lifted).collect(),
        }
    }
}
