//! Poses as 4×4 homogeneous matrices, and twists as 6-vectors.

use crate::arrays::{
    Floats, Many, Numbers, array, check_finite, finite_row, named_error, numbers, short_matrix,
    wrong_shape,
};
use crate::errors::value_error;
use hydroelastic::nalgebra::{Matrix3, Vector3, Vector6};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Twist};
use pyo3::prelude::*;

/// Number of entries of a 4×4 matrix.
pub const ENTRIES: usize = 16;

/// Creates the pose of a frame as a 4×4 homogeneous matrix.
///
/// Parameters
/// ----------
/// translation : (3,) array_like, optional
///     Position (m) of the origin of the frame. Default: zero.
/// rotation_vector : (3,) array_like, optional
///     Rotation of the frame: axis times angle (rad). Default: zero.
///
/// Returns
/// -------
/// (4, 4) ndarray of float64
///     Matrix that maps coordinates in the frame to coordinates in the outer frame.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is not finite, or too large for a rotation.
#[pyfunction]
#[pyo3(signature = (translation=None, rotation_vector=None))]
pub fn pose<'py>(
    py: Python<'py>,
    translation: Option<&Bound<'py, PyAny>>,
    rotation_vector: Option<&Bound<'py, PyAny>>,
) -> PyResult<Floats<'py>> {
    let vector = |argument: Option<&Bound<'py, PyAny>>, name| match argument {
        Some(argument) => finite_row::<3>(argument, name).map(Vector3::from),
        None => Ok(Vector3::zeros()),
    };
    let translation = vector(translation, "translation")?;
    let turn = vector(rotation_vector, "rotation_vector")?;
    finite_matrix(py, &Pose::from_rotation_vector(&turn, translation))
}

/// Moves a pose by a twist in the axes of the outer frame.
///
/// The frame turns about its own origin by the angular part, and its origin moves by the linear part. Derivatives with respect to poses
/// are derivatives with respect to these twists.
///
/// Parameters
/// ----------
/// pose : (4, 4) array_like
///     Pose before the motion.
/// twist : (6,) array_like
///     Rotation vector (rad), then translation (m).
///
/// Returns
/// -------
/// (4, 4) ndarray of float64
///     Pose after the motion.
///
/// Raises
/// ------
/// HydroelasticError
///     If the pose is not rigid, or a number is not finite.
#[pyfunction]
pub fn moved_pose<'py>(
    py: Python<'py>,
    pose: &Bound<'py, PyAny>,
    twist: &Bound<'py, PyAny>,
) -> PyResult<Floats<'py>> {
    let moved = single_pose(pose, "pose")?.moved_by(&twist_of(&finite_row(twist, "twist")?));
    finite_matrix(py, &moved)
}

/// Creates a pose from the entries of its matrix, row by row.
pub fn pose_of(entries: &[f64; ENTRIES]) -> PyResult<Pose> {
    if entries[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(value_error(format!(
            "the last row of a pose must be (0, 0, 0, 1), but is {:?}",
            &entries[12..]
        )));
    }
    let rotation = Matrix3::from_fn(|row, column| entries[4 * row + column]);
    let translation = Vector3::new(entries[3], entries[7], entries[11]);
    Pose::restored(rotation, translation).map_err(value_error)
}

/// Reads one pose, or n poses.
pub fn poses(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Many<Pose>> {
    if let Some(entries) = short_matrix(argument) {
        return pose_of(&entries).map(Many::One);
    }
    let Numbers { values, shape } = numbers(argument, name)?;
    let entries = |values: &[f64]| std::array::from_fn(|index| values[index]);
    let matrices = match shape[..] {
        [4, 4] => Many::One(entries(&values)),
        [_, 4, 4] => Many::Each(values.chunks(ENTRIES).map(entries).collect()),
        _ => return Err(wrong_shape(name, "(4, 4) or (n, 4, 4)", &shape)),
    };
    matrices.mapped(name, pose_of)
}

/// Reads one pose.
pub fn single_pose(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Pose> {
    let Numbers { values, shape } = numbers(argument, name)?;
    if shape != [4, 4] {
        return Err(wrong_shape(name, "(4, 4)", &shape));
    }
    let entries = std::array::from_fn(|index| values[index]);
    pose_of(&entries).map_err(|error| named_error(name, &error))
}

/// Creates a twist from its components.
pub fn twist_of(numbers: &[f64; 6]) -> Twist {
    Twist::from_vector(&Vector6::from(*numbers))
}

/// Reads a rotation matrix.
pub fn rotation(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Matrix3<f64>> {
    let Numbers { values, shape } = numbers(argument, name)?;
    if shape != [3, 3] {
        return Err(wrong_shape(name, "(3, 3)", &shape));
    }
    check_rotation(&values, name)?;
    Ok(Matrix3::from_row_slice(&values))
}

/// Checks that nine entries are a rotation matrix.
pub fn check_rotation(entries: &[f64], name: &str) -> PyResult<()> {
    let pose = Pose::restored(Matrix3::from_row_slice(entries), Vector3::zeros());
    pose.map_err(|error| named_error(name, &value_error(error)))?;
    Ok(())
}

/// Entries of the matrix of a pose, row by row.
pub fn entries<T: Scalar>(pose: &Pose<T>) -> [T; ENTRIES] {
    let (rotation, translation) = (pose.rotation(), pose.translation());
    std::array::from_fn(|index| match (index / 4, index % 4) {
        (3, 3) => lift(1.0),
        (3, _) => lift(0.0),
        (row, 3) => translation[row],
        (row, column) => rotation[(row, column)],
    })
}

/// Converts a computed pose to an array. Returns an error if an entry is not finite.
pub fn finite_matrix<'py>(py: Python<'py>, pose: &Pose) -> PyResult<Floats<'py>> {
    check_finite(&entries(pose), "the entries of the pose")?;
    matrix(py, pose)
}

/// Converts a pose to an array.
pub fn matrix<'py>(py: Python<'py>, pose: &Pose) -> PyResult<Floats<'py>> {
    array(py, entries(pose).to_vec(), &[4, 4])
}
