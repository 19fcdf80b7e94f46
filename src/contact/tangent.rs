use super::surface_law::RelativeMotion;
use super::{ContactPair, SurfaceLaw};
use crate::scalar::{Scalar, change, constant_times, cross_constant, real_vector};
use crate::spatial::turn_from_real;

impl<T: Scalar> ContactPair<'_, T> {
    /// How B has moved relative to A from where the real parts are (angular, linear, in A's axes
    /// about A's origin), and how the moduli have changed.
    pub(super) fn tangent(&self) -> [T; 8] {
        let (pose_wa, pose_wb) = (self.a().pose(), self.b().pose());
        let [turn_a, turn_b] = [pose_wa, pose_wb].map(|pose| turn_from_real(pose.rotation()));
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        // Of the points of both bodies at A's origin: a turn about B's origin moves the one of B too.
        let shift = from_a_to_b.map(change) - cross_constant(&turn_b, &real_vector(&from_a_to_b));
        let in_a = pose_wa.real().rotation().transpose();
        let angular = constant_times(&in_a, &(turn_b - turn_a));
        let linear = constant_times(&in_a, &shift);
        let moduli = self.moduli().map(change);
        [
            angular.x, angular.y, angular.z, linear.x, linear.y, linear.z, moduli[0], moduli[1],
        ]
    }

    /// [`Self::tangent`], and the changes of the relative motion and of the law.
    pub(super) fn tangent_in_motion(
        &self,
        law: &SurfaceLaw<T>,
        motion: &RelativeMotion<T>,
    ) -> [T; 16] {
        let of_pair = self.tangent();
        let angular = motion.angular.map(change);
        let linear = motion.at_origin.map(change);
        std::array::from_fn(|number| match number {
            0..8 => of_pair[number],
            8..11 => angular[number - 8],
            11..14 => linear[number - 11],
            14 => change(law.dissipation),
            _ => change(law.friction),
        })
    }
}
