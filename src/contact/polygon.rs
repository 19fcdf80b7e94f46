use crate::geometry::{AffineField, ConvexPolygon, OnPlane, PolygonMoments};
use crate::narrow_phase::EquilibriumPlane;
use crate::narrow_phase::Meeting;
use crate::narrow_phase::RelativePair;
use crate::scalar::{Scalar, carries_derivatives, real_part};
use crate::spatial::Pose;

/// The narrow phase of one body pair: from where two tetrahedra meet, decided in `f64`, to their
/// contact polygon in `T`. All geometry is in A's frame.
pub(super) struct NarrowPhase<'a, T> {
    pub shadow: RelativePair<'a>,
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
    /// How much of it counts: half where it lies in a face.
    pub weight: f64,
    pub polygon: ConvexPolygon<T>,
    pub plane: EquilibriumPlane<T>,
    /// With the weight.
    pub moments: PolygonMoments<T>,
    pub pressure_a: AffineField<T>,
    pub pressure_b: AffineField<T>,
    /// The pressure on the polygon (Pa): both bodies' fields are the same there, and this is the one
    /// of the smaller gradient, which is rounded less.
    pub pressure: AffineField<T>,
}

impl<T: Scalar> NarrowPhase<'_, T> {
    /// Visits the contact polygon of two tetrahedra that meet. With derivatives, where corners coincide with faces
    /// of B, it comes as two halves, with derivatives of either side.
    pub fn visit_polygon(&self, meeting: &Meeting, mut visit: impl FnMut(&PairPolygon<T>)) {
        let weight = meeting.weight();
        if carries_derivatives::<T>() && meeting.has_coincidences() {
            for on_face in [OnPlane::Inside, OnPlane::Outside] {
                visit(&self.polygon(meeting, on_face, 0.5 * weight));
            }
        } else {
            visit(&self.polygon(meeting, OnPlane::Inside, weight));
        }
    }

    /// For an `f64` it is there already; with derivatives it is made again, by the same cuts.
    fn polygon(&self, meeting: &Meeting, on_face: OnPlane, weight: f64) -> PairPolygon<T> {
        let tets = [
            self.shadow.tet_a(meeting.tets[0]),
            self.shadow.tet_b(meeting.tets[1]),
        ];
        let pressure_a = tets[0].extent.lifted().scaled(self.modulus_a);
        let (polygon, pressure_b) = if carries_derivatives::<T>() {
            let pressure_b = tets[1].extent.posed(&self.pose_ab).scaled(self.modulus_b);
            let pressures = (self.modulus_a, &pressure_b);
            let outline = meeting.outline_in(tets, pressures, &self.pose_ab, on_face);
            (outline, pressure_b)
        } else {
            (meeting.outline.lifted(), meeting.pressure_b.lifted())
        };
        let plane = EquilibriumPlane::between(&pressure_a, &pressure_b);
        let [gradient_a, gradient_b] = [0, 1].map(|i| self.shadow.moduli[i] * tets[i].steepness);
        PairPolygon {
            tets: meeting.tets,
            flush: meeting.is_flush(),
            weight,
            moments: polygon.moments(&plane.normal).scaled(weight),
            polygon,
            plane,
            pressure_a,
            pressure_b,
            pressure: if gradient_a <= gradient_b {
                pressure_a
            } else {
                pressure_b
            },
        }
    }
}

impl<T: Scalar> PairPolygon<T> {
    /// Whether it turns about its normal: else nothing but round-off is left of it.
    pub fn has_area(&self) -> bool {
        real_part(self.moments.area) > 0.0
    }

    /// Whether it adds to an integral. Without an area it does so if there are derivatives: the area may have
    /// one.
    pub fn counts(&self) -> bool {
        carries_derivatives::<T>() || self.has_area()
    }
}
