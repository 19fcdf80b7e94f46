use crate::dynamics::WorldError;
use crate::dynamics::validate::{check_finite, check_positive};
use crate::scalar::{Scalar, lift};
use crate::spatial::Wrench;

/// Shares of a time step below this value are rounding errors, because intervals usually end where steps end.
const NEGLIGIBLE_SHARE: f64 = 1e-6;

/// A time step, from its start to its end (s).
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) struct TimeSpan {
    pub from: f64,
    pub until: f64,
}

/// A wrench on a body that is constant over intervals of time. Its numbers are parameters
/// ([`Parameter::Control`](crate::gradient::Parameter::Control)).
///
/// Interval k begins at k times the duration of an interval and ends at k + 1 times this duration.
/// No wrench acts before time 0 or after the last interval. The mean wrench over a time step acts
/// during the whole step.
///
/// ```
/// use hydroelastic::dynamics::Control;
/// use hydroelastic::spatial::Wrench;
/// use nalgebra::vector;
///
/// let push = Wrench { force: vector![1.0, 0.0, 0.0], ..Wrench::zero() };
/// let control = Control::new("block", 0.1, vec![push, Wrench::zero(), push])?; // 0.3 s
/// assert_eq!(control.wrench_at(0.25).force.x, 1.0);
/// # Ok::<(), hydroelastic::dynamics::WorldError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Control<T = f64> {
    body: String,
    interval: f64,
    wrenches: Vec<Wrench<T>>,
}

impl TimeSpan {
    /// Creates a time span from its start and its duration (s).
    pub fn new(from: f64, duration: f64) -> Self {
        Self {
            from,
            until: from + duration,
        }
    }

    /// Duration (s).
    pub fn duration(&self) -> f64 {
        self.until - self.from
    }
}

impl Control {
    /// Control of the body with this name. `interval` is the duration (s) of an interval. `wrenches` has the wrench of each interval, about
    /// the center of mass, in world axes.
    ///
    /// # Errors
    /// If the duration is not positive and finite, or a wrench is not finite.
    pub fn new(body: &str, interval: f64, wrenches: Vec<Wrench>) -> Result<Self, WorldError> {
        check_positive("interval of a control", interval)?;
        let control = Self {
            body: body.to_owned(),
            interval,
            wrenches,
        };
        control.check()?;
        Ok(control)
    }

    /// Checks that all wrenches are finite.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let numbers = |wrench: &Wrench| wrench.to_vector();
        let mut wrenches = self.wrenches.iter().map(numbers);
        wrenches.try_for_each(|wrench| check_finite("wrench of a control", wrench.as_slice()))
    }

    /// The control with zero derivatives.
    pub(in crate::dynamics) fn lifted<T: Scalar>(&self) -> Control<T> {
        let lifted = |wrench: &Wrench| Wrench::from_vector(&wrench.to_vector().map(lift::<T>));
        Control {
            body: self.body.clone(),
            interval: self.interval,
            wrenches: self.wrenches.iter().map(lifted).collect(),
        }
    }
}

impl<T: Scalar> Control<T> {
    /// The control without derivatives.
    pub(in crate::dynamics) fn real(&self) -> Control {
        Control {
            body: self.body.clone(),
            interval: self.interval,
            wrenches: self.wrenches.iter().map(Wrench::real).collect(),
        }
    }

    /// Name of the body.
    #[must_use]
    pub fn body(&self) -> &str {
        &self.body
    }

    /// Duration (s) of an interval.
    #[must_use]
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Wrench of each interval.
    #[must_use]
    pub fn wrenches(&self) -> &[Wrench<T>] {
        &self.wrenches
    }

    /// Wrench at a time (s).
    #[must_use]
    pub fn wrench_at(&self, time: f64) -> Wrench<T> {
        let wrench = self.wrenches.get(interval_at(time, self.interval));
        let wrench = wrench.filter(|_| time >= 0.0);
        wrench.copied().unwrap_or_else(Wrench::zero)
    }

    /// Mean wrench over a time step.
    pub(in crate::dynamics) fn mean_over(&self, step: TimeSpan) -> Wrench<T> {
        let mut mean = Wrench::zero();
        for (interval, share) in self.shares_of(step) {
            let wrench = self.wrenches[interval].to_vector();
            mean += Wrench::from_vector(&wrench.map(|number| number * share));
        }
        mean
    }

    /// Intervals that overlap with a time step, each with its share of the step.
    pub(in crate::dynamics) fn shares_of(
        &self,
        step: TimeSpan,
    ) -> impl Iterator<Item = (usize, f64)> {
        shares_of((self.interval, self.wrenches.len()), step)
    }

    /// Mutable reference to the wrench of an interval.
    pub(crate) fn wrench_mut(&mut self, interval: usize) -> Option<&mut Wrench<T>> {
        self.wrenches.get_mut(interval)
    }
}

/// Intervals that overlap with a time step, each with its share of the step. `interval` is the duration of an interval (s).
pub(in crate::dynamics) fn shares_of(
    (interval, count): (f64, usize),
    step: TimeSpan,
) -> impl Iterator<Item = (usize, f64)> {
    let [first, last] = [step.from, step.until].map(|time| interval_at(time, interval));
    let share = move |index: usize| {
        let from = step.from.max(index as f64 * interval);
        let until = step.until.min((index + 1) as f64 * interval);
        (until - from) / (step.until - step.from)
    };
    let overlapping = first..last.saturating_add(1).min(count);
    overlapping.filter_map(move |index| match share(index) {
        share if share < NEGLIGIBLE_SHARE => None,
        share if share > 1.0 - NEGLIGIBLE_SHARE => Some((index, 1.0)),
        share => Some((index, share)),
    })
}

/// Index of the interval that contains a time (s). Negative times give the first interval.
fn interval_at(time: f64, interval: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "negative times give 0, and a time above the largest usize is after the last interval"
    )]
    let index = (time / interval).floor() as usize;
    index
}
