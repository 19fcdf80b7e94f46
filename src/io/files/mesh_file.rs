use super::{FileError, FileWarning, Placement};
use crate::mesh::{PressureField, TetMesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A tetrahedral mesh from a file.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// Mesh (m): all tetrahedra of the file and the vertices of these tetrahedra, in the order of the file.
    pub mesh: TetMesh,
    /// Point-data arrays with one number per vertex, by name (VTK only).
    pub point_data: BTreeMap<String, Vec<f64>>,
    /// Properties of the file that may be mistakes.
    pub warnings: Vec<FileWarning>,
    pub(super) path: PathBuf,
}

/// Options of [`read_mesh`](super::read_mesh).
///
/// ```
/// use hydroelastic::io::{MeshOptions, Placement};
///
/// let millimeters = MeshOptions {
///     placement: Placement { unit: 1e-3, ..Placement::default() },
///     ..MeshOptions::default()
/// };
/// assert!(!millimeters.corners_only);
/// ```
#[derive(Debug, Clone, Default)]
pub struct MeshOptions {
    /// Map from the coordinates of the file to positions in the body frame.
    pub placement: Placement,
    /// True to read tetrahedra of second or higher order as tetrahedra of first order with the same corners. Curved faces become flat.
    pub corners_only: bool,
    /// Distance (m) up to which duplicated vertices of coincident faces are merged. Duplicated vertices at equal positions are always
    /// merged.
    pub weld_tolerance: f64,
}

/// Byte-order mark of text in UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads the bytes of a file, without a byte-order mark.
pub(super) fn file_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    let bytes = std::fs::read(path);
    let mut bytes = bytes.map_err(|source| FileError::Read {
        path: path.into(),
        source,
    })?;
    let is_stl = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("stl"));
    // The header of a binary STL file has no meaning.
    if bytes.starts_with(MARK) && !(is_stl && bytes.contains(&0)) {
        bytes.drain(..MARK.len());
    }
    Ok(bytes)
}

impl MeshFile {
    /// Pressure field of the mesh, with the named point-data array as extents (any unit: pressure = modulus × extent).
    ///
    /// # Errors
    /// - If the file has no array of this name with one number per vertex.
    /// - If [`PressureField::new`] returns an error.
    pub fn pressure_field(mut self, extents: &str) -> Result<PressureField, FileError> {
        let Some(values) = self.point_data.remove(extents) else {
            return Err(FileError::NoSuchArray {
                path: self.path,
                name: extents.into(),
                found: self.point_data.into_keys().collect(),
            });
        };
        PressureField::new(self.mesh, values).map_err(|source| FileError::Mesh {
            path: self.path,
            source,
        })
    }
}
