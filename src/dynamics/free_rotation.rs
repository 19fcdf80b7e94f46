//! Rotation of a free body, by a splitting that is continuous in the moments of inertia. The
//! rotation of a sphere is computed directly.

use super::inertia::{PrincipalInertia, scaled, scaled_beyond};
use crate::scalar::{DenseDual, Order, Scalar, change, lift, real_part};
use crate::spatial::{turn_from_real, turned_about_own_axis, turned_by, turned_real};
use nalgebra::{Matrix3, Vector3};
use std::array;

/// Dual number with the derivatives with respect to a turn and a change of the spin.
type Inner = DenseDual<6>;

impl PrincipalInertia {
    /// Orientation and spin (rad/s, world axes) of a free body after a time (s).
    ///
    /// Let M₂ be the middle moment, ℓ the momentum, and d = 1/M − 1/M₂. The energy is the sum of
    /// d₁ℓ₁²/2 + d₃ℓ₃²/2 and of the energy of a sphere with the moment M₂. This sphere turns
    /// steadily about ℓ. One step turns the body about axis 1 for half the time, about axis 3 for
    /// the whole time, and about axis 1 for half the time. It then adds the steady turn, which
    /// commutes with these turns. The step is symplectic, symmetric and of second order, and keeps
    /// the momentum. It is exact for spheres and symmetric tops.
    pub fn turned_freely<T: Scalar>(
        &self,
        rotation: &Matrix3<T>,
        spin: &Vector3<T>,
        duration: f64,
    ) -> (Matrix3<T>, Vector3<T>) {
        if self.is_sphere() {
            // A sphere does not turn about its axes, and its spin is constant.
            return (
                turned_by(rotation, &spin.map(|rate| rate * duration)),
                *spin,
            );
        }
        if Order::<T>::IS_FIRST && size_of::<T>() > size_of::<Inner>() {
            return self.turned_by_chain_rule(rotation, spin, duration);
        }
        let before = self.frame(rotation);
        let momentum = scaled(&before, &self.moments, spin);
        let per_moments = self.moments.map(f64::recip);
        let mut frame = before;
        for (axis, share) in [(0, 0.5), (2, 1.0), (0, 0.5)] {
            let rate = share * duration * (per_moments[axis] - per_moments[1]);
            let along: T = frame.column(axis).dot(&momentum);
            frame = turned_about_own_axis(&frame, axis, along * rate);
        }
        let steady = momentum.map(|component| component * (per_moments[1] * duration));
        let after = turned_by(&frame, &steady);
        let faster = scaled_beyond(&after, &per_moments, &momentum)
            - scaled_beyond(&before, &per_moments, &momentum);
        (self.rotation_of(&after), spin + faster)
    }

    /// [`Self::turned_freely`] for first-order numbers with many derivatives. The result depends on its inputs through six numbers, so the
    /// chain rule over six derivatives is cheaper.
    fn turned_by_chain_rule<T: Scalar>(
        &self,
        rotation: &Matrix3<T>,
        spin: &Vector3<T>,
        duration: f64,
    ) -> (Matrix3<T>, Vector3<T>) {
        let by = |value, index| Inner::variable(value, index);
        let turn = Vector3::from_fn(|i, _| by(0.0, i));
        let inner_rotation = turned_real(&rotation.map(real_part), &turn);
        let inner_spin = Vector3::from_fn(|i, _| by(real_part(spin[i]), 3 + i));
        let (turned, spin_after) = self.turned_freely(&inner_rotation, &inner_spin, duration);
        let (turn, faster) = (turn_from_real(rotation), spin.map(change));
        let changes: [T; 6] = array::from_fn(|i| if i < 3 { turn[i] } else { faster[i - 3] });
        let chained = |inner: Inner| {
            let terms = changes.iter().zip(inner.eps);
            terms.fold(lift::<T>(inner.re), |sum, (change, slope)| {
                sum + *change * slope
            })
        };
        let turn = turn_from_real(&turned).map(chained);
        let rotation = turned_real(&turned.map(real_part), &turn);
        (rotation, spin_after.map(chained))
    }
}
