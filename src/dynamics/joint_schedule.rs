//! Schedules of joint torques and joint targets.

use super::force::{TimeSpan, shares_of};
use super::joint::{Joint, JointLaw};
use crate::scalar::{Scalar, lift};

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
    fn weights_at(&self, time: f64) -> [(usize, f64); 2] {
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

/// Contribution of one scheduled value to the actuator during a time step.
pub(super) struct ScheduleShare {
    pub index: usize,
    /// Weights of the value in the torque, in the target position at the start of the step, and in the target velocity.
    pub weights: [f64; 3],
}

impl<T> Joint<T> {
    /// Contributions of the scheduled torques during a time step.
    pub(super) fn torque_shares(&self, step: TimeSpan) -> impl Iterator<Item = ScheduleShare> {
        let shares = self
            .torques
            .iter()
            .flat_map(move |schedule| shares_of((schedule.interval, schedule.values.len()), step));
        shares.map(|(index, share)| ScheduleShare {
            index,
            weights: [share, 0.0, 0.0],
        })
    }

    /// Contributions of the scheduled targets during a time step. An index can occur several times.
    pub(super) fn target_shares(&self, step: TimeSpan) -> impl Iterator<Item = ScheduleShare> {
        let shares = self.targets.iter().flat_map(move |schedule| {
            let [from, until] = [step.from, step.until].map(|time| schedule.weights_at(time));
            let per_duration = (step.until - step.from).recip();
            let start = from.map(|(index, weight)| (index, [0.0, weight, -weight * per_duration]));
            let end = until.map(|(index, weight)| (index, [0.0, 0.0, weight * per_duration]));
            start.into_iter().chain(end)
        });
        shares.map(|(index, weights)| ScheduleShare { index, weights })
    }
}

impl<T: Scalar> Joint<T> {
    /// Law of the joint during a time step, with the scheduled torque and target.
    pub(super) fn law_during(&self, step: TimeSpan) -> JointLaw<T> {
        let mut law = self.law;
        let actuator = &mut law.actuator;
        if let Some(schedule) = &self.torques {
            for share in self.torque_shares(step) {
                actuator.torque += schedule.values[share.index] * share.weights[0];
            }
        }
        if let Some(schedule) = &self.targets {
            actuator.target_time = step.from;
            [actuator.target_position, actuator.target_velocity] = [lift(0.0); 2];
            for share in self.target_shares(step) {
                let value = schedule.values[share.index];
                actuator.target_position += value * share.weights[1];
                actuator.target_velocity += value * share.weights[2];
            }
        }
        law
    }
}
