mod clip;

use super::tolerance::NearZeroHistogram;
use crate::scalar::{Scalar, carries_derivatives, lift, lift_vector, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Corners a [`ConvexPolygon`] has room for. A plane cuts two tetrahedra in at most 8 corners; the
/// rest is room for corners that round-off adds.
pub const POLYGON_CAPACITY: usize = 12;

/// A planar convex polygon in space, on the stack; empty where nothing is left of it.
///
/// Each edge knows its *owners*: the planes it lies in, one bit for each of up to eight planes that bound the polygon.
#[derive(Debug, Clone, Copy)]
pub struct ConvexPolygon<T = f64> {
    corners: [Vector3<T>; POLYGON_CAPACITY],
    /// Owners of the edge from each corner to the next.
    owners: [u8; POLYGON_CAPACITY],
    len: u8,
    closeness: NearZeroHistogram,
    coplanarity: NearZeroHistogram,
}

impl<T: Scalar> ConvexPolygon<T> {
    /// The polygon without corners.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            corners: [Vector3::from_element(lift(0.0)); POLYGON_CAPACITY],
            owners: [0; POLYGON_CAPACITY],
            len: 0,
            closeness: NearZeroHistogram::default(),
            coplanarity: NearZeroHistogram::default(),
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
    pub(crate) fn closeness(&self) -> NearZeroHistogram {
        self.closeness
    }

    /// Of the farthest corners to the planes that clipped: the polygon nearly lies in such a plane.
    pub(crate) fn coplanarity(&self) -> NearZeroHistogram {
        self.coplanarity
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
    pub(crate) fn add_owners(&mut self, edge: usize, owners: u8) {
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

    /// The area (m²) times the unit normal about which the corners turn counter-clockwise.
    #[must_use]
    pub fn area_vector(&self) -> Vector3<T> {
        let mut sum = Vector3::from_element(lift(0.0));
        if let Some((first, others)) = self.corners().split_first() {
            for pair in others.windows(2) {
                sum += (pair[0] - first).cross(&(pair[1] - first));
            }
        }
        sum * lift::<T>(0.5)
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
        (mapped.closeness, mapped.coplanarity) = (self.closeness, self.coplanarity);
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
