//! Division of contact polygons by the planes of a grid.
//!
//! In the plane of a polygon, the field of a taxel plane is an affine function of y. A convex polygon is first cut by the first and the
//! last plane of the columns and of the rows. A binary search finds the planes beside the first corner of the part in the
//! patch, and a walk from corner to corner finds the others. For a pair at
//! rest, only the loads of the pieces are needed. `cells` adds them up along the edges. For a pair in motion, the planes of the columns
//! cut the outline into strips, and the planes of the rows cut the strips. All decisions depend only on real parts.
//!
//! Every cut divides a convex outline into two convex outlines with bitwise equal crossings. Therefore the integrals over the pieces add
//! up to the integrals over the polygon, regardless of round-off in the corners:
//!
//! - A corner on a plane, up to round-off, belongs to both outlines.
//! - If an edge is on a plane, the polygon is one outline. The other outline is this edge, without an area.
//! - If a whole polygon is on a plane, both outlines are the polygon, so such a polygon is not cut. It is in the higher column or row.

use super::cells::Cells;
use super::{GridBody, TaxelGrid};
use crate::contact::SurfaceLaw;
use crate::contact::integrate::{Integrand, Remainder};
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::{Outline, PLANE_CAPACITY, at};
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_source::PolygonSource;
use crate::contact::sums::PartialSum;
use crate::friction::Affine;
use crate::geometry::{AffineField, set_bits};
use crate::narrow_phase::Cut;
use crate::scalar::{Scalar, lift, real_part, real_vector};
use crate::search::GenericPairs;
use crate::spatial::{Pose, Wrench};
use nalgebra::Vector3;
use std::ops::RangeInclusive;

/// Bound on the rounding error of a plane's field, relative to the size of its terms.
const ROUNDING: f64 = 1e-14;

/// Number of octets in the work item of a thread.
const OCTETS: usize = 16;

/// A part of a contact polygon in one taxel, or outside of the patch.
pub(super) struct Piece<T> {
    /// Row and column of the taxel, or `None` outside of the patch.
    pub taxel: Option<[usize; 2]>,
    /// Wrench on A, in A's axes about A's origin.
    pub wrench: Wrench<T>,
    /// Area (m²), multiplied by the weight of the polygon.
    pub area: T,
}

/// The pieces of some polygons, and memory for the division.
pub(super) struct Pieces<T> {
    pub list: Vec<Piece<T>>,
    cells: Cells<T>,
}

impl<T: Scalar> PartialSum for Pieces<T> {
    fn empty() -> Self {
        Self {
            list: Vec::new(),
            cells: Cells::empty(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.list.merge(next.list);
    }
}

/// Divides contact polygons by the planes of a grid, in A's frame.
pub(super) struct Division<T> {
    /// Planes of the columns and of the rows.
    pub planes: [Vec<AffineField<T>>; 2],
    motion: Option<(SurfaceLaw<T>, RelativeMotion<T>)>,
}

impl<T: Scalar> Division<T> {
    /// Creates the division by a grid that is fixed to a body.
    pub fn of(
        (body, grid): (GridBody, &TaxelGrid),
        pose_ab: &Pose<T>,
        motion: Option<(SurfaceLaw<T>, RelativeMotion<T>)>,
    ) -> Self {
        let pose = body.pose_in_a(pose_ab);
        Self {
            planes: grid
                .fields()
                .map(|fields| fields.map(|field| field.posed(&pose)).collect()),
            motion,
        }
    }

    /// Appends the pieces of a polygon.
    fn divide(&self, polygon: &PlanePolygon<T>, pieces: &mut Pieces<T>) {
        let mut add = |taxel, outline: &Outline<T>| {
            pieces.list.extend(self.integrated(polygon, taxel, outline));
        };
        let Some(inside) = self.cut_to_patch(polygon, |outside| add(None, outside)) else {
            return;
        };
        if self.motion.is_none() && self.add_cells(polygon, &inside, pieces).is_some() {
            return;
        }
        self.visit_taxels(polygon, &inside, |taxel, part| {
            let taxel = Some(taxel);
            pieces.list.extend(self.integrated(polygon, taxel, part));
        });
    }

    /// Visits the parts of a polygon in taxels.
    pub fn visit_parts(
        &self,
        polygon: &PlanePolygon<T>,
        visit: impl FnMut([usize; 2], &Outline<T>),
    ) {
        if let Some(inside) = self.cut_to_patch(polygon, |_| {}) {
            self.visit_taxels(polygon, &inside, visit);
        }
    }

    /// Visits the parts of an outline in the patch.
    fn visit_taxels(
        &self,
        polygon: &PlanePolygon<T>,
        inside: &Outline<T>,
        mut visit: impl FnMut([usize; 2], &Outline<T>),
    ) {
        self.visit_strips(polygon, 0, inside, |column, strip| {
            self.visit_strips(polygon, 1, strip, |row, part| visit([row, column], part));
        });
    }

    /// Returns the part of a polygon in the patch, or `None` if this part is empty. Visits the parts outside of the patch.
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

    /// Appends the pieces of an outline in the patch from the loads of cells, which is faster than cutting outlines. The pair must be at
    /// rest, because the quadrature of friction needs outlines. Returns `None` if round-off makes a line cross the outline more than twice.
    fn add_cells(
        &self,
        polygon: &PlanePolygon<T>,
        outline: &Outline<T>,
        pieces: &mut Pieces<T>,
    ) -> Option<()> {
        let Pieces { list, cells } = pieces;
        let points = points(polygon, outline);
        let points = &points[..outline.corners().len()];
        let strips = [0, 1].map(|family| Strips::of(&self.planes[family], points));
        for (family, Strips { of_corners, range }) in strips.iter().enumerate() {
            let lines = self.planes[family][range.clone()].iter().skip(1);
            let functions = lines.map(|plane| in_plane(polygon, plane).0);
            let corners = of_corners[..points.len()].iter();
            cells.set_lines(
                family,
                functions,
                corners.map(|strip| strip - range.start()),
            );
        }
        let plane = &polygon.plane;
        cells.divide(outline, &plane.pressure)?;
        let weight = lift::<T>(polygon.weights.still.area());
        let [first_column, first_row] = strips.each_ref().map(|strips| *strips.range.start());
        for ([column, row], load) in cells.loads() {
            let by_y = load.by_y.map(|moment| moment * weight);
            list.push(Piece {
                taxel: Some([first_row + row, first_column + column]),
                wrench: plane.wrench_of_load(load.total * weight, by_y),
                area: load.area * weight,
            });
        }
        Some(())
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
        let points = points(polygon, outline);
        let Strips { range, .. } = Strips::of(planes, &points[..outline.corners().len()]);
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

    /// Integrates traction over an outline in the plane of a polygon. Returns `None` if the outline has no corners.
    fn integrated(
        &self,
        polygon: &PlanePolygon<T>,
        taxel: Option<[usize; 2]>,
        outline: &Outline<T>,
    ) -> Option<Piece<T>> {
        if outline.corners().is_empty() {
            return None;
        }
        let mut piece = polygon.clone();
        piece.set_outline(outline);
        let wrench = match &self.motion {
            Some((law, motion)) => piece.wrench_in_motion(law, motion),
            None => piece.elastic_wrench(),
        };
        let area = piece.plane.moments[0] * lift::<T>(piece.weights.still.area());
        Some(Piece {
            taxel,
            wrench,
            area,
        })
    }
}

impl<T: Scalar> Integrand<T> for Division<T> {
    type Sum = Pieces<T>;

    const OCTETS: usize = OCTETS;

    fn add(&self, source: &PolygonSource<T>, cut: &Cut, pieces: &mut Pieces<T>) {
        if let Some(polygon) = source.pressed_polygon(cut) {
            self.divide(&polygon, pieces);
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<T>,
        generic: GenericPairs,
        _: &mut Remainder,
        pieces: &mut Pieces<T>,
    ) {
        for octet in generic.octets {
            for index in set_bits(octet.polygons()) {
                self.divide(&PlanePolygon::at(octet, index).lifted(), pieces);
            }
        }
    }
}

/// The strips between ordered planes that contain the corners of an outline.
struct Strips {
    of_corners: [usize; PLANE_CAPACITY],
    /// 0..=0 for an outline without corners.
    range: RangeInclusive<usize>,
}

impl Strips {
    /// Finds the strip of each corner: by a binary search for the first corner, and by a walk from the strip of the previous corner for all
    /// other corners.
    fn of<T: Scalar>(planes: &[AffineField<T>], corners: &[Vector3<f64>]) -> Self {
        let inner = &planes[1..planes.len() - 1];
        let is_behind = |plane: &AffineField<T>, point: &Vector3<f64>| {
            real_value(plane, point) >= -ROUNDING * point.amax()
        };
        let mut strip = corners.first().map_or(0, |first| {
            inner.partition_point(|plane| is_behind(plane, first))
        });
        let mut of_corners = [0; PLANE_CAPACITY];
        let (mut first, mut last) = (usize::MAX, 0);
        for (of_corner, point) in of_corners.iter_mut().zip(corners) {
            while strip > 0 && !is_behind(&inner[strip - 1], point) {
                strip -= 1;
            }
            while inner
                .get(strip)
                .is_some_and(|plane| is_behind(plane, point))
            {
                strip += 1;
            }
            *of_corner = strip;
            (first, last) = (first.min(strip), last.max(strip));
        }
        Self {
            of_corners,
            range: first.min(last)..=last,
        }
    }
}

/// Returns the corners of an outline in the plane of a polygon, in A's frame, padded with zeros.
fn points<T: Scalar>(
    polygon: &PlanePolygon<T>,
    outline: &Outline<T>,
) -> [Vector3<f64>; PLANE_CAPACITY] {
    let mut points = [Vector3::zeros(); PLANE_CAPACITY];
    for (point, corner) in points.iter_mut().zip(outline.corners()) {
        *point = real_vector(&polygon.point(*corner));
    }
    points
}

fn real_value<T: Scalar>(plane: &AffineField<T>, point: &Vector3<f64>) -> f64 {
    let AffineField { gradient, offset } = plane;
    let [x, y, z] = [gradient.x, gradient.y, gradient.z].map(real_part);
    x * point.x + y * point.y + z * point.z + real_part(*offset)
}

/// Returns a field as an affine function of the coordinates in the plane of a polygon, and the rounding-error bound of its values.
pub(super) fn in_plane<T: Scalar>(
    polygon: &PlanePolygon<T>,
    field: &AffineField<T>,
) -> (Affine<T>, f64) {
    let [e1, e2, _] = polygon.plane.axes.map(Vector3::from);
    let origin = Vector3::from(polygon.plane.origin);
    let size = real_part(field.offset).abs() + real_vector(&origin).amax();
    let gradient = &field.gradient;
    let function = [field.at(&origin), e1.dot(gradient), e2.dot(gradient)];
    (function, ROUNDING * size)
}
