use crate::dynamics::WorldError;
use crate::dynamics::settings::{check_finite, check_positive};
use crate::scalar::{Scalar, lift};
use crate::spatial::Wrench;

/// A wrench on a body that is constant over intervals of time, to be chosen: its numbers are parameters
/// ([`Parameter::Control`](crate::gradient::Parameter::Control)).
///
/// Interval k lasts from k times the interval's duration to k + 1 times it. Over a time step acts the wrench of the interval
/// that the middle of the step is in, so an interval should be a whole number of steps; after the last interval, and before
/// time 0, none does.
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

impl Control {
    /// On the body of a name: the duration (s) of an interval, and the wrench of each, about the centre of mass, in world
    /// axes.
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

    /// The constant control.
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

    /// The wrench of each interval.
    #[must_use]
    pub fn wrenches(&self) -> &[Wrench<T>] {
        &self.wrenches
    }

    /// The wrench at a time (s).
    #[must_use]
    pub fn wrench_at(&self, time: f64) -> Wrench<T> {
        let interval = self.interval_at(time);
        let wrench = interval.and_then(|interval| self.wrenches.get(interval));
        wrench.copied().unwrap_or_else(Wrench::zero)
    }

    /// The interval that a time (s) is in, from 0 on, if it is not before the first.
    pub(in crate::dynamics) fn interval_at(&self, time: f64) -> Option<usize> {
        let interval = (time / self.interval).floor();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "an interval beyond what a usize counts is after the last one"
        )]
        let interval = (interval >= 0.0).then_some(interval as usize);
        interval
    }

    /// The wrench of an interval, to be changed.
    pub(crate) fn wrench_mut(&mut self, interval: usize) -> Option<&mut Wrench<T>> {
        self.wrenches.get_mut(interval)
    }
}
