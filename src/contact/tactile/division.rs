//! Division of contact polygons by the planes of a grid.
//!
//! In the plane of a polygon, the field of a taxel plane is an affine function of y. Only a polygon that is not wholly in the patch is cut by
//! the first and the last plane of the columns and of the rows. The columns and the rows are strips between planes. A linear search, which
//! begins at the strip of the previous corner, finds the strip of each corner. For a pair at rest, only the loads of the pieces are needed,
//! and `cells` adds them up along the edges. For a pair in motion, the planes of the columns cut the outline into strips, and the planes of
//! the rows cut the strips. All decisions depend only on real parts.
//!
//! Every cut divides a convex outline into two convex outlines with bitwise equal crossings. Therefore the integrals over the pieces add
//! up to the integrals over the polygon, regardless of round-off in the corners:
//!
//! - A corner on a plane, up to round-off, belongs to both outlines.
//! - If an edge is on a plane, the polygon is one outline. The other outline is this edge, without an area.
//! - If a whole polygon is on a plane, both outlines are the polygon, so such a polygon is not cut. It is in the higher column or row.

use super::cells::Cells;
use super::taxel_sums::TaxelSums;
use super::{GridBody, TaxelContact, TaxelGrid};
use crate::contact::SurfaceLaw;
use crate::contact::integrate::{Integrand, Remainder};
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::{Outline, at};
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

/// Forces of contact polygons on taxels and outside of the patch, and memory for the division.
pub(super) struct DividedForces<T> {
    pub in_taxels: TaxelSums<TaxelContact<T>>,
    /// The wrench outside of the patch, on A, in A's axes about A's origin.
    pub outside: Wrench<T>,
    cells: Cells<T>,
}

impl<T: Scalar> PartialSum for DividedForces<T> {
    fn empty() -> Self {
        Self {
            in_taxels: TaxelSums::empty(),
            outside: Wrench::zero(),
            cells: Cells::empty(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.in_taxels.merge(next.in_taxels);
        self.outside.merge(next.outside);
    }
}

/// Divides contact polygons by the planes of a grid, in A's frame.
pub(super) struct Division<T> {
    /// Planes of the columns and of the rows.
    pub planes: [Vec<AffineField<T>>; 2],
    /// Largest norms of the difference between the gradients of adjacent planes, for columns and rows. They are 0 for a flat grid.
    gradient_changes: [f64; 2],
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
        let posed = |field: AffineField| field.posed(&pose);
        let planes = grid
            .fields()
            .map(|fields| fields.map(posed).collect::<Vec<_>>());
        Self {
            gradient_changes: planes
                .each_ref()
                .map(|planes| largest_gradient_change(planes)),
            planes,
            motion,
        }
    }

    /// Returns the number of rows and the number of columns.
    pub fn shape(&self) -> [usize; 2] {
        let [columns, rows] = &self.planes;
        [rows.len() - 1, columns.len() - 1]
    }

    /// Adds the forces of a polygon.
    fn add_polygon(&self, polygon: &PlanePolygon<T>, forces: &mut DividedForces<T>) {
        if self.add_cells(polygon, &polygon.outline, forces).is_some() {
            return;
        }
        let outside = |part: &Outline<T>| {
            if let Some((wrench, _)) = self.integrated(polygon, part) {
                forces.outside += wrench;
            }
        };
        let Some(inside) = self.cut_to_patch(polygon, outside) else {
            return;
        };
        if self.add_cells(polygon, &inside, forces).is_some() {
            return;
        }
        self.visit_taxels(polygon, &inside, |taxel, part| {
            if let Some((wrench, area)) = self.integrated(polygon, part) {
                let contact = forces.in_taxels.sum_mut(taxel, self.shape());
                contact.wrench += wrench;
                contact.area += area;
            }
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

    /// Adds the forces on an outline from the loads of cells. This is faster than cutting the outline. Returns `None` if the outline is not in
    /// the patch, if planes of a family may cross in it, or if round-off makes a line cross it more than twice. Returns `None` for pairs in
    /// motion, too, because friction is integrated over the outlines of pieces.
    fn add_cells(
        &self,
        polygon: &PlanePolygon<T>,
        outline: &Outline<T>,
        forces: &mut DividedForces<T>,
    ) -> Option<()> {
        if self.motion.is_some() {
            return None;
        }
        let cells = &mut forces.cells;
        let (points, rounding) = (|| points(polygon, outline), rounding(polygon, outline));
        for (family, planes) in self.planes.iter().enumerate() {
            let strips = cells.cleared_corner_strips(family);
            let range = strips_of((planes, rounding), points(), |strip| strips.push(strip));
            let is_at_border = *range.start() == 0 || *range.end() + 2 == planes.len();
            if is_at_border && !are_between_outer_planes((planes, rounding), points())
                || !self.are_in_order(polygon, family, (&range, outline))
            {
                return None;
            }
            let lines = planes[range.clone()].iter().skip(1);
            let functions = lines.map(|plane| in_plane(polygon, plane).0);
            cells.set_lines(family, *range.start(), functions);
        }
        let plane = &polygon.plane;
        cells.divide(outline, &plane.pressure)?;
        let shape = self.shape();
        for ([column, row], load) in cells.loads(polygon.weights.still.area()) {
            let contact = forces.in_taxels.sum_mut([row, column], shape);
            contact.wrench += plane.wrench_of_load(load.total, load.by_y);
            contact.area += load.area;
        }
        Some(())
    }

    /// Returns `true` if the planes beside a range of strips certainly do not cross in an outline. May return `false` for planes that do not
    /// cross.
    fn are_in_order(
        &self,
        polygon: &PlanePolygon<T>,
        family: usize,
        (range, outline): (&RangeInclusive<usize>, &Outline<T>),
    ) -> bool {
        let change = self.gradient_changes[family] * reach(outline);
        let origin = real_vector(&Vector3::from(polygon.plane.origin));
        let planes = &self.planes[family][*range.start()..=range.end() + 1];
        let value = |plane| real_value(plane, &origin);
        change <= 0.0 || planes.is_sorted_by(|before, after| value(before) - value(after) > change)
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
        let rounding = rounding(polygon, outline);
        let mut range = strips_of((planes, rounding), points(polygon, outline), |_| {});
        if !self.are_in_order(polygon, family, (&range, outline)) {
            range = 0..=planes.len() - 2;
        }
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

    /// Returns the wrench on A, in A's axes about A's origin, and the area (m²) of an outline in the plane of a polygon. Both are multiplied by
    /// the weight of the polygon. Returns `None` if the outline has no corners.
    fn integrated(
        &self,
        polygon: &PlanePolygon<T>,
        outline: &Outline<T>,
    ) -> Option<(Wrench<T>, T)> {
        if outline.corners().is_empty() {
            return None;
        }
        let mut part = polygon.clone();
        part.set_outline(outline);
        let wrench = match &self.motion {
            Some((law, motion)) => part.wrench_in_motion(law, motion),
            None => part.elastic_wrench(),
        };
        let area = part.plane.moments[0] * lift::<T>(part.weights.still.area());
        Some((wrench, area))
    }
}

impl<T: Scalar> Integrand<T> for Division<T> {
    type Sum = DividedForces<T>;

    const OCTETS: usize = OCTETS;

    fn add(&self, source: &PolygonSource<T>, cut: &Cut, forces: &mut DividedForces<T>) {
        if let Some(polygon) = source.pressed_polygon(cut) {
            self.add_polygon(&polygon, forces);
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<T>,
        generic: GenericPairs,
        _: &mut Remainder,
        forces: &mut DividedForces<T>,
    ) {
        for octet in generic.octets {
            for index in set_bits(octet.polygons()) {
                self.add_polygon(&PlanePolygon::at(octet, index), forces);
            }
        }
    }
}

/// Calls `visit` with the index of the strip of each point. Returns the range of these indices, or 0..=0 if there are no points. The search
/// begins at the strip of the previous point, or at the estimated strip of the first point.
fn strips_of<T: Scalar>(
    (planes, rounding): (&[AffineField<T>], f64),
    points: impl Iterator<Item = Vector3<f64>>,
    mut visit: impl FnMut(usize),
) -> RangeInclusive<usize> {
    let inner = &planes[1..planes.len() - 1];
    let mut previous = None;
    let (mut first, mut last) = (usize::MAX, 0);
    for point in points {
        let is_behind = |plane: &AffineField<T>| real_value(plane, &point) >= -rounding;
        let mut strip = previous.unwrap_or_else(|| estimated_strip(planes, &point));
        while strip > 0 && !is_behind(&inner[strip - 1]) {
            strip -= 1;
        }
        while inner.get(strip).is_some_and(is_behind) {
            strip += 1;
        }
        visit(strip);
        previous = Some(strip);
        (first, last) = (first.min(strip), last.max(strip));
    }
    first.min(last)..=last
}

/// Returns whether points are between the first and the last plane, up to round-off.
fn are_between_outer_planes<T: Scalar>(
    (planes, rounding): (&[AffineField<T>], f64),
    mut points: impl Iterator<Item = Vector3<f64>>,
) -> bool {
    points.all(|point| {
        let [first, last] = [0, planes.len() - 1].map(|plane| real_value(&planes[plane], &point));
        first >= -rounding && last <= rounding
    })
}

/// Estimates the strip of a point. The estimate is exact, up to round-off, if all strips have the same width.
fn estimated_strip<T: Scalar>(planes: &[AffineField<T>], point: &Vector3<f64>) -> usize {
    let count = planes.len() - 1;
    let [before, after] = [0, count].map(|plane| real_value(&planes[plane], point));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "the result is only the start of a search, and is clamped to the strips"
    )]
    let strip = (before / (before - after) * count as f64) as usize;
    strip.min(count - 1)
}

/// Returns the largest norm of the difference between the gradients of adjacent planes.
fn largest_gradient_change<T: Scalar>(planes: &[AffineField<T>]) -> f64 {
    let change =
        |pair: &[AffineField<T>]| real_vector(&(pair[1].gradient - pair[0].gradient)).norm();
    planes.windows(2).map(change).fold(0.0, f64::max)
}

/// Returns a bound of the distances (m) from the origin of the plane to the points of an outline.
fn reach<T: Scalar>(outline: &Outline<T>) -> f64 {
    let distance = |y: &[T; 2]| real_part(y[0]).abs() + real_part(y[1]).abs();
    outline.corners().iter().map(distance).fold(0.0, f64::max)
}

/// Returns the rounding-error bound of the values of planes at the points of an outline.
fn rounding<T: Scalar>(polygon: &PlanePolygon<T>, outline: &Outline<T>) -> f64 {
    let origin = Vector3::from(polygon.plane.origin);
    ROUNDING * (real_vector(&origin).amax() + reach(outline))
}

/// Returns the corners of an outline in the plane of a polygon, in A's frame.
fn points<T: Scalar>(
    polygon: &PlanePolygon<T>,
    outline: &Outline<T>,
) -> impl Iterator<Item = Vector3<f64>> {
    let corners = outline.corners().iter();
    corners.map(|corner| real_vector(&polygon.point(*corner)))
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
