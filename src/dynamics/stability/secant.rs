//! A cheap test of every explicit step, from the contact wrenches of two kicks: whether the step may be too long.

use crate::dynamics::{Body, BodyState};
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Secants below this need no exact check. At 1, half of the largest stable step, an impact lasts about three kicks; a longer
/// one may turn a body around in a single kick, which shows as a secant above 1.
const LARGEST_SECANT: f64 = 1.0;

/// Changes of a wrench below this fraction of it are not looked at: at rest they are round-off. An unstable mode grows through it.
const ROUND_OFF: f64 = 1e-6;

impl<T: Scalar> Body<T> {
    /// Whether contact with the body begins, or changes so fast that the time step (s) may be too long for it. The wrenches are
    /// those of the last kick and of this one, about the centre of mass; the state is that between them.
    ///
    /// With the change ΔW of the wrench and the velocities v that led to it, h ΔW·M⁻¹ΔW/|ΔW·v| is a Rayleigh quotient of
    /// h²K: for elastic contact with a body at rest a lower bound of its largest eigenvalue, which it approaches as an unstable
    /// mode grows.
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
