use super::TaxelGridError;
use crate::geometry::{Aabb, AffineField};
use crate::scalar::portable::sin_cos;
use crate::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use std::cmp::Ordering;
use std::f64::consts::PI;

/// Names of the two families of planes, for errors.
const FAMILIES: [&str; 2] = ["columns", "rows"];

/// Largest number of columns and of rows.
const MOST: usize = 4096;

/// Smallest sine of the angle between the planes of a column and of a row.
const LEAST_SINE: f64 = 1e-6;

/// A grid of taxels on a patch of a body's surface, fixed in the body's frame.
///
/// Column c is the space between the planes c and c + 1 of the columns, and row r is the space between the planes r and r + 1 of the rows.
/// A taxel is the intersection of its column and its row. It is unbounded along its normal, so both faces of a thin plate are in the
/// patch.
///
/// Each taxel has its own orthonormal axes, fixed in the body's frame. The first axis is the normal of the middle of its column, in the
/// direction of ascending columns. The third axis is perpendicular to this normal and to the normal of the middle of its row. The second
/// axis completes a right-handed frame. If the grid is flat, cylindrical or a dome, the third axis points out of the body if the z axis of
/// the frame does.
#[derive(Debug, Clone, PartialEq)]
pub struct TaxelGrid {
    /// Planes of the columns and of the rows: fields with unit gradients, which are zero on the plane (m).
    planes: [Vec<Plane>; 2],
}

/// Unit normal and value at the origin (m) of a plane's field.
type Plane = (Vector3<f64>, f64);

impl TaxelGrid {
    /// Creates a grid on the rectangle x ∈ ±size\[0\]/2, y ∈ ±size\[1\]/2 (m) of the plane z = 0 of a frame in the body. Columns follow
    /// each other along x, and rows along y. The axes of all taxels are those of the frame. `counts` has the numbers of columns and rows.
    ///
    /// # Errors
    /// Returns an error if the frame is not a pose, a length is not positive, or a count is not from 1 to 4096.
    pub fn flat(frame: &Pose, size: [f64; 2], counts: [usize; 2]) -> Result<Self, TaxelGridError> {
        check_length("width", size[0])?;
        check_length("height", size[1])?;
        let columns = parallel(Vector3::x(), size[0], counts[0]);
        Self::in_frame(
            frame,
            [columns, parallel(Vector3::y(), size[1], counts[1])],
            counts,
        )
    }

    /// Creates a grid on a cylinder about the y axis of a frame in the body. Columns are sectors of the angle from the z axis towards the
    /// x axis, from −angle/2 to angle/2 (rad). Rows follow each other along y ∈ ±length/2 (m). The axes of a taxel are the
    /// circumferential direction, y, and the radial direction at the middle of its column.
    ///
    /// # Errors
    /// Returns an error if the frame is not a pose, the angle is not between 0 and π, the length is not positive, or a count is not from
    /// 1 to 4096.
    pub fn cylindrical(
        frame: &Pose,
        angle: f64,
        length: f64,
        counts: [usize; 2],
    ) -> Result<Self, TaxelGridError> {
        check_angle("angle", angle)?;
        check_length("length", length)?;
        let columns = pencil(Vector3::x(), angle, counts[0]);
        Self::in_frame(
            frame,
            [columns, parallel(Vector3::y(), length, counts[1])],
            counts,
        )
    }

    /// Creates a grid on a dome around the z axis of a frame in the body, for example the cap of a fingertip with its center at the
    /// frame's origin. Columns are sectors about the y axis, as in [`Self::cylindrical`], and rows are sectors about the x axis. `angles`
    /// are the total angles (rad) of all columns and of all rows. The third axis of a taxel is the radial direction at its middle.
    ///
    /// # Errors
    /// Returns an error if the frame is not a pose, an angle is not between 0 and π, or a count is not from 1 to 4096.
    pub fn dome(
        frame: &Pose,
        angles: [f64; 2],
        counts: [usize; 2],
    ) -> Result<Self, TaxelGridError> {
        check_angle("angle of the columns", angles[0])?;
        check_angle("angle of the rows", angles[1])?;
        let columns = pencil(Vector3::x(), angles[0], counts[0]);
        Self::in_frame(
            frame,
            [columns, pencil(Vector3::y(), angles[1], counts[1])],
            counts,
        )
    }

    /// Creates a grid from planes in the body's frame, for a patch with its own parametrization. A plane is the set of points at which its
    /// field is zero, and its gradient points towards higher columns or rows. `patch` is a box around the part of the surface that the
    /// taxels cover, in the body's frame. The planes may cross outside of the box. Contact outside of the box counts once, but in an
    /// arbitrary taxel.
    ///
    /// # Errors
    /// Returns an error in these cases:
    /// - a family has less than 2 or more than 4097 planes;
    /// - a plane is not finite or has no gradient;
    /// - the box is not finite, or a lower coordinate exceeds the upper coordinate;
    /// - planes of a family cross in the box or are out of order;
    /// - a column is parallel to a row.
    pub fn new(
        columns: &[AffineField],
        rows: &[AffineField],
        patch: &Aabb,
    ) -> Result<Self, TaxelGridError> {
        let families = [columns, rows];
        for (family, planes) in FAMILIES.into_iter().zip(families) {
            check_count(family, planes.len().saturating_sub(1))?;
            for (plane, field) in planes.iter().enumerate() {
                check_plane(family, plane, field)?;
            }
        }
        let size = patch.upper - patch.lower;
        if !size.iter().all(|size| size.is_finite() && *size >= 0.0) {
            return Err(TaxelGridError::Patch {
                lower: patch.lower.into(),
                upper: patch.upper.into(),
            });
        }
        let grid = Self {
            planes: families.map(|planes| planes.iter().map(normalized).collect()),
        };
        grid.check_order(&corners(patch))?;
        grid.check_axes()?;
        Ok(grid)
    }

    /// Creates a grid from planes in a frame in the body.
    fn in_frame(
        frame: &Pose,
        planes: [Vec<Plane>; 2],
        counts: [usize; 2],
    ) -> Result<Self, TaxelGridError> {
        for (family, count) in FAMILIES.into_iter().zip(counts) {
            check_count(family, count)?;
        }
        let frame = frame.checked()?;
        let posed = |(normal, offset): Plane| {
            let normal = frame.rotation() * normal;
            (normal, offset - normal.dot(frame.translation()))
        };
        Ok(Self {
            planes: planes.map(|family| family.into_iter().map(posed).collect()),
        })
    }

    /// Returns the number of columns.
    #[must_use]
    pub fn column_count(&self) -> usize {
        self.planes[0].len() - 1
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.planes[1].len() - 1
    }

    /// Returns the number of rows and the number of columns.
    pub(super) fn shape(&self) -> [usize; 2] {
        [self.row_count(), self.column_count()]
    }

    /// Returns the axes of a taxel as columns, in the body's axes: two tangential directions, and the normal.
    ///
    /// # Panics
    /// Panics if the grid has no such taxel.
    #[must_use]
    pub fn axes(&self, row: usize, column: usize) -> Matrix3<f64> {
        let [across, along] = [(0, column), (1, row)].map(|(family, index)| {
            let planes = &self.planes[family];
            (planes[index].0 + planes[index + 1].0).normalize()
        });
        let normal = across.cross(&along).normalize();
        Matrix3::from_columns(&[across, normal.cross(&across), normal])
    }

    /// Returns the row and the column of the taxel that contains a point (m, in the body's frame), or `None` outside of the patch.
    #[must_use]
    pub fn taxel_at(&self, point: &Vector3<f64>) -> Option<[usize; 2]> {
        let [column, row] = self.planes.each_ref().map(|planes| {
            let is_inside = |plane: &Plane, sign: f64| sign * value(plane, point) >= 0.0;
            let (first, last) = (&planes[0], &planes[planes.len() - 1]);
            let inner = &planes[1..planes.len() - 1];
            (is_inside(first, 1.0) && is_inside(last, -1.0))
                .then(|| inner.partition_point(|plane| is_inside(plane, 1.0)))
        });
        Some([row?, column?])
    }

    /// Returns the fields of the planes of the columns and of the rows.
    pub(super) fn fields(&self) -> [impl Iterator<Item = AffineField>; 2] {
        self.planes.each_ref().map(|planes| {
            planes
                .iter()
                .map(|&(gradient, offset)| AffineField { gradient, offset })
        })
    }

    /// Checks that no point of the box with these corners is in front of a plane and behind the previous plane. The part of the box in
    /// front of the plane is convex. It contains a point behind the previous plane only if one of its corners is behind the previous plane.
    fn check_order(&self, corners: &[Vector3<f64>; 8]) -> Result<(), TaxelGridError> {
        for (family, planes) in FAMILIES.into_iter().zip(&self.planes) {
            for (plane, pair) in planes.windows(2).enumerate() {
                let behind = |point: &Vector3<f64>| value(&pair[0], point) <= 0.0;
                if let Some(point) = corners_in_front(corners, &pair[1]).find(behind) {
                    let point = point.into();
                    return Err(TaxelGridError::Crossing {
                        family,
                        plane,
                        point,
                    });
                }
            }
        }
        Ok(())
    }

    fn check_axes(&self) -> Result<(), TaxelGridError> {
        for column in 0..self.column_count() {
            for row in 0..self.row_count() {
                let [c, r] = [(0, column), (1, row)]
                    .map(|(family, i)| self.planes[family][i].0 + self.planes[family][i + 1].0);
                if c.cross(&r)
                    .norm()
                    .partial_cmp(&LEAST_SINE)
                    .is_none_or(Ordering::is_le)
                {
                    return Err(TaxelGridError::Parallel { column, row });
                }
            }
        }
        Ok(())
    }
}

/// Returns `count` + 1 parallel planes that divide `size` into equal parts.
fn parallel(normal: Vector3<f64>, size: f64, count: usize) -> Vec<Plane> {
    let offset = |i: usize| (normal, size * (0.5 - i as f64 / count as f64));
    (0..=count.min(MOST)).map(offset).collect()
}

/// Returns `count` + 1 planes through the axis z × `across` that divide an angle about the z axis into equal parts.
fn pencil(across: Vector3<f64>, angle: f64, count: usize) -> Vec<Plane> {
    let plane = |i: usize| {
        let (sine, cosine) = sin_cos(angle * (i as f64 / count as f64 - 0.5));
        (across * cosine - Vector3::z() * sine, 0.0)
    };
    (0..=count.min(MOST)).map(plane).collect()
}

fn value((normal, offset): &Plane, point: &Vector3<f64>) -> f64 {
    normal.dot(point) + offset
}

fn normalized(field: &AffineField) -> Plane {
    let norm = field.gradient.norm();
    (field.gradient / norm, field.offset / norm)
}

/// Returns the corners of a box. Bit k of the index selects the upper coordinate k.
fn corners(patch: &Aabb) -> [Vector3<f64>; 8] {
    std::array::from_fn(|corner| {
        Vector3::from_fn(|k, _| {
            let bound = if corner >> k & 1 == 1 {
                patch.upper
            } else {
                patch.lower
            };
            bound[k]
        })
    })
}

/// Returns the corners of the part of a box in front of a plane: corners of the box, and the points at which its edges cross the plane.
fn corners_in_front<'a>(
    corners: &'a [Vector3<f64>; 8],
    plane: &'a Plane,
) -> impl Iterator<Item = Vector3<f64>> + 'a {
    let edges = (0..8_usize).flat_map(|corner| {
        let upper = [1, 2, 4].map(|bit| corner | bit);
        upper
            .into_iter()
            .filter(move |&end| end != corner)
            .map(move |end| [corner, end])
    });
    let crossing = move |[from, to]: [usize; 2]| {
        let (from, to) = (corners[from], corners[to]);
        let (before, after) = (value(plane, &from), value(plane, &to));
        (before * after < 0.0).then(|| from + (to - from) * (before / (before - after)))
    };
    let in_front = corners.iter().filter(|corner| value(plane, corner) >= 0.0);
    in_front.copied().chain(edges.filter_map(crossing))
}

fn check_count(family: &'static str, count: usize) -> Result<(), TaxelGridError> {
    if (1..=MOST).contains(&count) {
        return Ok(());
    }
    Err(TaxelGridError::Count {
        family,
        count,
        most: MOST,
    })
}

fn check_length(quantity: &'static str, value: f64) -> Result<(), TaxelGridError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(TaxelGridError::Length { quantity, value })
    }
}

fn check_angle(quantity: &'static str, value: f64) -> Result<(), TaxelGridError> {
    if value > 0.0 && value < PI {
        Ok(())
    } else {
        Err(TaxelGridError::Angle { quantity, value })
    }
}

fn check_plane(
    family: &'static str,
    plane: usize,
    &AffineField { gradient, offset }: &AffineField,
) -> Result<(), TaxelGridError> {
    let norm = gradient.norm();
    if norm > 0.0 && norm.is_finite() && offset.is_finite() {
        return Ok(());
    }
    Err(TaxelGridError::Plane {
        family,
        plane,
        gradient: gradient.into(),
        offset,
    })
}
