use super::plane_polygon::{PlanePolygon, SpacePolygon};
use super::{ContactBody, Partner};
use crate::narrow_phase::{Cut, EquilibriumPlane, RelativePair, Weights, scales};
use crate::scalar::{Scalar, carries_derivatives, real_part};
use crate::spatial::Pose;

/// A pair of bodies from which contact polygons are computed in `T`, in A's frame.
pub(super) struct PolygonSource<'a, T> {
    pub pair: RelativePair<'a>,
    pub modulus_a: T,
    /// Factors of the extents in the two fields that are equal on the plane (see [`RelativePair::scales`]).
    scales: [T; 2],
    pub pose_ab: Pose<T>,
}

impl<'a, T: Scalar> PolygonSource<'a, T> {
    pub fn of(a: &ContactBody<'a, T>, b: &Partner<'a, T>) -> Self {
        let pose_ab = a.pose().inverse() * *b.pose();
        Self {
            pair: RelativePair::of(a, b, &pose_ab),
            modulus_a: a.modulus(),
            scales: scales(a, b),
            pose_ab,
        }
    }

    /// Returns the source with coincidences within 2^octaves margins.
    pub fn with_near_coincidences(&self, octaves: i32) -> Self {
        Self {
            pair: self.pair.with_near_coincidences(octaves),
            ..*self
        }
    }

    /// Returns whether the polygon of a cut has a positive area and is not on the surfaces of both bodies.
    pub fn is_pressed(&self, cut: &Cut) -> bool {
        self.pressed_polygon(cut).is_some()
    }

    /// Returns the polygon of a cut if it is part of the contact surface.
    pub fn pressed_polygon(&self, cut: &Cut) -> Option<PlanePolygon<T>> {
        if cut.is_on_both_surfaces() || !cut.weights().has_still_area() {
            return None;
        }
        self.polygon(cut).filter(PlanePolygon::has_area)
    }

    /// Returns the polygon of a cut if its weights count. With derivatives, its area may be zero.
    #[inline]
    pub fn counted_polygon(
        &self,
        cut: &Cut,
        counts: impl Fn(Weights) -> bool,
    ) -> Option<PlanePolygon<T>> {
        let polygon = counts(cut.weights()).then(|| self.polygon(cut))??;
        (carries_derivatives::<T>() || polygon.has_area()).then_some(polygon)
    }

    /// Returns the polygon of a cut, or `None` if it has no corner.
    #[inline]
    pub fn polygon(&self, cut: &Cut) -> Option<PlanePolygon<T>> {
        self.polygon_in_space(cut).in_plane(cut.weights())
    }

    /// Returns the polygon of a cut in A's frame. For `f64` it is in the cut. With derivatives it is computed again, by the same cuts.
    #[inline]
    pub fn polygon_in_space(&self, cut: &Cut) -> SpacePolygon<T> {
        let tets = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let pressure_a = tets[0].extent.lifted().scaled(self.modulus_a);
        let (outline, field_b) = if carries_derivatives::<T>() {
            let field_b = tets[1].extent.posed(&self.pose_ab).scaled(self.scales[1]);
            let fields = (self.scales[0], &field_b);
            let polygon = self.pair.polygon_in(cut, fields, &self.pose_ab);
            (polygon, field_b)
        } else {
            (cut.polygon.lifted(), cut.field_b.lifted())
        };
        let is_rigid = self.pair.shape_b.is_rigid();
        let plane = if is_rigid {
            EquilibriumPlane::of_rigid(&field_b)
        } else {
            EquilibriumPlane::between(&pressure_a, &field_b)
        };
        let [gradient_a, gradient_b] = [0, 1].map(|i| self.pair.scales[i] * tets[i].steepness);
        SpacePolygon {
            outline,
            plane,
            pressure_a,
            pressure: if is_rigid || gradient_a <= gradient_b {
                pressure_a
            } else {
                field_b
            },
        }
    }

    /// Returns the moduli of A and of B. A rigid B has 1.
    pub fn moduli(&self) -> [T; 2] {
        [self.modulus_a, self.scales[1]]
    }

    /// Returns the rounding-error bound of the pressure on the polygon of a cut, per rounding error of a coordinate (Pa/m).
    pub fn sensitivity(&self, cut: &Cut) -> f64 {
        let [a, b] = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let of_a = real_part(self.modulus_a) * a.sensitivity;
        if self.pair.shape_b.is_rigid() {
            of_a
        } else {
            of_a.min(self.pair.scales[1] * b.sensitivity)
        }
    }
}
