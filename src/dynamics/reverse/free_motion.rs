//! A drift, backwards.

use super::StateCovector;
use crate::dynamics::inertia::{PrincipalInertia, scaled};
use crate::dynamics::{BodyState, Inertia};
use crate::spatial::{left_jacobian, rotation_from_vector, turned_about_own_axis};
use nalgebra::{Matrix3, Vector3};

impl Inertia {
    /// From the derivatives by the state of a free body after a time (s) to those by the state before it.
    pub(super) fn drifted_back(
        &self,
        before: &BodyState,
        after: &StateCovector,
        duration: f64,
    ) -> StateCovector {
        let (rotation, spin) = (before.pose.rotation(), &before.twist.angular);
        let (turned, _) = self.principal.turned_freely(rotation, spin, duration);
        let [arm_before, arm_after] = [rotation, &turned].map(|it| it * self.center_of_mass);
        let by_end = after.about(&arm_after);
        let by_rotation = [by_end.turn, by_end.spin];
        let [turn, spin] = self
            .principal
            .turned_back((rotation, spin), by_rotation, duration);
        let about_center = StateCovector {
            turn,
            spin,
            shift: after.shift,
            velocity: after.velocity + after.shift * duration,
        };
        about_center.about(&-arm_before)
    }
}

impl PrincipalInertia {
    /// From the derivatives by orientation (a turn in the axes of the world) and spin of a free body after a time (s) to
    /// those before it: the parts of [`Self::turned_freely`], the last first.
    ///
    /// A turn by φ about an axis q that turns with the body itself, φ = r q·ℓ, takes a small turn θ before it to
    /// θ + q r (q·δℓ + (q × ℓ)·θ) after it.
    fn turned_back(
        &self,
        (rotation, spin): (&Matrix3<f64>, &Vector3<f64>),
        [by_turn, by_spin]: [Vector3<f64>; 2],
        duration: f64,
    ) -> [Vector3<f64>; 2] {
        if self.is_sphere() {
            let vector = spin * duration;
            let by_vector = left_jacobian(&vector).tr_mul(&by_turn);
            let turn = rotation_from_vector(&vector).tr_mul(&by_turn);
            return [turn, by_spin + by_vector * duration];
        }
        let before = self.frame(rotation);
        let momentum = scaled(&before, &self.moments, spin);
        let per_moments = self.moments.map(f64::recip);
        let mut frame = before;
        let turns = [(0, 0.5), (2, 1.0), (0, 0.5)].map(|(axis, share)| {
            let rate = share * duration * (per_moments[axis] - per_moments[1]);
            let direction = frame.column(axis).into_owned();
            frame = turned_about_own_axis(&frame, axis, rate * direction.dot(&momentum));
            (direction, rate)
        });
        let steady = momentum * (per_moments[1] * duration);
        let steady_turn = rotation_from_vector(&steady);
        let after = steady_turn * frame;
        // The spin at the end, from the momentum.
        let spin_after = scaled(&after, &per_moments, &momentum);
        let mut by_momentum = scaled(&after, &per_moments, &by_spin);
        let mut turn = by_turn + spin_after.cross(&by_spin) - momentum.cross(&by_momentum);
        // The steady turn.
        by_momentum += left_jacobian(&steady).tr_mul(&turn) * (per_moments[1] * duration);
        turn = steady_turn.tr_mul(&turn);
        for (direction, rate) in turns.into_iter().rev() {
            let by_angle = rate * direction.dot(&turn);
            by_momentum += direction * by_angle;
            turn += direction.cross(&momentum) * by_angle;
        }
        // The momentum, from the spin at the start.
        let spin_before = scaled(&before, &self.moments, &by_momentum);
        turn += momentum.cross(&by_momentum) - spin.cross(&spin_before);
        [turn, spin_before]
    }
}
