use crate::dynamics::Trajectory;

/// Recorded motion of the bodies of a world.
///
/// The rollout of a measurement begins at the first state, whose velocities count too. Of the later states, only the poses of the
/// observed bodies count. Times may have gaps, but are multiples of the time step of the plan after the first time.
#[derive(Debug, Clone)]
pub struct Measurement {
    name: String,
    trajectory: Trajectory,
}

impl Measurement {
    /// Measurement with a name, for messages, and with states of all bodies of the world. States of fixed bodies are ignored.
    #[must_use]
    pub fn new(name: impl Into<String>, trajectory: Trajectory) -> Self {
        Self {
            name: name.into(),
            trajectory,
        }
    }

    /// Name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Recorded states.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// Beginning of the measurement with this duration (s), and at least one state after the first.
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

    /// Divides the measurement into windows of at most `states` states (at least 2) for multiple shooting. The last state of a window
    /// is the first state of the next. Each window begins at its measured state.
    #[must_use]
    pub fn windows(&self, states: usize) -> Vec<Self> {
        let all = self.trajectory.states();
        let stride = states.max(2) - 1;
        let starts = (0..all.len().saturating_sub(1)).step_by(stride);
        let window = |start: usize| {
            let part = self.part(start, all.len().min(start + stride + 1));
            Self::new(format!("{}, state {start}", self.name), part.trajectory)
        };
        starts.map(window).collect()
    }
}
