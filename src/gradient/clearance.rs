//! Outcomes of a rollout that depend on the clearance between two bodies.

use super::{Experiment, GradientError, Outcome, Parameter};
use crate::dynamics::{Approach, Force, PairClearance, State, Trajectory, World, WorldError};
use crate::scalar::{Scalar, lift};
use nalgebra::DVector;

/// Clearance (m) of two bodies at the last state, or the least clearance at the recorded states ([`Self::least`]). The outcome is one number.
/// It has derivatives also if the bodies never touch.
///
/// [`ContactPair::clearance`](crate::contact::ContactPair::clearance) defines the clearance. The shapes and moduli of the bodies are
/// constants of the outcome. Derivatives with respect to them contain only their effect on the motion.
#[derive(Debug, Clone)]
pub struct RolloutClearance {
    pair: PairClearance,
    is_least: bool,
}

/// First contact of two bodies in a rollout, with derivatives: see [`Experiment::first_contact`].
#[derive(Debug, Clone, PartialEq)]
pub enum FirstContact {
    /// The bodies touch.
    Touching {
        /// Time (s) of the first contact.
        time: f64,
        /// Derivatives of the time with respect to the parameters.
        gradient: DVector<f64>,
    },
    /// The bodies are apart at all recorded states.
    Apart {
        /// Least clearance (m) at the recorded states.
        least_clearance: f64,
        /// Time (s) of the state with the least clearance.
        time: f64,
        /// Derivatives of the least clearance with respect to the parameters.
        gradient: DVector<f64>,
    },
}

/// Time (s) of the first contact, or the least clearance (m) if the bodies are apart: 1 number.
struct TimeOrClearance<'p>(&'p PairClearance);

impl RolloutClearance {
    /// Creates the clearance at the last state for two named bodies, of which at least one is compliant with a mesh.
    ///
    /// # Errors
    /// - If one of the names is unknown, or both are the same.
    /// - If neither body is compliant with a mesh, or one has no shape.
    pub fn between<F: Force>(
        world: &World<f64, F>,
        first: &str,
        second: &str,
    ) -> Result<Self, WorldError> {
        Ok(Self {
            pair: PairClearance::between(&world.model, [first, second])?,
            is_least: false,
        })
    }

    /// Selects the least clearance at the recorded states. It is continuous. It has a kink where another recorded state becomes the state
    /// with the least clearance.
    #[must_use]
    pub fn least(self) -> Self {
        Self {
            is_least: true,
            ..self
        }
    }
}

impl Outcome for RolloutClearance {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        vec![if self.is_least {
            self.pair.least(trajectory).0
        } else {
            self.pair.at(trajectory.last()).distance
        }]
    }

    fn share<T: Scalar>(&self, times: &[f64], record: usize, state: &State<T>) -> Option<Vec<T>> {
        if self.is_least {
            return None;
        }
        let is_last = record + 1 == times.len();
        Some(vec![if is_last {
            self.pair.at(state).distance
        } else {
            lift(0.0)
        }])
    }
}

impl Outcome for TimeOrClearance<'_> {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        match self.0.approach(trajectory) {
            Approach::Touching(number) | Approach::Apart(number, _) => vec![number],
        }
    }
}

impl Experiment {
    /// Computes the time of the first contact of two named bodies, or their least clearance if they stay apart, with derivatives.
    ///
    /// The clearance at the recorded states gives the interval of the first contact. In this interval, poses are cubic polynomials of time
    /// that interpolate the poses and twists at both ends. The time is the root of the clearance. Its derivative follows from the implicit
    /// function theorem: minus the derivative of the clearance, divided by the rate of the clearance. Shapes, moduli and centers of mass
    /// are constants, as in [`RolloutClearance`].
    ///
    /// The time is smooth as long as the touching features stay the same. It has a kink where the features change. It jumps, and its
    /// derivative becomes infinite, where a contact is grazing. If the bodies overlap at the start, the time is the start time, and its
    /// derivatives are zero. Contacts that begin and end between two recorded states are not found. The cost is one rollout and one
    /// gradient.
    ///
    /// # Errors
    /// - If one of the names is unknown, or both are the same.
    /// - If neither body is compliant with a mesh, or one has no shape.
    /// - In the cases of [`Self::gradient`]. For example, the derivative at a grazing contact is not finite.
    pub fn first_contact(
        &self,
        parameters: &[Parameter],
        bodies: [&str; 2],
    ) -> Result<FirstContact, GradientError> {
        let pair = PairClearance::between(self.model(), bodies)?;
        let trajectory = self.trajectory()?;
        let (number, gradient) = self.gradient(parameters, &TimeOrClearance(&pair))?;
        Ok(match pair.approach(&trajectory) {
            Approach::Touching(_) => FirstContact::Touching {
                time: number,
                gradient,
            },
            Approach::Apart(_, record) => FirstContact::Apart {
                least_clearance: number,
                time: trajectory.states()[record].time,
                gradient,
            },
        })
    }
}
