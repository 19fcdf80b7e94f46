use super::{AffineField, PolygonMoments};
use crate::scalar::{Scalar, lift, real_part, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Corners a [`ConvexPolygon`] has room for. A plane cuts two tetrahedra in at most 8 corners; the
/// rest is room for corners that round-off adds.
pub const POLYGON_CAPACITY: usize = 12;

/// A planar convex polygon in space, on the stack; empty where nothing is left of it.
#[derive(Debug, Clone, Copy)]
pub struct ConvexPolygon<T = f64> {
    corners: [Vector3<T>; POLYGON_CAPACITY],
    len: usize,
}

impl<T: Scalar> ConvexPolygon<T> {
    /// The polygon without corners.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            corners: [Vector3::from_element(lift(0.0)); POLYGON_CAPACITY],
            len: 0,
        }
    }

    /// The corners (m), in cyclic order.
    #[must_use]
    pub fn corners(&self) -> &[Vector3<T>] {
        &self.corners[..self.len]
    }

    /// Whether fewer than three corners are left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len < 3
    }

    /// Appends a corner. A full polygon drops it: convex polygons never fill the capacity, so such
    /// a corner is a copy, by round-off, of one that is there.
    pub(crate) fn push(&mut self, corner: Vector3<T>) {
        if self.len < POLYGON_CAPACITY {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The same polygon, turning the other way.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.corners[..self.len].reverse();
        self
    }

    /// The part of the polygon where `field` ≥ 0. Values within `tolerance` of zero count as zero.
    ///
    /// Where an edge crosses from below to zero, the corner at zero comes out twice, with the same
    /// place but two derivatives: its own and the crossing's. Both are needed: together they give
    /// the polygon's area the derivative it has on the side where the field grows.
    #[must_use]
    pub fn clipped(&self, field: &AffineField<T>, tolerance: f64) -> Self {
        let mut clipped = Self::empty();
        let Some(last) = self.corners().last() else {
            return clipped;
        };
        let mut previous = *last;
        let mut value_before = snapped(field.at(&previous), tolerance);
        for corner in self.corners() {
            let value = snapped(field.at(corner), tolerance);
            let (was_inside, is_inside) = (real_part(value_before) >= 0.0, real_part(value) >= 0.0);
            if was_inside != is_inside {
                let t = value_before / (value_before - value);
                clipped.push(previous + (corner - previous) * t);
            }
            if is_inside {
                clipped.push(*corner);
            }
            (previous, value_before) = (*corner, value);
        }
        clipped
    }

    /// Area and moments, about the first corner. The area is positive where the corners turn
    /// counter-clockwise about the unit `normal`, negative else.
    #[must_use]
    pub fn moments(&self, normal: &Vector3<T>) -> PolygonMoments<T> {
        let corners = self.corners();
        let Some(&reference) = corners.first() else {
            return PolygonMoments::zero(Vector3::from_element(lift(0.0)));
        };
        let mut moments = PolygonMoments::zero(reference);
        for pair in corners[1..].windows(2) {
            moments.add_triangle(normal, &(pair[0] - reference), &(pair[1] - reference));
        }
        moments
    }

    /// The polygon in the outer frame.
    #[must_use]
    pub fn transformed(&self, pose: &Pose<T>) -> Self {
        let mut transformed = *self;
        for corner in &mut transformed.corners[..self.len] {
            *corner = pose.transformed_point(corner);
        }
        transformed
    }

    /// The polygon without its derivatives.
    #[must_use]
    pub fn real(&self) -> ConvexPolygon<f64> {
        ConvexPolygon {
            corners: self.corners.each_ref().map(real_vector),
            len: self.len,
        }
    }
}

impl ConvexPolygon<f64> {
    /// The constant polygon.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> ConvexPolygon<T> {
        ConvexPolygon {
            corners: self.corners.each_ref().map(|corner| corner.map(lift)),
            len: self.len,
        }
    }
}

/// The value, its real part set to zero where that is within `tolerance` of zero; the derivatives
/// stay.
#[inline]
pub(crate) fn snapped<T: Scalar>(value: T, tolerance: f64) -> T {
    let real = real_part(value);
    if real.abs() <= tolerance {
        value - real
    } else {
        value
    }
}
