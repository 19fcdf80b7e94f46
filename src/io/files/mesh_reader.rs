use super::mesh_file::file_bytes;
use super::{FileError, MeshFile, MeshOptions, extension::known_extension};
use super::{abaqus, gmsh, medit, tetgen, vtk};
use std::path::Path;

/// Extensions of mesh files.
const EXTENSIONS: &[&str] = &["msh", "vtk", "vtu", "mesh", "node", "ele", "inp"];

/// Reads a tetrahedral mesh. The extension of the file name, in upper or lower case, selects the format:
///
/// - `.msh`: Gmsh versions 1, 2, 4.0 and 4.1, ASCII or binary. [`read_triangles`](super::read_triangles) reads MuJoCo's files. Data sections (`$NodeData`) are ignored, so compute the extents from
///   the distance to the surface, or use a VTK file.
/// - `.vtk`, `.vtu`: VTK unstructured grid, legacy (up to version 5.1) or XML. The contents decide between these two. Legacy files
///   are ASCII or binary. XML files have ASCII, inline base64 or appended data, uncompressed or compressed with zlib, in any number of
///   pieces.
/// - `.mesh`: Medit, ASCII.
/// - `.node`, `.ele`: the two files of TetGen. The path is that of either file. Indices begin at 0 or 1.
/// - `.inp`: Abaqus with elements of the types C3D4 and C3D10. The displacement of a single instance is ignored. Files are refused if they
///   have several instances of one part, or several instances and a displacement. Files are also refused if keywords generate, transform or
///   include nodes or elements.
///
/// Elements of lower dimension (points, lines, surface triangles) and vertices that no tetrahedron uses are ignored.
///
/// Duplicated vertices of coincident faces are merged if they are at most [`MeshOptions::weld_tolerance`] apart and the result is a
/// valid mesh.
///
/// # Errors
/// - If an option is out of range: the unit must be positive, no factor may be zero, the tolerance must not be negative, and all must be
///   finite.
/// - If the extension is unknown, or the file cannot be read or parsed.
/// - If the file has no tetrahedra, tetrahedra of higher order without [`MeshOptions::corners_only`], or other solid elements.
/// - If [`TetMesh::new`](crate::mesh::TetMesh::new) returns an error.
pub fn read_mesh(path: impl AsRef<Path>, options: &MeshOptions) -> Result<MeshFile, FileError> {
    let path = path.as_ref();
    let extension = known_extension(path, EXTENSIONS)?;
    options.placement.check(path)?;
    if !(options.weld_tolerance >= 0.0 && options.weld_tolerance.is_finite()) {
        return Err(FileError::Option {
            path: path.into(),
            name: "weld_tolerance".into(),
            found: options.weld_tolerance,
            expected: "finite and not negative",
        });
    }
    let contents = match extension {
        "node" | "ele" => tetgen::read(path)?,
        _ => {
            let bytes = file_bytes(path)?;
            match extension {
                "msh" => gmsh::read(path, &bytes)?,
                "mesh" => medit::read(path, &bytes)?,
                "inp" => abaqus::read(path, &bytes)?,
                _ => vtk::read_grid(path, &bytes)?,
            }
        }
    };
    contents.into_mesh(path, options)
}
