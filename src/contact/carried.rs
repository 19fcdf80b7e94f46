use super::jacobian::RelativeJacobian;
use super::{ContactBody, ContactPair, ContactWrench};
use crate::scalar::{Scalar, lift, lift_vector, real_part, real_vector};
use crate::spatial::{Pose, Wrench};
use nalgebra::{Matrix3, Vector3};

impl<T: Scalar> ContactPair<'_, T> {
    /// [`Self::wrench`] with first derivatives from the closed form: the contact is evaluated once in
    /// `f64` with its Jacobian, which the chain rule carries into however many derivatives `T` has.
    ///
    /// Faster than the generic pipeline, and right also where edges of polygons coincide. For a `T`
    /// of second or higher order, and for `f64`, it is [`Self::wrench`].
    #[must_use]
    pub fn wrench_carried(&self) -> ContactWrench<T> {
        if T::NDERIV != 1 {
            return self.wrench();
        }
        let (pose_wa, pose_ab) = (self.a().pose(), self.pose_ab());
        let real = |body: &ContactBody<'_, T>| real_part(body.modulus());
        let real_pair = ContactPair::new(
            ContactBody::from_valid(self.a().shape(), Pose::identity(), real(self.a())),
            ContactBody::from_valid(self.b().shape(), pose_ab.real(), real(self.b())),
        );
        let relative = real_pair.relative_jacobian();
        let wrench_a = relative.carried(&pose_ab, [self.a().modulus(), self.b().modulus()]);
        ContactWrench::from_wrench_a(wrench_a, pose_wa, &pose_ab)
    }
}

impl RelativeJacobian<f64> {
    /// The wrench on A about A's origin in A's axes, with the derivatives of pose and moduli.
    fn carried<T: Scalar>(&self, pose_ab: &Pose<T>, moduli: [T; 2]) -> Wrench<T> {
        let motion = motion_from_real(pose_ab);
        let [by_modulus_a, by_modulus_b] = self.by_moduli(moduli.map(real_part));
        let changes = moduli.map(|modulus| modulus - real_part(modulus));
        let wrench = self.wrench().to_vector();
        let carried = |row: usize| {
            let by_motion =
                (0..6).map(|column| motion[column] * self.by_motion_of_b()[(row, column)]);
            let by_moduli = changes[0] * by_modulus_a[row] + changes[1] * by_modulus_b[row];
            by_motion.sum::<T>() + by_moduli + wrench[row]
        };
        Wrench {
            torque: Vector3::from_fn(|i, _| carried(i)),
            force: Vector3::from_fn(|i, _| carried(3 + i)),
        }
    }
}

/// The infinitesimal motion of B about A's origin that takes the real part of a pose to the pose:
/// (angular, linear), with real parts of zero.
fn motion_from_real<T: Scalar>(pose_ab: &Pose<T>) -> [T; 6] {
    let real = pose_ab.real();
    // R = (I + [ω]ₓ)·R₀ to first order.
    let turn: Matrix3<T> = pose_ab.rotation() * real.rotation().transpose().map(lift::<T>);
    let half_skew = |i: usize, j: usize| {
        let twice = turn[(i, j)] - turn[(j, i)];
        (twice - real_part(twice)) * 0.5
    };
    let angular = Vector3::new(half_skew(2, 1), half_skew(0, 2), half_skew(1, 0));
    let translation = pose_ab.translation();
    let origin = lift_vector::<T>(&real_vector(translation));
    // A turn about A's origin moves B's origin too.
    let linear = translation - origin - angular.cross(&origin);
    [
        angular.x, angular.y, angular.z, linear.x, linear.y, linear.z,
    ]
}
