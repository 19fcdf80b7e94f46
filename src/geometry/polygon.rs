use super::tolerance::{Closeness, Tolerance, snapped};
use super::{AffineField, PolygonMoments};
use crate::scalar::{Scalar, carries_derivatives, lift, lift_vector, real_part, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Corners a [`ConvexPolygon`] has room for. A plane cuts two tetrahedra in at most 8 corners; the
/// rest is room for corners that round-off adds.
pub const POLYGON_CAPACITY: usize = 12;

/// An edge so many times as long as the distance within which corners count as on a plane has a direction: which side of the plane
/// it is on is told by both ends alike.
const LONG: f64 = 64.0;

/// A planar convex polygon in space, on the stack; empty where nothing is left of it.
///
/// Each edge knows its *owners*: the planes it lies in, one bit for each of up to eight planes that bound the polygon.
#[derive(Debug, Clone, Copy)]
pub struct ConvexPolygon<T = f64> {
    corners: [Vector3<T>; POLYGON_CAPACITY],
    /// Owners of the edge from each corner to the next.
    owners: [u8; POLYGON_CAPACITY],
    len: u8,
    closeness: Closeness,
    flatness: Closeness,
}

impl<T: Scalar> ConvexPolygon<T> {
    /// The polygon without corners.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            corners: [Vector3::from_element(lift(0.0)); POLYGON_CAPACITY],
            owners: [0; POLYGON_CAPACITY],
            len: 0,
            closeness: Closeness::default(),
            flatness: Closeness::default(),
        }
    }

    #[inline]
    fn len(&self) -> usize {
        usize::from(self.len)
    }

    /// The corners (m), in cyclic order.
    #[must_use]
    pub fn corners(&self) -> &[Vector3<T>] {
        &self.corners[..self.len()]
    }

    /// The owners of each edge, from the corner of the same number to the next.
    #[must_use]
    pub fn owners(&self) -> &[u8] {
        &self.owners[..self.len()]
    }

    /// Whether an edge has several owners.
    pub(crate) fn shares_edges(&self) -> bool {
        self.owners().iter().any(|own| own.count_ones() > 1)
    }

    /// Whether a corner came so close to a plane that clipped, without lying on it, that round-off may
    /// have had a part in how: if two planes are nearly the same, the corners where they meet are
    /// placed much worse than any coordinate is rounded.
    #[must_use]
    pub fn is_ill_conditioned(&self) -> bool {
        self.closeness.is_ill_conditioned()
    }

    /// Of the corners to the planes that clipped.
    pub(crate) fn closeness(&self) -> Closeness {
        self.closeness
    }

    /// Of the farthest corners to the planes that clipped: the polygon nearly lies in such a plane.
    pub(crate) fn flatness(&self) -> Closeness {
        self.flatness
    }

    /// Whether fewer than three corners are left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len < 3
    }

    /// Appends a corner and the edge behind it. A full polygon drops it: convex polygons never fill the capacity, so
    /// such a corner is a copy, by round-off, of one that is there.
    pub(crate) fn push(&mut self, corner: Vector3<T>, owners: u8) {
        self.push_if(true, || corner, owners);
    }

    /// Gives an edge to other owners too.
    pub(crate) fn own_edge(&mut self, edge: usize, owners: u8) {
        if let Some(own) = self.owners[..usize::from(self.len)].get_mut(edge) {
            *own |= owners;
        }
    }

    /// Appends a corner if it `is_kept`.
    ///
    /// Without derivatives it is made first and then kept or not: a branch that is guessed wrong, as
    /// these are half the time, takes longer.
    #[inline]
    fn push_if(&mut self, is_kept: bool, corner: impl FnOnce() -> Vector3<T>, owners: u8) {
        let is_worth_a_branch = carries_derivatives::<T>();
        let place = self.len();
        if (is_worth_a_branch && !is_kept) || place == POLYGON_CAPACITY {
            return;
        }
        self.corners[place] = corner();
        self.owners[place] = owners;
        self.len += u8::from(is_kept);
    }

    /// The part of the polygon where `field` ≥ 0; values within `tolerance` of zero count as zero. Edges on which it is 0
    /// are owned by `side` (one bit).
    ///
    /// Where an edge crosses from below to zero, the corner at zero comes out twice, with the same place and an edge
    /// without length between. A polygon reduced to one edge is thus a line traversed forth and back, and the owners of
    /// both ways give the mean of the rates at which it opens on either side.
    #[must_use]
    pub fn clipped(mut self, field: &AffineField<T>, tolerance: f64, side: u8) -> Self {
        self.clip(field, Tolerance::new(tolerance), side, 0);
        self
    }

    /// [`Self::clipped`] in place: most faces do not cut, and a polygon is large to hand on.
    ///
    /// Edges of the owners `unmet` are known not to meet that side: those that are inside do not count as on it, however near they
    /// are.
    #[inline]
    pub(crate) fn clip(
        &mut self,
        field: &AffineField<T>,
        tolerance: Tolerance,
        side: u8,
        unmet: u8,
    ) {
        let mut values = [lift(0.0); POLYGON_CAPACITY];
        let (mut is_near, mut closeness) = (false, Closeness::default());
        for (value, corner) in values.iter_mut().zip(&self.corners[..self.len()]) {
            *value = field.at(corner);
            let real = real_part(*value);
            is_near |= real <= tolerance.zero;
            closeness = closeness.or(tolerance.closeness(real));
        }
        let zeros = if is_near {
            let kept = if unmet == 0 {
                0
            } else {
                let near = tolerance.zero / real_vector(&field.gradient).norm();
                self.beside(&values, tolerance.zero, near, unmet)
            };
            self.snap(&mut values, tolerance.zero, kept)
        } else {
            0
        };
        if closeness != Closeness::default() {
            self.note(closeness, &values, tolerance);
        }
        if zeros >= 2 {
            self.own_where_zero(&values, side);
        }
        if is_near {
            self.cut(&values, side);
        }
    }

    /// Sets values at corners to zero where they are within `zero` of it, but for those at the corners `kept` (bits). Gives how many
    /// are zero.
    #[inline]
    fn snap(&self, values: &mut [T; POLYGON_CAPACITY], zero: f64, kept: u32) -> u32 {
        let mut zeros = 0;
        for (corner, value) in values[..self.len()].iter_mut().enumerate() {
            if kept >> corner & 1 == 0 {
                *value = snapped(*value, zero);
                zeros += u32::from(real_part(*value) == 0.0);
            }
        }
        zeros
    }

    /// The corners (bits) at edges of these owners that are inside, though nowhere further than `near` (m) from zero: all of the
    /// edge lies beside the side and not on it.
    #[cold]
    fn beside(&self, values: &[T; POLYGON_CAPACITY], zero: f64, near: f64, owners: u8) -> u32 {
        let is_beside = |corner: usize| {
            let real = real_part(values[corner]);
            real > 0.0 && real <= zero
        };
        let mut corners = 0;
        for now in 0..self.len() {
            let next = if now + 1 == self.len() { 0 } else { now + 1 };
            if self.owners[now] & owners == 0 || !is_beside(now) || !is_beside(next) {
                continue;
            }
            let edge = real_vector(&(self.corners[next] - self.corners[now]));
            if edge.norm() > LONG * near {
                corners |= 1 << now | 1 << next;
            }
        }
        corners
    }

    #[cold]
    fn note(&mut self, closeness: Closeness, values: &[T], tolerance: Tolerance) {
        let sizes = values[..self.len()]
            .iter()
            .map(|&value| real_part(value).abs());
        let flatness = tolerance.closeness(sizes.fold(0.0, f64::max));
        self.closeness = self.closeness.or(closeness);
        self.flatness = self.flatness.or(flatness);
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
        (mapped.owners, mapped.len) = (self.owners, self.len);
        (mapped.closeness, mapped.flatness) = (self.closeness, self.flatness);
        mapped
    }
}

impl ConvexPolygon<f64> {
    /// The constant polygon.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> ConvexPolygon<T> {
        self.mapped(lift_vector)
    }
}

/// The numbers of the bits that are set, in ascending order.
pub(crate) fn set_bits(mut bits: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let number = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            number
        })
    })
}
