use super::ContactPair;
use crate::scalar::{Scalar, change, constant_times, cross_constant, lift, real_vector};
use crate::spatial::turn_from_real;

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
