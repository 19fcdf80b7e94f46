use crate::dynamics::Trajectory;

/// Recorded motion of the bodies of a world.
///
/// The rollout of a measurement begins at the first state, including its velocities. The fit compares the later states by the poses of
/// the observed bodies only. Poses and velocities are in the world frame, as in [`State`](crate::dynamics::State). Frames may be
/// missing, but the time after the first state must be a multiple of the plan's time step, to a thousandth of the step.
#[derive(Debug, Clone)]
pub struct Measurement {
    name: String,
    trajectory: Trajectory,
}

impl Measurement {
    /// Creates a measurement with a name, for messages, and with states of all bodies of the world. States of fixed bodies are ignored.
    #[must_use]
    pub fn new(name: impl Into<String>, trajectory: Trajectory) -> Self {
        Self {
            name: name.into(),
            trajectory,
        }
    }

    /// Returns the name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the recorded states.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// Returns the states within a duration (s) of the first state, and at least two states if there are two.
    #[must_use]
    pub fn beginning(&self, duration: f64) -> Self {
        let all = self.trajectory.states();
        let end = all[0].time + duration;
        let count = all.iter().take_while(|state| state.time <= end).count();
        self.part(0, count.max(2).min(all.len()))
    }

    /// States from one index to another, which is excluded.
    fn part(&self, start: usize, end: usize) -> Self {
        Self {
            name: self.name.clone(),
            trajectory: self.trajectory.part(start..end),
        }
    }

    /// Divides the measurement into windows of at most `state_count` states (at least 2) for multiple shooting. The last state of a
    /// window is the first state of the next. Each window begins at its measured state, whose velocities must be measured too.
    #[must_use]
    pub fn windows(&self, state_count: usize) -> Vec<Self> {
        let all = self.trajectory.states();
        let stride = state_count.max(2) - 1;
        let starts = (0..all.len().saturating_sub(1)).step_by(stride);
        let window = |start: usize| {
            let part = self.part(start, all.len().min(start + stride + 1));
            Self::new(format!("{}, state {start}", self.name), part.trajectory)
        };
        starts.map(window).collect()
    }
}
