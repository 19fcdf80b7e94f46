/// Torques or target positions of an actuator as a function of time, with one value per interval.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Schedule<T = f64> {
    pub(super) interval: f64,
    pub(super) values: Vec<T>,
}

impl<T> Schedule<T> {
    /// Interval (s).
    #[must_use]
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Values: torques (N m or N) or target positions (rad or m).
    #[must_use]
    pub fn values(&self) -> &[T] {
        &self.values
    }

    pub(crate) fn value_mut(&mut self, index: usize) -> Option<&mut T> {
        self.values.get_mut(index)
    }

    pub(super) fn map<U>(&self, convert: impl Fn(&T) -> U) -> Schedule<U> {
        Schedule {
            interval: self.interval,
            values: self.values.iter().map(convert).collect(),
        }
    }

    /// Weights of linear interpolation at a time (s), with the indices of their values. The interpolant is constant before the first value
    /// and after the last value.
    pub(super) fn weights_at(&self, time: f64) -> [(usize, f64); 2] {
        let last = self.values.len().saturating_sub(1);
        let number = (time / self.interval).clamp(0.0, last as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the number is between 0 and the last index"
        )]
        let index = number.floor() as usize;
        let share = number - index as f64;
        [(index, 1.0 - share), ((index + 1).min(last), share)]
    }
}
