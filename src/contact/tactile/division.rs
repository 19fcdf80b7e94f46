//! Division of contact polygons by the planes of a grid.
//!
//! In the plane of a polygon, the field of a taxel plane is an affine function of y. A convex polygon is first cut by the first and the last
//! plane of the columns and of the rows. A binary search finds the planes between the corners of the part in the patch. For a pair at
//! rest, only moments of the pieces are needed, which `cells` adds up along the edges. For a pair in motion, the planes of the columns cut
//! the outline into strips, and the planes of the rows cut the strips. Decisions depend on real parts.
//!
//! Every cut divides a convex outline into two convex outlines with the same crossings, up to the last bit. Therefore the moments of the
//! pieces add up to those of the polygon, wherever round-off puts a corner:
//!
//! - A corner on a plane, up to round-off, belongs to both outlines.
//! - If an edge is on a plane, the polygon is one outline. The other outline is this edge, without an area.
//! - If a whole polygon is on a plane, both outlines are the polygon, so such a polygon is not cut. It is in the higher column or row.

use super::TaxelGrid;
use super::cells::Cells;
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::{Outline, at};
use crate::contact::plane_polygon::PlanePolygon;
use crate::friction::Affine;
use crate::geometry::AffineField;
use crate::scalar::{Scalar, lift, real_part, real_vector};
use crate::spatial::{Pose, Wrench};
use nalgebra::Vector3;
use std::ops::RangeInclusive;

/// Bound on the rounding error of a plane's field, relative to the size of its terms.
const ROUNDING: f64 = 1e-14;

/// A part of a contact polygon in one taxel, or outside of the patch.
pub(super) struct Piece<T> {
    /// Row and column of the taxel, or `None` outside of the patch.
    pub taxel: Option<[usize; 2]>,
    /// Wrench on A, in A's axes about A's origin.
    pub wrench: Wrench<T>,
    /// Area (m²), multiplied by the weight of the polygon.
    pub area: T,
}

/// Divides contact polygons by the planes of a grid, in A's frame.
pub(super) struct Division<T> {
    /// Planes of the columns and of the rows.
    planes: [Vec<AffineField<T>>; 2],
    motion: Option<(SurfaceLaw<T>, RelativeMotion<T>)>,
}

impl<T: Scalar> Division<T> {
    /// Creates the division by a grid whose body has this pose in A's frame.
    pub fn new(
        grid: &TaxelGrid,
        pose: &Pose<T>,
        motion: Option<(SurfaceLaw<T>, RelativeMotion<T>)>,
    ) -> Self {
        Self {
            planes: grid
                .fields()
                .map(|fields| fields.map(|field| field.posed(pose)).collect()),
            motion,
        }
    }

    /// Appends the pieces of a polygon.
    pub fn divide(&self, polygon: &PlanePolygon<T>, pieces: &mut Vec<Piece<T>>) {
        let mut piece = polygon.clone();
        let mut add = |taxel, outline: &Outline<T>| {
            pieces.extend(self.integrated(&mut piece, taxel, outline));
        };
        let Some(inside) = self.cut_to_patch(polygon, |outside| add(None, outside)) else {
            return;
        };
        if let Some(cells) = self.cells(polygon, &inside) {
            pieces.extend(cells);
            return;
        }
        let add_strip = |column, strip: &Outline<T>| {
            self.visit_strips(polygon, 1, strip, |row, part: &Outline<T>| {
                add(Some([row, column]), part);
            });
        };
        self.visit_strips(polygon, 0, &inside, add_strip);
    }

    /// Returns the part of a polygon in the patch, if any. Visits the parts outside of it.
    fn cut_to_patch(
        &self,
        polygon: &PlanePolygon<T>,
        mut outside: impl FnMut(&Outline<T>),
    ) -> Option<Outline<T>> {
        let mut inside = polygon.outline;
        for planes in &self.planes {
            for (plane, sign) in [(&planes[0], 1.0), (&planes[planes.len() - 1], -1.0)] {
                let (bound, zero) = in_plane(polygon, plane);
                let bound = bound.map(|coefficient| coefficient * sign);
                let is_inside = |y: &[T; 2]| real_part(at(&bound, y)) >= -zero;
                if !inside.corners().iter().all(is_inside) {
                    let [behind, in_front] = inside.split(&bound, zero);
                    outside(&behind);
                    inside = in_front;
                }
            }
        }
        (!inside.corners().is_empty()).then_some(inside)
    }

    /// Returns the pieces of an outline in the patch from the moments of cells, which is faster than cutting outlines. Returns `None` if the
    /// pair is in motion, because the quadrature of friction needs outlines, or if planes are out of order.
    fn cells(
        &self,
        polygon: &PlanePolygon<T>,
        outline: &Outline<T>,
    ) -> Option<impl Iterator<Item = Piece<T>>> {
        if self.motion.is_some() {
            return None;
        }
        let mut zero = 0.0_f64;
        let mut first = [0; 2];
        let functions = [0, 1].map(|family| {
            let planes = &self.planes[family];
            let range = strips(planes, polygon, outline);
            first[family] = *range.start();
            let lines = planes[range].iter().skip(1).map(|plane| {
                let (function, rounding) = in_plane(polygon, plane);
                zero = zero.max(rounding);
                function
            });
            lines.collect()
        });
        let cells = Cells::of(outline, functions, zero)?.into_moments();
        let mut piece = polygon.plane;
        let weight = lift::<T>(polygon.weights.still.area());
        Some(cells.map(move |([column, row], moments)| {
            piece.moments = moments;
            Piece {
                taxel: Some([first[1] + row, first[0] + column]),
                wrench: piece.elastic_wrench(weight),
                area: moments[0] * weight,
            }
        }))
    }

    /// Visits the parts of an outline in the columns (family 0) or in the rows (family 1), with their indices.
    fn visit_strips(
        &self,
        polygon: &PlanePolygon<T>,
        family: usize,
        outline: &Outline<T>,
        mut visit: impl FnMut(usize, &Outline<T>),
    ) {
        let planes = &self.planes[family];
        let range = strips(planes, polygon, outline);
        let mut rest = *outline;
        for strip in range.clone().skip(1) {
            let (function, zero) = in_plane(polygon, &planes[strip]);
            let is_on_plane = |y: &[T; 2]| real_part(at(&function, y)).abs() <= zero;
            if rest.corners().iter().all(is_on_plane) {
                continue;
            }
            let [before, after] = rest.split(&function, zero);
            visit(strip - 1, &before);
            rest = after;
        }
        visit(*range.end(), &rest);
    }

    /// Integrates traction over an outline in the plane of `piece`, whose own outline is overwritten. Returns `None` if the outline has no
    /// corners.
    fn integrated(
        &self,
        piece: &mut PlanePolygon<T>,
        taxel: Option<[usize; 2]>,
        outline: &Outline<T>,
    ) -> Option<Piece<T>> {
        if outline.corners().is_empty() {
            return None;
        }
        let wrench = if let Some((law, motion)) = &self.motion {
            piece.set_outline(outline);
            piece.wrench_in_motion(law, motion)
        } else {
            piece.plane.moments = outline.moments();
            piece.elastic_wrench()
        };
        let area = piece.plane.moments[0] * lift::<T>(piece.weights.still.area());
        Some(Piece {
            taxel,
            wrench,
            area,
        })
    }
}

/// Returns the indices of the strips between ordered planes that contain the corners of an outline.
fn strips<T: Scalar>(
    planes: &[AffineField<T>],
    polygon: &PlanePolygon<T>,
    outline: &Outline<T>,
) -> RangeInclusive<usize> {
    let inner = &planes[1..planes.len() - 1];
    let (mut first, mut last) = (inner.len(), 0);
    for corner in outline.corners() {
        let point = real_vector(&polygon.point(*corner));
        let strip = inner.partition_point(|plane| real_value(plane, &point) >= 0.0);
        (first, last) = (first.min(strip), last.max(strip));
    }
    first..=last
}

fn real_value<T: Scalar>(plane: &AffineField<T>, point: &Vector3<f64>) -> f64 {
    let AffineField { gradient, offset } = plane;
    let [x, y, z] = [gradient.x, gradient.y, gradient.z].map(real_part);
    x * point.x + y * point.y + z * point.z + real_part(*offset)
}

/// Returns a field as an affine function of the coordinates in the plane of a polygon, and the rounding-error bound of its values.
fn in_plane<T: Scalar>(polygon: &PlanePolygon<T>, field: &AffineField<T>) -> (Affine<T>, f64) {
    let [e1, e2, _] = polygon.plane.axes.map(Vector3::from);
    let origin = Vector3::from(polygon.plane.origin);
    let size = real_part(field.offset).abs() + real_vector(&origin).amax();
    let gradient = &field.gradient;
    let function = [field.at(&origin), e1.dot(gradient), e2.dot(gradient)];
    (function, ROUNDING * size)
}
