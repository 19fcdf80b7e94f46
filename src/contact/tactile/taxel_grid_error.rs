use crate::spatial::PoseError;

/// The reason why a grid of taxels cannot be created.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TaxelGridError {
    /// The frame of the patch is not finite or not rigid.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// A grid has no columns or no rows, or too many.
    #[error("a grid of taxels must have from 1 to {most} {family}, but has {count}")]
    Count {
        /// `"columns"` or `"rows"`.
        family: &'static str,
        /// Number of columns or rows.
        count: usize,
        /// Largest number.
        most: usize,
    },
    /// A length of the patch is not a positive number.
    #[error("the {quantity} of a grid of taxels must be positive and finite, but is {value} m")]
    Length {
        /// Name of the length.
        quantity: &'static str,
        /// Length (m).
        value: f64,
    },
    /// An angle of the patch is out of range.
    #[error(
        "the {quantity} of a grid of taxels must be more than 0 and less than π rad, but is {value} rad; use several grids for a larger patch"
    )]
    Angle {
        /// Name of the angle.
        quantity: &'static str,
        /// Angle (rad).
        value: f64,
    },
    /// A plane has a number that is not finite, or no normal.
    #[error(
        "plane {plane} of the {family} must have finite numbers and a gradient other than zero, but has the gradient {gradient:?} and the offset {offset}"
    )]
    Plane {
        /// `"columns"` or `"rows"`.
        family: &'static str,
        /// Index of the plane.
        plane: usize,
        /// Gradient of the plane's field.
        gradient: [f64; 3],
        /// Value of the plane's field at the origin.
        offset: f64,
    },
    /// The box around a patch is not finite, or a lower coordinate exceeds the upper coordinate.
    #[error(
        "the box around a patch must be finite, with lower ≤ upper in each coordinate, but lower is {lower:?} m and upper is {upper:?} m"
    )]
    Patch {
        /// Lower corner (m).
        lower: [f64; 3],
        /// Upper corner (m).
        upper: [f64; 3],
    },
    /// Planes are out of order, or cross each other in the patch.
    #[error(
        "plane {plane} of the {family} must lie behind plane {next} everywhere in the patch, but the point {point:?} m is in front of plane {next} and not in front of plane {plane}; sort the planes, or use a smaller patch",
        next = plane + 1
    )]
    Crossing {
        /// `"columns"` or `"rows"`.
        family: &'static str,
        /// Index of the first of the two planes.
        plane: usize,
        /// Point of the patch (m) that is in front of the second plane but not in front of the first plane, in the body's frame.
        point: [f64; 3],
    },
    /// A column and a row are parallel.
    #[error(
        "column {column} and row {row} of a grid of taxels must not be parallel, because the normal of a taxel is perpendicular to both"
    )]
    Parallel {
        /// Index of the column.
        column: usize,
        /// Index of the row.
        row: usize,
    },
}
