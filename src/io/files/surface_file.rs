use super::mesh_file::file_bytes;
use super::{
    FileError, Placement, collada, extension::known_extension, gltf, gmsh, mujoco, obj, off, ply,
    stl, vtk,
};
use crate::mesh::{TriangleSoup, TriangleSurface};
use nalgebra::Matrix3;
use std::path::Path;

/// Extensions of surface files.
const EXTENSIONS: &[&str] = &[
    "dae", "glb", "gltf", "msh", "obj", "off", "ply", "stl", "vtk", "vtp", "vtu",
];

/// Reads the closed surface (m) of a rigid body: the triangles of [`read_triangles`] as [`TriangleSoup::closed`] repairs them.
///
/// [`TriangleSurface::warnings`] reports repairs, overlapping components and an unusual size.
///
/// # Errors
/// Returns the errors of [`read_triangles`] and of [`TriangleSoup::closed`].
///
/// ```no_run
/// use hydroelastic::io::{Placement, read_triangle_surface};
///
/// let gripper = read_triangle_surface("gripper.stl", &Placement::from_unit(0.001))?;
/// println!("{} triangles, {} m³", gripper.triangles().len(), gripper.volume());
/// for warning in gripper.warnings() {
///     println!("{warning}");
/// }
/// # Ok::<(), hydroelastic::io::FileError>(())
/// ```
pub fn read_triangle_surface(
    path: impl AsRef<Path>,
    placement: &Placement,
) -> Result<TriangleSurface, FileError> {
    let path = path.as_ref();
    let soup = read_triangles(path, placement)?;
    soup.closed().map_err(|source| FileError::Surface {
        path: path.into(),
        source,
    })
}

/// Reads triangles (m), which need not be closed. The extension of the file name, in upper or lower case, selects the format:
///
/// - `.stl`: binary or ASCII. All solids of the file are merged. The normals in the file are ignored, because the order of the
///   corners determines the outer side.
/// - `.obj`, `.off`, `.ply`: PLY files may be binary. All groups are merged. Faces with more than 3 corners are cut into triangles.
///   Faces with fewer corners are ignored.
/// - `.vtk`, `.vtp`, `.vtu`: VTK PolyData or unstructured grid, legacy or XML. The contents decide. Polygons and triangle strips are
///   read. Points and lines are ignored. A grid with tetrahedra or other solids is an error, because its faces may be inside them.
/// - `.msh`: binary mesh of MuJoCo. The normals in the file are ignored. A file of Gmsh is an error that names
///   [`read_mesh`](super::read_mesh).
/// - `.glb`, `.gltf`: glTF 2.0 with embedded buffers. The parts of the scene are placed by their nodes.
/// - `.dae`: COLLADA. The parts of the scene are placed by their nodes, and the unit of the file is converted to meters.
///
/// The up axis of glTF files (y) and COLLADA files is rotated onto z before the placement is applied. Only the factors of
/// [`Placement::scale`] refer to the axes of the file.
///
/// Text files are read in double precision. STL, OBJ, OFF, PLY, VTK and MuJoCo's files have no unit: set [`Placement::unit`], for example to
/// 0.001 for most CAD programs. glTF and COLLADA files are converted to meters, so their unit is 1.
///
/// # Errors
/// - If the extension is unknown, or the file cannot be read or parsed.
/// - If the unit is not positive and finite, or a scale is zero or not finite.
pub fn read_triangles(
    path: impl AsRef<Path>,
    placement: &Placement,
) -> Result<TriangleSoup, FileError> {
    let path = path.as_ref();
    placement.check(path)?;
    let (mut soup, rotation) = read_in_file_axes(path)?;
    for vertex in &mut soup.vertices {
        *vertex = rotation * *vertex;
    }
    // The scale factors refer to the axes before the rotation, so that the rotation permutes the factors as well.
    let placement = Placement {
        scale: rotation.abs() * placement.scale,
        ..placement.clone()
    };
    Ok(placement.placed(soup))
}

/// Reads triangles in the axes of the file, and the rotation of its up axis onto z.
pub(in crate::io) fn read_in_file_axes(
    path: &Path,
) -> Result<(TriangleSoup, Matrix3<f64>), FileError> {
    let extension = known_extension(path, EXTENSIONS)?;
    let bytes = file_bytes(path)?;
    let soup = match extension {
        "dae" => return collada::read(path, &bytes),
        "glb" | "gltf" => return Ok((gltf::read(path, &bytes)?, collada::Y_UP)),
        "msh" if gmsh::has_header(path, &bytes) => {
            return Err(FileError::HoldsGrid { path: path.into() });
        }
        "msh" => mujoco::read(path, &bytes),
        "obj" => obj::read(path, &bytes),
        "off" => off::read(path, &bytes),
        "ply" => ply::read(path, &bytes),
        "vtk" | "vtp" | "vtu" => vtk::read_polygons(path, &bytes),
        _ => stl::read(path, &bytes),
    };
    Ok((soup?, Matrix3::identity()))
}
