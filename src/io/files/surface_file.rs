use super::{FileError, extension::known_extension, obj, stl, vtk};
use crate::mesh::TriangleSurface;
use std::path::Path;

/// Extensions of surface files.
const EXTENSIONS: &[&str] = &["obj", "stl", "vtk", "vtp"];

/// Reads the closed surface (m) of a rigid body. The extension of the file name, in upper or lower case, selects the format:
///
/// - `.stl`: binary or ASCII. All solids of the file are merged. The normals in the file are ignored, because the order of the
///   corners determines the outer side.
/// - `.obj`: The vertices and faces of all groups are merged. A face with more than 3 corners is triangulated as a fan. Its apex is
///   the first corner whose diagonals all lie in the face.
///
/// - `.vtk`, `.vtp`: VTK PolyData, legacy or XML. The contents decide between these two. Polygons and triangle strips are read.
///
/// Text files are read in double precision. Binary files have single precision.
///
/// No format has a unit. A coordinate of 1 in the file becomes `unit` (m). Use 0.001 for the millimeters of most CAD programs.
/// Vertices with exactly equal coordinates are merged.
///
/// # Errors
/// - If the file cannot be read or parsed.
/// - If the unit is not positive and finite.
/// - If [`TriangleSurface::from_soup`] returns an error. Its indices do not count triangles with two equal corners.
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
        "vtk" | "vtp" => {
            let soup = vtk::read_polygons(path, &bytes)?;
            let corners = |triangle: &[usize; 3]| triangle.map(|vertex| soup.vertices[vertex]);
            soup.triangles.iter().map(corners).collect()
        }
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
