//! Clipping: the part of a polygon on one side of a plane.

use super::{ConvexPolygon, POLYGON_CAPACITY};
use crate::geometry::AffineField;
use crate::geometry::tolerance::{NearZeroHistogram, Tolerance, snapped};
use crate::scalar::{Scalar, lift, real_part, real_vector};

/// An edge so many times as long as the distance within which corners count as on a plane has a direction: which side of the plane
/// it is on is told by both ends alike.
const LONG_EDGE: f64 = 64.0;

impl<T: Scalar> ConvexPolygon<T> {
    /// The part of the polygon where `field` ≥ 0; values within `tolerance` of zero count as zero. Edges on which it is 0
    /// are owned by `side` (one bit).
    ///
    /// Where an edge crosses from below to zero, the corner at zero comes out twice, with the same place and an edge
    /// without length between. A polygon reduced to one edge is thus a line traversed forth and back, and the owners of
    /// both ways give the mean of the rates at which it opens on either side.
    #[must_use]
    pub fn clipped(mut self, field: &AffineField<T>, tolerance: f64, side: u8) -> Self {
        self.clip(field, Tolerance::new(tolerance), side, || 0);
        self
    }

    /// [`Self::clipped`] in place: most faces do not cut, and a polygon is large to hand on.
    ///
    /// Edges of the owners `disjoint_faces` are known not to meet that side: those that are inside do not count as on it, however near they
    /// are.
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
                self.own_where_zero(&values, side);
            }
            self.cut(&values, side);
        }
    }

    /// Sets values that count as zero to what they are where both ends of an edge of these owners are inside: it lies beside the
    /// side, not on it.
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

    /// Edges along which the values are zero belong to the side too.
    #[cold]
    fn own_where_zero(&mut self, values: &[T; POLYGON_CAPACITY], side: u8) {
        for now in 0..self.len() {
            let next = if now + 1 == self.len() { 0 } else { now + 1 };
            if [now, next].iter().all(|&end| real_part(values[end]) == 0.0) {
                self.owners[now] |= side;
            }
        }
    }

    /// Leaves the part of the polygon where values are ≥ 0.
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
            // Where the outline comes in again, the edge that was cut goes on.
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
