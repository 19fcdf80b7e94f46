use crate::dynamics::{Force, State, Trajectory, World, WorldError};
use crate::scalar::{Scalar, lift};

/// What is read from a trajectory: a loss (one number), residuals, or a state.
///
/// Generic over the scalar, so that derivatives flow through it. Constants mix freely with a `T` on
/// its right (`x * 2.0`), and become vectors of `T` through
/// [`lift_vector`](crate::scalar::lift_vector).
///
/// ```
/// use hydroelastic::dynamics::Trajectory;
/// use hydroelastic::gradient::Outcome;
/// use hydroelastic::scalar::{Scalar, lift_vector};
/// use nalgebra::Vector3;
///
/// /// Squared distance (m²) of a body's last position from a target.
/// struct Miss {
///     body: usize,
///     target: Vector3<f64>,
/// }
///
/// impl Outcome for Miss {
///     fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
///         let position = trajectory.last().bodies[self.body].position();
///         let miss = position - lift_vector::<T>(&self.target);
///         vec![miss.dot(&miss)]
///     }
/// }
/// ```
pub trait Outcome: Sync {
    /// The numbers of interest: always as many, whatever the trajectory's values.
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T>;

    /// What one recorded state adds, of those at these times (s), if the outcome is a sum over them: then a gradient
    /// backwards of an outcome that looks at many states takes a time in proportion to their number, not to its square. None
    /// unless an outcome says so.
    fn share<T: Scalar>(&self, times: &[f64], record: usize, state: &State<T>) -> Option<Vec<T>> {
        let _ = (times, record, state);
        None
    }
}

/// What is added up along the way, as an effort or a distance from a path: see [`Integral`].
pub trait Integrand: Sync {
    /// Its value at a state (the unit of the integral over s).
    fn at<T: Scalar>(&self, state: &State<T>) -> T;
}

/// The integral of a rate over time, by the trapezoidal rule over the recorded states: one number.
///
/// ```
/// use hydroelastic::dynamics::State;
/// use hydroelastic::gradient::{Integrand, TimeIntegral};
/// use hydroelastic::scalar::Scalar;
///
/// /// Squared speed (m²/s²) of a body.
/// struct Haste(usize);
///
/// impl Integrand for Haste {
///     fn at<T: Scalar>(&self, state: &State<T>) -> T {
///         let velocity = state.bodies[self.0].velocity();
///         velocity.dot(velocity)
///     }
/// }
/// let outcome = TimeIntegral(Haste(0));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct TimeIntegral<R>(pub R);

impl<R: Integrand> Outcome for TimeIntegral<R> {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let states = trajectory.states();
        let times: Vec<f64> = states.iter().map(|state| state.time).collect();
        let mut sum = lift::<T>(0.0);
        for (record, state) in states.iter().enumerate() {
            sum += self.0.at(state) * weight(&times, record);
        }
        vec![sum]
    }

    fn share<T: Scalar>(&self, times: &[f64], record: usize, state: &State<T>) -> Option<Vec<T>> {
        Some(vec![self.0.at(state) * weight(times, record)])
    }
}

/// The time (s) that a record counts for: half of that to the one before it and to the one after it.
fn weight(times: &[f64], record: usize) -> f64 {
    let before = times[record.saturating_sub(1)];
    let after = times[(record + 1).min(times.len() - 1)];
    0.5 * (after - before)
}

/// A body's last position (m): 3 numbers.
#[derive(Debug, Clone, Copy)]
pub struct FinalPosition {
    body: usize,
}

/// A body's state at the end: 18 numbers, the position (m), the columns of the rotation matrix, the
/// velocity of the center of mass (m/s) and the spin (rad/s).
#[derive(Debug, Clone, Copy)]
pub struct FinalState {
    body: usize,
}

/// A body's states at all recorded times but the first, 18 numbers each, as in [`FinalState`].
#[derive(Debug, Clone, Copy)]
pub struct RecordedStates {
    body: usize,
}

impl FinalPosition {
    /// Of the named body.
    ///
    /// # Errors
    /// If there is none.
    pub fn of_body<F: Force>(world: &World<f64, F>, body: &str) -> Result<Self, WorldError> {
        let body = world.index_of(body)?;
        Ok(Self { body })
    }
}

impl Outcome for FinalPosition {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[self.body].position();
        position.iter().copied().collect()
    }
}

impl FinalState {
    /// Of the named body.
    ///
    /// # Errors
    /// If there is none.
    pub fn of_body<F: Force>(world: &World<f64, F>, body: &str) -> Result<Self, WorldError> {
        let body = world.index_of(body)?;
        Ok(Self { body })
    }
}

impl Outcome for FinalState {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        numbers(trajectory.last(), self.body).collect()
    }
}

impl RecordedStates {
    /// Of the named body.
    ///
    /// # Errors
    /// If there is none.
    pub fn of_body<F: Force>(world: &World<f64, F>, body: &str) -> Result<Self, WorldError> {
        let body = world.index_of(body)?;
        Ok(Self { body })
    }
}

impl Outcome for RecordedStates {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let recorded = trajectory.states()[1..].iter();
        recorded
            .flat_map(|state| numbers(state, self.body))
            .collect()
    }
}

/// The 18 numbers of a body's state.
pub(super) fn numbers<T: Scalar>(state: &State<T>, body: usize) -> impl Iterator<Item = T> {
    let body = &state.bodies[body];
    let pose = body.pose.translation().iter().chain(body.pose.rotation());
    let twist = body.twist.linear.iter().chain(&body.twist.angular);
    pose.chain(twist).copied()
}
