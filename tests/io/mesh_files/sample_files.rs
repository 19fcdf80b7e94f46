//! Sample mesh files and texts of mesh files, complete or modified.

use hydroelastic::io::{FileError, MeshFile, MeshOptions, read_mesh};
use std::path::{Path, PathBuf};

/// Meshes of the bracket, written by Gmsh.
pub const PLAIN: [&str; 4] = [
    "bracket.msh",
    "bracket_binary.msh",
    "bracket.vtk",
    "bracket_binary.vtk",
];

/// Meshes of the bracket with extents, written by meshio. The first file has all digits.
pub const WITH_EXTENTS: [&str; 5] = [
    "bracket_extents_binary.vtk",
    "bracket_extents.vtk",
    "bracket_extents_zlib.vtu",
    "bracket_extents_binary.vtu",
    "bracket_extents.vtu",
];

/// One tetrahedron and an unused node, with tags that are dense but not in order.
pub const ONE_TET: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
    $Nodes\n2 5 1 5\n2 1 0 2\n5\n3\n0 0 0\n9 9 9\n3 1 0 3\n1\n4\n2\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n\
    $Elements\n2 2 1 2\n2 1 2 1\n1 5 1 4\n3 1 4 1\n2 5 1 4 2\n$EndElements\n";

pub const ONE_TET_VTK: &str = "# vtk DataFile Version 3.0\none\nASCII\nDATASET UNSTRUCTURED_GRID\n\
    POINTS 5 double\n0 0 0\n9 9 9\n1 0 0\n0 1 0\n0 0 1\nCELLS 2 9\n3 0 2 3\n4 0 2 3 4\nCELL_TYPES 2\n5\n10\n\
    POINT_DATA 5\nSCALARS depth double 1\nLOOKUP_TABLE default\n0 1 2 3 4\nVECTORS at double\n\
    0 0 0 9 9 9 1 0 0 0 1 0 0 0 1\n";

pub fn path_of(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes_from_mesher");
    folder.join(name)
}

pub fn bracket(name: &str) -> MeshFile {
    read_mesh(path_of(name), &MeshOptions::default())
        .unwrap_or_else(|error| panic!("{error}: {error:?}"))
}

/// Reads the bytes as a file with a name. Each test uses its own names.
pub fn read_bytes(name: &str, bytes: &[u8]) -> Result<MeshFile, FileError> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    read_mesh(path, &MeshOptions::default())
}

pub fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from} is not in the text");
    text.replacen(from, to, 1)
}
