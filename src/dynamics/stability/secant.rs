//! A cheap test whether an explicit step may be too long, from the contact wrenches of two kicks.

use crate::dynamics::{Body, BodyState};
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Secants below this need no exact check. A secant of 1 corresponds to half of the largest stable step, at which an impact lasts
/// about three kicks. A longer step may turn a body around in a single kick, and then has a secant above 1.
const LARGEST_SECANT: f64 = 1.0;

/// Changes of a wrench below this fraction of the wrench are ignored, because they are round-off at rest. An unstable mode grows
/// beyond this fraction.
const ROUND_OFF: f64 = 1e-6;

impl<T: Scalar> Body<T> {
    /// Whether contact with the body begins, or changes so fast that the time step (s) may be too long. The wrenches are the contact
    /// wrenches of the last kick and of this kick, about the center of mass. The state is the state between the two kicks.
    ///
    /// With the change ΔW of the wrench and the velocities v that led to this change, h ΔW·M⁻¹ΔW/|ΔW·v| is a Rayleigh quotient of
    /// h²K. For elastic contact with a body at rest the quotient is a lower bound of the largest eigenvalue, and approaches this
    /// eigenvalue as an unstable mode grows.
    pub(in crate::dynamics) fn may_exceed_limit(
        &self,
        state: &BodyState<T>,
        [last, now]: [&Wrench<T>; 2],
        time_step: f64,
    ) -> bool {
        let Some(inertia) = self.inertia() else {
            return false;
        };
        let [last, now] = [last, now].map(|wrench| wrench.real().to_vector());
        let change = now - last;
        if change.amax() == 0.0 || last.amax() == 0.0 {
            return change.amax() > 0.0;
        }
        let (inertia, state) = (inertia.real(), state.real());
        let kick = |wrench| inertia.velocities(state.pose.rotation(), wrench) * time_step;
        let (of_change, of_all) = (change.dot(&kick(&change)), now.dot(&kick(&now)));
        let along = change.dot(&state.twist.to_vector()).abs();
        of_change > LARGEST_SECANT * along && of_change > ROUND_OFF * ROUND_OFF * of_all
    }
}
