//! Clipping of a polygon to one side of a plane.

use super::{ConvexPolygon, POLYGON_CAPACITY};
use crate::geometry::AffineField;
use crate::geometry::tolerance::{NearZeroHistogram, Tolerance, snapped};
use crate::scalar::{Scalar, lift, real_part, real_vector};

/// Length of an edge with a reliable direction, as a multiple of the distance within which corners
/// count as on a plane. Both ends of a longer edge must be on the same side of the plane, or on the
/// plane.
const LONG_EDGE: f64 = 64.0;

impl<T: Scalar> ConvexPolygon<T> {
    /// Clips the polygon to the half-space `field` ≥ 0. Values within `tolerance` of zero count as
    /// zero. The plane becomes an owner, with the bit `side`, of the edges on which the field is
    /// zero.
    ///
    /// If an edge crosses from below to zero, the corner at zero is duplicated. An edge of zero
    /// length joins the two copies. So a polygon that is reduced to one edge is a line traversed
    /// forth and back. The owners of both directions give the mean of the rates at which the line
    /// opens on either side.
    #[must_use]
    pub fn clipped(mut self, field: &AffineField<T>, tolerance: f64, side: u8) -> Self {
        self.clip(field, Tolerance::new(tolerance), side, || 0);
        self
    }

    /// Clips like [`Self::clipped`], but in place. Most faces do not cut the polygon, and moving a
    /// polygon is slow because it is large.
    ///
    /// `disjoint_faces` returns the owners of edges that are known not to meet the plane `side`. The ends of
    /// such an edge that are inside do not count as on the plane, however close they are.
    #[inline]
    pub(crate) fn clip(
        &mut self,
        field: &AffineField<T>,
        tolerance: Tolerance,
        side: u8,
        disjoint_faces: impl FnOnce() -> u8,
    ) {
        let mut values = [lift(0.0); POLYGON_CAPACITY];
        let (mut is_near, mut closeness, mut zeros) = (false, NearZeroHistogram::default(), 0_u32);
        for (value, corner) in values.iter_mut().zip(&self.corners[..self.len()]) {
            *value = field.at(corner);
            let real = real_part(*value);
            is_near |= real <= tolerance.zero;
            zeros += u32::from(real.abs() <= tolerance.zero);
            closeness = closeness.or(tolerance.closeness(real));
            *value = snapped(*value, tolerance.zero);
        }
        if zeros >= 2 {
            self.restore_beside(&mut values, (field, tolerance.zero), disjoint_faces());
        }
        if closeness != NearZeroHistogram::default() {
            self.note(closeness, &values, tolerance);
        }
        if is_near {
            if zeros >= 2 {
                self.add_owner_where_zero(&values, side);
            }
            self.cut(&values, side);
        }
    }

    /// Restores the exact values at both ends of an edge that has one of these owners, if both ends
    /// are inside. The edge lies next to the plane, not on it.
    #[cold]
    fn restore_beside(
        &self,
        values: &mut [T; POLYGON_CAPACITY],
        (field, zero): (&AffineField<T>, f64),
        owners: u8,
    ) {
        for now in 0..self.len() {
            let next = if now + 1 == self.len() { 0 } else { now + 1 };
            if self.owners[now] & owners == 0 {
                continue;
            }
            let [from, to] = [now, next].map(|end| &self.corners[end]);
            let exact = [field.at(from), field.at(to)];
            let is_beside = |value: &T| 0.0 < real_part(*value) && real_part(*value) <= zero;
            let near = zero / real_vector(&field.gradient).norm();
            if exact.iter().all(is_beside) && real_vector(&(to - from)).norm() > LONG_EDGE * near {
                [values[now], values[next]] = exact;
            }
        }
    }

    #[cold]
    fn note(&mut self, closeness: NearZeroHistogram, values: &[T], tolerance: Tolerance) {
        let sizes = values[..self.len()]
            .iter()
            .map(|&value| real_part(value).abs());
        let coplanarity = tolerance.closeness(sizes.fold(0.0, f64::max));
        self.closeness = self.closeness.or(closeness);
        self.coplanarity = self.coplanarity.or(coplanarity);
    }

    /// Adds the owner `side` to edges along which the values are zero.
    #[cold]
    fn add_owner_where_zero(&mut self, values: &[T; POLYGON_CAPACITY], side: u8) {
        for now in 0..self.len() {
            let next = if now + 1 == self.len() { 0 } else { now + 1 };
            if [now, next].iter().all(|&end| real_part(values[end]) == 0.0) {
                self.owners[now] |= side;
            }
        }
    }

    /// Keeps the part of the polygon where the values are ≥ 0.
    #[inline]
    fn cut(&mut self, values: &[T; POLYGON_CAPACITY], side: u8) {
        let whole = *self;
        self.len = 0;
        let mut before = whole.len().saturating_sub(1);
        for now in 0..whole.len() {
            let (value_before, value) = (values[before], values[now]);
            let (was_inside, is_inside) = (real_part(value_before) >= 0.0, real_part(value) >= 0.0);
            let (previous, corner) = (&whole.corners[before], &whole.corners[now]);
            let crossing =
                || previous + (corner - previous) * (value_before / (value_before - value));
            // An outline that returns inside continues along the edge that was cut.
            let owners = if is_inside {
                whole.owners[before]
            } else {
                side
            };
            self.push_if(was_inside != is_inside, crossing, owners);
            self.push_if(is_inside, || *corner, whole.owners[now]);
            before = now;
        }
    }
}
