mod clip;

use super::tolerance::NearZeroHistogram;
use crate::scalar::{Scalar, carries_derivatives, lift, lift_vector, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Maximum number of corners of a [`ConvexPolygon`]. A plane cuts two tetrahedra in a polygon with
/// at most 8 corners. The other places are for corners that rounding errors add.
pub const POLYGON_CAPACITY: usize = 12;

/// A planar convex polygon in space, stored without heap allocation. It is empty if clipping
/// removed all of it.
///
/// Each edge has *owners*: the planes that contain it. They are stored as one bit for each of up to
/// eight planes that bound the polygon.
#[derive(Debug, Clone, Copy)]
pub struct ConvexPolygon<T = f64> {
    corners: [Vector3<T>; POLYGON_CAPACITY],
    /// Owners of the edge from each corner to the next corner.
    owners: [u8; POLYGON_CAPACITY],
    len: u8,
    closeness: NearZeroHistogram,
    coplanarity: NearZeroHistogram,
}

impl<T: Scalar> ConvexPolygon<T> {
    /// Creates a polygon without corners.
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

    /// Returns the corners (m), in cyclic order.
    #[must_use]
    pub fn corners(&self) -> &[Vector3<T>] {
        &self.corners[..self.len()]
    }

    /// Returns the owners of each edge. Edge k joins corner k to the next corner.
    #[must_use]
    pub fn owners(&self) -> &[u8] {
        &self.owners[..self.len()]
    }

    /// Returns whether an edge has several owners.
    pub(crate) fn shares_edges(&self) -> bool {
        self.owners().iter().any(|owners| owners.count_ones() > 1)
    }

    /// Returns whether rounding errors may have decided how the polygon was clipped. A corner then
    /// came close to a clipping plane, but was not on it. If two planes nearly coincide, the
    /// corners on both have errors much larger than the rounding error of a coordinate.
    #[must_use]
    pub fn is_ill_conditioned(&self) -> bool {
        self.closeness.is_ill_conditioned()
    }

    /// Returns how close corners came to the clipping planes.
    pub(crate) fn closeness(&self) -> NearZeroHistogram {
        self.closeness
    }

    /// Returns the histogram of the small distances between the clipping planes and their farthest
    /// corners. If any bit is set, the polygon nearly lies in a clipping plane.
    pub(crate) fn coplanarity(&self) -> NearZeroHistogram {
        self.coplanarity
    }

    /// Returns whether fewer than three corners are left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len < 3
    }

    /// Appends a corner and the edge after it. A full polygon drops the corner. Convex polygons
    /// never fill the capacity, so the dropped corner is a copy, caused by rounding errors, of an
    /// existing corner.
    pub(crate) fn push(&mut self, corner: Vector3<T>, owners: u8) {
        self.push_if(true, || corner, owners);
    }

    /// Adds owners to an edge.
    pub(crate) fn add_owners(&mut self, edge: usize, owners: u8) {
        if let Some(edge_owners) = self.owners[..usize::from(self.len)].get_mut(edge) {
            *edge_owners |= owners;
        }
    }

    /// Appends a corner if it `is_kept`.
    ///
    /// Without derivatives, the corner is computed first and then kept or dropped. A branch would
    /// be slower, because it would be mispredicted half the time.
    #[inline]
    fn push_if(&mut self, is_kept: bool, corner: impl FnOnce() -> Vector3<T>, owners: u8) {
        let is_worth_a_branch = carries_derivatives::<T>();
        let index = self.len();
        if (is_worth_a_branch && !is_kept) || index == POLYGON_CAPACITY {
            return;
        }
        self.corners[index] = corner();
        self.owners[index] = owners;
        self.len += u8::from(is_kept);
    }

    /// Returns the area (m²) times the unit normal about which the corners are counter-clockwise.
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

    /// Transforms the polygon to the outer frame.
    #[must_use]
    pub fn transformed(&self, pose: &Pose<T>) -> Self {
        self.mapped(|corner| pose.transformed_point(corner))
    }

    /// Returns the polygon without its derivatives.
    #[must_use]
    pub fn real(&self) -> ConvexPolygon<f64> {
        self.mapped(real_vector)
    }

    /// Returns the polygon with a function applied to each corner.
    #[inline]
    fn mapped<U: Scalar>(&self, corner: impl Fn(&Vector3<T>) -> Vector3<U>) -> ConvexPolygon<U> {
        let mut mapped = ConvexPolygon::empty();
        for (mapped_corner, source_corner) in mapped.corners.iter_mut().zip(self.corners()) {
            *mapped_corner = corner(source_corner);
        }
        (mapped.owners, mapped.len) = (self.owners, self.len);
        (mapped.closeness, mapped.coplanarity) = (self.closeness, self.coplanarity);
        mapped
    }
}

impl ConvexPolygon<f64> {
    /// Returns the polygon as a constant: all derivatives are zero.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> ConvexPolygon<T> {
        self.mapped(lift_vector)
    }
}

/// Returns the indices of the bits that are set, in ascending order.
pub(crate) fn set_bits(mut bits: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let number = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            number
        })
    })
}
