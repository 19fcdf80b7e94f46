use super::{AffineField, PolygonMoments};
use crate::scalar::{Scalar, carries_derivatives, lift, lift_vector, real_part, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Corners a [`ConvexPolygon`] has room for. A plane cuts two tetrahedra in at most 8 corners; the
/// rest is room for corners that round-off adds.
pub const POLYGON_CAPACITY: usize = 12;

/// A planar convex polygon in space, on the stack; empty where nothing is left of it.
///
/// Each corner knows on which *sides* it lies: one bit for each plane that bounds the polygon, up to
/// eight of them. An edge lies on the sides that its two corners share.
#[derive(Debug, Clone, Copy)]
pub struct ConvexPolygon<T = f64> {
    corners: [Vector3<T>; POLYGON_CAPACITY],
    sides: [u8; POLYGON_CAPACITY],
    len: usize,
    is_doubtful: bool,
}

/// Whether a corner on the plane that clips counts as inside. Its place is the same; its derivatives are those
/// of that side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OnPlane {
    Inside,
    Outside,
}

impl<T: Scalar> ConvexPolygon<T> {
    /// The polygon without corners.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            corners: [Vector3::from_element(lift(0.0)); POLYGON_CAPACITY],
            sides: [0; POLYGON_CAPACITY],
            len: 0,
            is_doubtful: false,
        }
    }

    /// The corners (m), in cyclic order.
    #[must_use]
    pub fn corners(&self) -> &[Vector3<T>] {
        &self.corners[..self.len]
    }

    /// The sides that at least one corner lies on.
    #[must_use]
    pub fn sides(&self) -> u8 {
        self.sides[..self.len].iter().fold(0, |all, own| all | own)
    }

    /// The sides that all corners lie on: planes in which the whole polygon lies, up to round-off.
    pub(crate) fn common_sides(&self) -> u8 {
        self.sides[..self.len]
            .iter()
            .fold(u8::MAX, |all, own| all & own)
    }

    /// Whether a corner came so close to a plane that clipped, without lying on it, that round-off may
    /// have had a part in how: if two planes are nearly the same, the corners where they meet are
    /// placed much worse than any coordinate is rounded.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.is_doubtful
    }

    /// The corners with their sides that lie on more than two: it is chance which of the sides made them.
    pub(crate) fn coincidences(&self) -> impl Iterator<Item = (&Vector3<T>, u8)> {
        let corners = self.corners().iter().zip(self.sides);
        corners.filter(|(_, sides)| sides.count_ones() > 2)
    }

    /// Whether fewer than three corners are left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len < 3
    }

    /// Appends a corner. A full polygon drops it: convex polygons never fill the capacity, so such
    /// a corner is a copy, by round-off, of one that is there.
    pub(crate) fn push(&mut self, corner: Vector3<T>, sides: u8) {
        self.push_if(true, || corner, sides);
    }

    /// Appends a corner if it `is_kept`.
    ///
    /// Without derivatives it is made first and then kept or not: a branch that is guessed wrong, as
    /// these are half the time, takes longer.
    #[inline]
    fn push_if(&mut self, is_kept: bool, corner: impl FnOnce() -> Vector3<T>, sides: u8) {
        let is_worth_a_branch = carries_derivatives::<T>();
        if (is_worth_a_branch && !is_kept) || self.len == POLYGON_CAPACITY {
            return;
        }
        self.corners[self.len] = corner();
        self.sides[self.len] = sides;
        self.len += usize::from(is_kept);
    }

    /// Makes the polygon turn the other way.
    pub(crate) fn reverse(&mut self) {
        self.corners[..self.len].reverse();
        self.sides[..self.len].reverse();
    }

    /// The part of the polygon where `field` ≥ 0; corners where it is 0 lie on `side` (one bit). Values
    /// within `tolerance` of zero count as zero.
    ///
    /// Where an edge crosses from below to zero, the corner at zero comes out twice, with the same
    /// place but two derivatives: its own and the crossing's. Both are needed: together they give
    /// the polygon's area the derivative it has on the side where the field grows.
    #[must_use]
    pub fn clipped(mut self, field: &AffineField<T>, tolerance: f64, side: u8) -> Self {
        self.clip(field, tolerance, side, OnPlane::Inside);
        self
    }

    /// [`Self::clipped`] in place: most faces do not cut, and a polygon is large to hand on. Returns
    /// whether the side came near the polygon at all.
    #[inline]
    pub(crate) fn clip(
        &mut self,
        field: &AffineField<T>,
        tolerance: f64,
        side: u8,
        on_plane: OnPlane,
    ) -> bool {
        let mut values = [lift(0.0); POLYGON_CAPACITY];
        let (mut is_near, mut is_doubtful) = (false, false);
        for (value, corner) in values.iter_mut().zip(&self.corners[..self.len]) {
            *value = field.at(corner);
            let real = real_part(*value);
            is_near |= real <= tolerance;
            is_doubtful |= is_doubtful_value(real, tolerance);
            *value = snapped(*value, tolerance);
        }
        self.is_doubtful |= is_doubtful;
        if is_near {
            match on_plane {
                OnPlane::Inside => self.cut(&values, side, |value| value >= 0.0),
                OnPlane::Outside => self.cut(&values, side, |value| value > 0.0),
            }
        }
        is_near
    }

    /// Leaves the part of the polygon where values are kept.
    #[inline]
    fn cut(&mut self, values: &[T; POLYGON_CAPACITY], side: u8, keeps: impl Fn(f64) -> bool) {
        let whole = *self;
        self.len = 0;
        let mut before = whole.len.saturating_sub(1);
        for now in 0..whole.len {
            let (value_before, value) = (values[before], values[now]);
            let (was_inside, is_inside) = (keeps(real_part(value_before)), keeps(real_part(value)));
            let (previous, corner) = (&whole.corners[before], &whole.corners[now]);
            let on_side = if real_part(value) == 0.0 { side } else { 0 };
            let shared = whole.sides[before] & whole.sides[now];
            let crossing =
                || previous + (corner - previous) * (value_before / (value_before - value));
            self.push_if(was_inside != is_inside, crossing, shared | side);
            self.push_if(is_inside, || *corner, whole.sides[now] | on_side);
            before = now;
        }
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
        self.mapped(|corner| pose.transformed_point(corner))
    }

    /// The polygon without its derivatives.
    #[must_use]
    pub fn real(&self) -> ConvexPolygon<f64> {
        self.mapped(real_vector)
    }

    /// The polygon with each corner elsewhere.
    #[inline]
    fn mapped<U: Scalar>(&self, corner: impl Fn(&Vector3<T>) -> Vector3<U>) -> ConvexPolygon<U> {
        let mut mapped = ConvexPolygon::empty();
        for (place, own) in mapped.corners.iter_mut().zip(self.corners()) {
            *place = corner(own);
        }
        (mapped.sides, mapped.len) = (self.sides, self.len);
        mapped.is_doubtful = self.is_doubtful;
        mapped
    }
}

impl ConvexPolygon<f64> {
    /// Whether it is no wider than this (m).
    pub(crate) fn is_line(&self, width: f64) -> bool {
        let Some((first, others)) = self.corners().split_first() else {
            return true;
        };
        let arms = others.iter().map(|corner| corner - first);
        let length = arms.map(|arm| arm.norm()).fold(0.0, f64::max);
        let triangles = others.windows(2);
        let double_area = triangles
            .map(|pair| (pair[0] - first).cross(&(pair[1] - first)))
            .sum::<Vector3<f64>>();
        double_area.norm() <= width * length
    }

    /// The constant polygon.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> ConvexPolygon<T> {
        self.mapped(lift_vector)
    }
}

/// Values within so many tolerances of zero are doubtful. Planes that are further apart, over a body, meet in
/// lines that are placed to one part in DOUBT.
const DOUBT: f64 = 1e4;

/// Whether a value is not zero, but nearly.
#[inline]
pub(crate) fn is_doubtful_value(value: f64, tolerance: f64) -> bool {
    (tolerance..=DOUBT * tolerance).contains(&value.abs())
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
