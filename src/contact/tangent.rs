use super::{ContactPair, SurfaceLaw};
use crate::scalar::{Scalar, change, constant_times, cross_constant, lift, real_vector};
use crate::spatial::{Twist, turn_from_real};
use nalgebra::SVector;

impl<T: Scalar> ContactPair<'_, T> {
    /// Returns the dual parts of the numbers that the wrench depends on: the motion of B relative to A (angular, linear, in A's axes about
    /// A's origin), both moduli, the velocity of A relative to B, dissipation and friction. The last eight are zero for a pair at rest.
    pub(super) fn tangent(&self) -> [T; 16] {
        let (pose_wa, pose_wb) = (self.a().pose(), self.b().pose());
        let [turn_a, turn_b] = [pose_wa, pose_wb].map(|pose| turn_from_real(pose.rotation()));
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        // Motion of the points of both bodies at A's origin. A turn about B's origin also moves the point of B.
        let shift = from_a_to_b.map(change) - cross_constant(&turn_b, &real_vector(&from_a_to_b));
        let in_a = pose_wa.real().rotation().transpose();
        let angular = constant_times(&in_a, &(turn_b - turn_a));
        let linear = constant_times(&in_a, &shift);
        let mut tangent = [lift(0.0); 16];
        tangent[..3].copy_from_slice(angular.as_slice());
        tangent[3..6].copy_from_slice(linear.as_slice());
        tangent[6..8].copy_from_slice(&self.moduli().map(change));
        if let Some((law, motion)) = self.relative_motion() {
            tangent[8..11].copy_from_slice(motion.angular.map(change).as_slice());
            tangent[11..14].copy_from_slice(motion.at_origin.map(change).as_slice());
            tangent[14..].copy_from_slice(&[law.dissipation, law.friction].map(change));
        }
        tangent
    }
}

impl<'a> ContactPair<'a> {
    /// Returns the pair after changes of poses, twists, moduli, dissipation and friction, in the order of the columns of
    /// [`LinearizedContact::jacobian`](super::LinearizedContact::jacobian). The real parts of the changes are zero.
    pub(crate) fn perturbed<T: Scalar>(&self, changes: &SVector<T, 28>) -> ContactPair<'a, T> {
        let twist = |row| Twist::from_vector(&changes.fixed_rows::<6>(row).into_owned());
        let perturbed = ContactPair::new(
            self.a().perturbed(&twist(0), changes[24]),
            self.b().perturbed(&twist(6), changes[25]),
        );
        let perturbed = perturbed.with_search(self.search());
        let Some(motion) = self.motion() else {
            return perturbed;
        };
        let law = SurfaceLaw {
            dissipation: changes[26] + motion.law.dissipation,
            friction: changes[27] + motion.law.friction,
            slip_tolerance: motion.law.slip_tolerance,
        };
        let [mut twist_a, mut twist_b] = [twist(12), twist(18)];
        for (change, twist) in [&mut twist_a, &mut twist_b].into_iter().zip(&motion.twists) {
            change.angular += twist.angular.map(lift::<T>);
            change.linear += twist.linear.map(lift::<T>);
        }
        perturbed.moving(law, [twist_a, twist_b])
    }
}
