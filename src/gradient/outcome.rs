use crate::dynamics::{Force, State, Trajectory, World, WorldError};
use crate::scalar::{Scalar, lift};
use nalgebra::{DMatrix, DVector};

/// A function of the trajectory: a scalar loss, a residual vector, or a state.
///
/// An outcome is generic over the scalar, so that it can be evaluated on dual numbers. An `f64` constant can be the right operand
/// of a `T` (`x * 2.0`). [`lift_vector`](crate::scalar::lift_vector) converts vectors of constants to vectors of `T`.
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
    /// Numbers of the outcome. Their count must not depend on the values in the trajectory.
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T>;

    /// Contribution of the recorded state with index `record`, if the outcome is a sum over the recorded states. `times` (s) has
    /// one entry for each recorded state. The default is `None`.
    ///
    /// With this method, the time of a reverse-mode gradient is proportional to the number of states that the outcome reads, and
    /// not to its square.
    fn share<T: Scalar>(&self, times: &[f64], record: usize, state: &State<T>) -> Option<Vec<T>> {
        let _ = (times, record, state);
        None
    }
}

/// Integrand of a [`TimeIntegral`], such as an effort or a distance from a path.
pub trait Integrand: Sync {
    /// Value at a state (unit of the integral per s).
    fn at<T: Scalar>(&self, state: &State<T>) -> T;
}

/// Integral of an [`Integrand`] over time, by the trapezoidal rule over the recorded states: 1 number.
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

/// Weight (s) of a recorded state in the trapezoidal rule: half of the time from the previous to the next recorded state.
fn weight(times: &[f64], record: usize) -> f64 {
    let before = times[record.saturating_sub(1)];
    let after = times[(record + 1).min(times.len() - 1)];
    0.5 * (after - before)
}

/// Value and Jacobian of an outcome.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OutcomeJacobian {
    /// Value of the outcome.
    pub value: DVector<f64>,
    /// Jacobian of the outcome: a row for each outcome component, and a column for each parameter
    /// component, in their order. The unit is the unit of the outcome per unit of the parameter.
    pub jacobian: DMatrix<f64>,
}

/// Final position (m) of the origin of a body: 3 numbers.
#[derive(Debug, Clone, Copy)]
pub struct FinalPosition {
    body: usize,
}

/// Final state of a body: 18 numbers. They are the position (m), the columns of the rotation matrix, the velocity of the center of
/// mass (m/s) and the angular velocity (rad/s).
#[derive(Debug, Clone, Copy)]
pub struct FinalState {
    body: usize,
}

/// States of a body at all recorded times except the first, with 18 components each, as in [`FinalState`].
#[derive(Debug, Clone, Copy)]
pub struct RecordedStates {
    body: usize,
}

impl FinalPosition {
    /// Creates the outcome for the named body.
    ///
    /// # Errors
    /// If the world has no body of this name.
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
    /// Creates the outcome for the named body.
    ///
    /// # Errors
    /// If the world has no body of this name.
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
    /// Creates the outcome for the named body.
    ///
    /// # Errors
    /// If the world has no body of this name.
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

/// The 18 numbers of the state of a body, as in [`FinalState`].
pub(super) fn numbers<T: Scalar>(state: &State<T>, body: usize) -> impl Iterator<Item = T> {
    let body = &state.bodies[body];
    let pose = body.pose.translation().iter().chain(body.pose.rotation());
    let twist = body.twist.linear.iter().chain(&body.twist.angular);
    pose.chain(twist).copied()
}
