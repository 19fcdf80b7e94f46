use super::{FileError, extension::known_extension, obj, stl};
use crate::mesh::TriangleSurface;
use nalgebra::Vector3;
use std::path::Path;

/// What the name of a surface file can end in.
const EXTENSIONS: &[&str] = &["obj", "stl"];

/// Triangles with corners of their own, in the file's unit.
pub(super) type Soup = Vec<[Vector3<f64>; 3]>;

/// Reads the closed surface of a rigid body, in the format that the extension of the file's name tells, in upper or
/// lower case:
///
/// - `.stl`: binary or ASCII; all solids of the file together. Its normals are not read: the order of the corners says which
///   side is outside.
/// - `.obj`: the vertices and faces of all groups together. A face of more than three corners is cut into triangles by its
///   diagonals from one corner, the first from which they all run through the face.
///
/// Text is read in double precision; binary files have single precision.
///
/// Neither format has a unit: a coordinate of 1 in the file is `unit` (m), 0.001 for the millimeters of most CAD programs.
/// Vertices at exactly the same place become one.
///
/// # Errors
/// If the file cannot be read or understood, the unit is not positive and finite, or [`TriangleSurface::from_soup`] refuses
/// the triangles; its indices do not count triangles of which two corners are the same.
///
/// ```no_run
/// use hydroelastic::io::read_triangle_surface;
///
/// let gripper = read_triangle_surface("gripper.stl", 0.001)?;
/// println!("{} triangles, {} m³", gripper.triangles().len(), gripper.volume());
/// # Ok::<(), hydroelastic::io::FileError>(())
/// ```
pub fn read_triangle_surface(
    path: impl AsRef<Path>,
    unit: f64,
) -> Result<TriangleSurface, FileError> {
    let path = path.as_ref();
    let extension = known_extension(path, EXTENSIONS)?;
    if !(unit > 0.0 && unit.is_finite()) {
        let path = path.into();
        return Err(FileError::Unit { path, found: unit });
    }
    let bytes = std::fs::read(path).map_err(|source| FileError::Read {
        path: path.into(),
        source,
    })?;
    let mut soup = match extension {
        "stl" => stl::read(path, bytes)?,
        _ => obj::read(path, &bytes)?,
    };
    for corner in soup.iter_mut().flatten() {
        *corner *= unit;
    }
    TriangleSurface::from_soup(&soup).map_err(|source| FileError::Surface {
        path: path.into(),
        source,
    })
}
