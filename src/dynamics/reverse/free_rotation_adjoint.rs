//! Adjoint of a drift.

use super::BodyStateGradient;
use super::gradients::BodyGradient;
use crate::dynamics::inertia::{PrincipalInertia, scaled};
use crate::dynamics::{BodyState, Inertia};
use crate::spatial::{left_jacobian, rotation_from_vector, turned_about_own_axis};
use nalgebra::{Matrix3, Vector3};

/// Relative tolerance below which principal values count as equal. Equal values have no distinct axes, so the derivative with respect to a
/// change of the axes is the limit for equal values.
const EQUAL: f64 = 1e-6;

/// Gradient with respect to the rotation of a free body. The parts are the gradients with respect
/// to a turn in world axes, to the spin, and to the inertia per mass in the axes of the body frame.
struct RotationGradient {
    turn: Vector3<f64>,
    spin: Vector3<f64>,
    inertia: Matrix3<f64>,
}

/// Turn about a principal axis.
struct AxisTurn {
    /// Principal axes in the world before the turn.
    frame: Matrix3<f64>,
    axis: usize,
    /// Duration of the turn (s).
    time: f64,
}

impl Inertia {
    /// Propagates the gradient with respect to the state of a free body after a time (s) to the state before it. Adds the gradient with
    /// respect to the inertia and to the center of mass to `gradient`.
    pub(super) fn drifted_back(
        &self,
        before: &BodyState,
        after: &BodyStateGradient,
        duration: f64,
        gradient: &mut BodyGradient,
    ) -> BodyStateGradient {
        let (rotation, spin) = (before.pose.rotation(), &before.twist.angular);
        let (turned, _) = self.principal.turned_freely(rotation, spin, duration);
        let [arm_before, arm_after] =
            [rotation, &turned].map(|rotation| rotation * self.center_of_mass);
        let by_end = after.about(&arm_after);
        gradient.center += rotation.tr_mul(&after.shift) - turned.tr_mul(&after.shift);
        let by_rotation = [by_end.turn, by_end.spin];
        let before = (rotation, spin);
        let RotationGradient {
            turn,
            spin,
            inertia,
        } = self.principal.turned_back(before, by_rotation, duration);
        gradient.inertia += inertia;
        let about_center = BodyStateGradient {
            turn,
            spin,
            shift: after.shift,
            velocity: after.velocity + after.shift * duration,
        };
        about_center.about(&-arm_before)
    }
}

impl PrincipalInertia {
    /// Propagates the gradient with respect to orientation (a turn in world axes) and spin of a free body after a time (s) to the state
    /// before it. It reverses the parts of [`Self::turned_freely`], the last part first.
    ///
    /// Consider a turn by φ = r q·ℓ about an axis q that turns with the body. It changes a small turn θ before it to θ + q r (q·δℓ + (q ×
    /// ℓ)·θ) after it.
    fn turned_back(
        &self,
        (rotation, spin): (&Matrix3<f64>, &Vector3<f64>),
        [by_turn, by_spin]: [Vector3<f64>; 2],
        duration: f64,
    ) -> RotationGradient {
        let before = self.frame(rotation);
        let momentum = scaled(&before, &self.moments, spin);
        let per_moments = self.moments.map(f64::recip);
        let mut frame = before;
        let turns = [(0, 0.5), (2, 1.0), (0, 0.5)].map(|(axis, share)| {
            let turn = AxisTurn {
                frame,
                axis,
                time: share * duration,
            };
            let angle = turn.rate(&per_moments) * frame.column(axis).dot(&momentum);
            frame = turned_about_own_axis(&frame, axis, angle);
            turn
        });
        let steady = momentum * (per_moments[1] * duration);
        let steady_turn = rotation_from_vector(&steady);
        let after = steady_turn * frame;
        // Reverse the spin at the end, which follows from the momentum.
        let spin_after = scaled(&after, &per_moments, &momentum);
        let mut by_momentum = scaled(&after, &per_moments, &by_spin);
        let mut turn = by_turn + spin_after.cross(&by_spin) - momentum.cross(&by_momentum);
        let mut by_inverse = symmetric(&after.tr_mul(&by_spin), &after.tr_mul(&momentum));
        // Reverse the steady turn.
        let by_axes_after = after.tr_mul(&turn);
        by_inverse[(1, 1)] += duration * momentum.dot(&turn);
        by_momentum += left_jacobian(&steady).tr_mul(&turn) * (per_moments[1] * duration);
        turn = steady_turn.tr_mul(&turn);
        let mut by_tilts = Matrix3::zeros();
        for axis_turn in turns.iter().rev() {
            let direction = axis_turn.frame.column(axis_turn.axis).into_owned();
            axis_turn.add_by_inverse(&momentum, &turn, [&mut by_inverse, &mut by_tilts]);
            let by_angle = axis_turn.rate(&per_moments) * direction.dot(&turn);
            by_momentum += direction * by_angle;
            turn += direction.cross(&momentum) * by_angle;
        }
        let by_axes = before.tr_mul(&turn) - by_axes_after;
        add_by_axes(&mut by_inverse, &by_axes, &per_moments, &by_tilts);
        // Reverse the momentum, which follows from the spin at the start.
        let spin_before = scaled(&before, &self.moments, &by_momentum);
        turn += momentum.cross(&by_momentum) - spin.cross(&spin_before);
        let by_moments = symmetric(&before.tr_mul(&by_momentum), &before.tr_mul(spin));
        let inverse = Matrix3::from_diagonal(&per_moments);
        let by_inertia = by_moments - inverse * by_inverse * inverse;
        RotationGradient {
            turn,
            spin: spin_before,
            inertia: self.axes * by_inertia * self.axes.transpose(),
        }
    }

    /// Gradient with respect to the inertia per mass, in the axes of the body frame, through the
    /// momentum per mass of a spin. The spin and the gradient with respect to the momentum are in
    /// world axes.
    pub(super) fn by_inertia_in_momentum(
        &self,
        rotation: &Matrix3<f64>,
        by_momentum: &Vector3<f64>,
        spin: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let frame = self.frame(rotation);
        let by_moments = symmetric(&frame.tr_mul(by_momentum), &frame.tr_mul(spin));
        self.axes * by_moments * self.axes.transpose()
    }

    /// Gradient with respect to the inertia per mass, in the axes of the body frame, through the
    /// change of spin by an impulse. The impulse is a torque per mass, times a time (s). The
    /// impulse and the gradient with respect to the spin are in world axes.
    pub(super) fn by_inertia_in_kick(
        &self,
        rotation: &Matrix3<f64>,
        by_spin: &Vector3<f64>,
        impulse: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let frame = self.frame(rotation);
        let by_inverse = symmetric(&frame.tr_mul(by_spin), &frame.tr_mul(impulse));
        let inverse = Matrix3::from_diagonal(&self.moments.map(f64::recip));
        -(self.axes * (inverse * by_inverse * inverse) * self.axes.transpose())
    }
}

impl AxisTurn {
    /// Angle divided by the momentum along the axis.
    fn rate(&self, per_moments: &Vector3<f64>) -> f64 {
        self.time * (per_moments[self.axis] - per_moments[1])
    }

    /// Adds the gradient with respect to the inverse inertia in its principal axes. `by_inverse` receives the part of the principal values.
    /// `by_tilts` receives the part of the tilt of an axis, which is used if two principal values are equal.
    fn add_by_inverse(
        &self,
        momentum: &Vector3<f64>,
        by_turn: &Vector3<f64>,
        [by_inverse, by_tilts]: [&mut Matrix3<f64>; 2],
    ) {
        let by_all =
            symmetric(&self.frame.tr_mul(by_turn), &self.frame.tr_mul(momentum)) * self.time;
        let along = by_all[(self.axis, self.axis)];
        by_inverse[(self.axis, self.axis)] += along;
        by_inverse[(1, 1)] -= along;
        by_tilts[(self.axis, 1)] += by_all[(self.axis, 1)];
        // If all principal values are equal, the turns about two axes each last the whole time. The pair of the first and the last axis
        // therefore counts once.
        if self.axis == 2 {
            by_tilts[(0, 2)] += by_all[(0, 2)];
        }
    }
}

/// Adds the gradient with respect to the off-diagonal entries of the inverse inertia in its principal axes. It follows from the gradient
/// with respect to a turn of all axes in the body, or from the limit if two principal values are equal.
fn add_by_axes(
    by_inverse: &mut Matrix3<f64>,
    by_axes: &Vector3<f64>,
    values: &Vector3<f64>,
    by_tilts: &Matrix3<f64>,
) {
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        let axis = 3 - a - b;
        let gap = values[a] - values[b];
        let entry = if gap.abs() > EQUAL * values[a] {
            0.5 * by_axes[axis] / gap
        } else {
            by_tilts[(a, b)] + by_tilts[(b, a)]
        };
        by_inverse[(a, b)] += entry;
        by_inverse[(b, a)] += entry;
    }
}

/// Symmetric part of a bᵀ.
fn symmetric(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let product = a * b.transpose();
    (product + product.transpose()) * 0.5
}
