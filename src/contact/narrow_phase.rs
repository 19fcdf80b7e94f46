use super::equilibrium::EquilibriumPlane;
use super::meeting::Meeting;
use super::shadow::PairShadow;
use crate::geometry::{AffineField, ConvexPolygon, PolygonMoments};
use crate::scalar::{Scalar, carries_derivatives, real_part};
use crate::spatial::Pose;

/// The narrow phase of one body pair: from where two tetrahedra meet, decided in `f64`, to their
/// contact polygon in `T`. All geometry is in A's frame.
pub(super) struct NarrowPhase<'a, T> {
    pub shadow: PairShadow<'a>,
    pub modulus_a: T,
    pub modulus_b: T,
    pub pose_ab: Pose<T>,
}

/// The contact polygon of a pair of tetrahedra, in A's frame.
pub(super) struct PairPolygon<T> {
    /// The tetrahedra, of A and of B.
    pub tets: [usize; 2],
    /// Whether it lies in flush surfaces of both bodies: there is no pressure on it, but there will be
    /// on one side or the other as soon as a body moves. It counts by half in the derivatives, which
    /// makes them the mean of the two one-sided ones; these are equal where opposite faces are flush.
    pub flush: bool,
    pub polygon: ConvexPolygon<T>,
    pub plane: EquilibriumPlane<T>,
    pub moments: PolygonMoments<T>,
    pub pressure_a: AffineField<T>,
    pub pressure_b: AffineField<T>,
    /// The pressure on the polygon (Pa): both bodies' fields are the same there, and this is the one
    /// of the smaller gradient, which is rounded less.
    pub pressure: AffineField<T>,
}

impl<T: Scalar> NarrowPhase<'_, T> {
    /// The contact polygon of two tetrahedra that meet; `None` where it has no area.
    ///
    /// For an `f64` it is there already; with derivatives it is made again, by the same cuts.
    pub fn polygon(&self, meeting: &Meeting) -> Option<PairPolygon<T>> {
        let [tet_a, tet_b] = [self.shadow.tet_a(meeting.tets[0]), self.shadow.tet_b(meeting.tets[1])];
        let pressure_a = tet_a.extent.lifted().scaled(self.modulus_a);
        let (polygon, pressure_b) = if carries_derivatives::<T>() {
            let pressure_b = tet_b.extent.posed(&self.pose_ab).scaled(self.modulus_b);
            let face = |face: usize| tet_b.barycentric[face].posed(&self.pose_ab);
            let steepness = &tet_b.barycentric_steepness;
            let crossing = &meeting.crossing;
            let outline = crossing.outline(tet_a, self.modulus_a, &pressure_b, steepness, face);
            (outline, pressure_b)
        } else {
            (meeting.outline.lifted(), meeting.pressure_b.lifted())
        };
        let plane = EquilibriumPlane::between(&pressure_a, &pressure_b);
        let mut moments = polygon.moments(&plane.normal);
        if meeting.crossing.flush {
            moments = moments.scaled(0.5);
        }
        let is_a_softer = self.shadow.moduli[0] * tet_a.steepness
            <= self.shadow.moduli[1] * tet_b.steepness;
        // Nothing but round-off is left of a polygon that does not turn about its normal.
        (real_part(moments.area) > 0.0).then_some(PairPolygon {
            tets: meeting.tets,
            flush: meeting.crossing.flush,
            polygon,
            plane,
            moments,
            pressure_a,
            pressure_b,
            pressure: if is_a_softer { pressure_a } else { pressure_b },
        })
    }
}
