use crate::mesh::{MeshError, SurfaceError};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Reason why a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file cannot be read from the disk.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A number to be written is not finite in single precision.
    #[error(
        "nothing was written to {}: a number of {part} is NaN, infinite or beyond single precision",
        path.display()
    )]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Part of the recording that contains the number.
        part: String,
    },
    /// The extension of the file name is unknown.
    #[error("the name of {} ends in {found:?}, but has to end in one of {expected:?}", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// The extension, or an empty string if the name has no extension.
        found: String,
        /// The supported extensions.
        expected: &'static [&'static str],
    },
    /// The content of the file is not valid in the format of its extension.
    #[error("{} is not {} {format} file, or is damaged: {source}", path.display(), article(format))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// Error of the parser.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The file uses an unsupported variant of the format.
    #[error("{} has {found}, but only {expected} can be read", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Variant of the file.
        found: String,
        /// Supported variants.
        expected: &'static str,
    },
    /// The stated length of a part of the file is impossible.
    #[error("the {part} of {} claims the length {found}, but can have at most {limit}", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Name of the part.
        part: String,
        /// Stated length.
        found: usize,
        /// Largest possible length.
        limit: usize,
    },
    /// Two vertices have the same tag.
    #[error("{} has more than one vertex with the tag {tag}", path.display())]
    RepeatedTag {
        /// The file.
        path: PathBuf,
        /// The tag.
        tag: i64,
    },
    /// A tetrahedron refers to a vertex that does not exist.
    #[error("tetrahedron {tet} of {} refers to vertex {vertex}, which the file does not have", path.display())]
    UnknownVertex {
        /// The file.
        path: PathBuf,
        /// Index of the tetrahedron in the file, counted from 0 without other elements.
        tet: usize,
        /// Tag or index (VTK) of the vertex.
        vertex: i64,
    },
    /// The file has a surface, but was read as a mesh of tetrahedra.
    #[error("{} has a surface, not tetrahedra: use read_triangles", path.display())]
    HoldsSurface {
        /// The file.
        path: PathBuf,
    },
    /// The file has solid cells, such as tetrahedra, or is a Gmsh file, but was read as a surface.
    #[error(
        "{} may hold tetrahedra, but read_triangles reads surfaces only: use read_mesh",
        path.display()
    )]
    HoldsGrid {
        /// The file.
        path: PathBuf,
    },
    /// The file has no tetrahedra.
    #[error("{} has no tetrahedra: was only its surface meshed or saved?", path.display())]
    NoTetrahedra {
        /// The file.
        path: PathBuf,
    },
    /// The file has tetrahedra with more than four vertices.
    #[error(
        "{} has {found} tetrahedra of second or higher order, with {vertex_count} or more vertices: the option corners_only reads them as tetrahedra of first order with the same 4 corners",
        path.display()
    )]
    HigherOrder {
        /// The file.
        path: PathBuf,
        /// Number of these tetrahedra.
        found: usize,
        /// Smallest number of vertices of these tetrahedra.
        vertex_count: usize,
    },
    /// The file has solid elements other than tetrahedra. They cannot be ignored, because the solid would have holes.
    #[error("{} has solid elements that are not tetrahedra ({found}): divide them into tetrahedra in the program that made them", path.display())]
    OtherSolid {
        /// The file.
        path: PathBuf,
        /// Number of the elements of each kind.
        found: String,
    },
    /// The file has no point-data array of this name with one number per vertex.
    #[error("{} has no point-data array {name:?} with one number per vertex, only {found:?}", path.display())]
    NoSuchArray {
        /// The file.
        path: PathBuf,
        /// The requested name.
        name: String,
        /// Names of the available arrays.
        found: Vec<String>,
    },
    /// The trajectory belongs to another world. Nothing is written.
    #[error(
        "nothing was written to {}: the trajectory has {found} {quantity}, but the world has {expected}",
        path.display()
    )]
    OtherWorld {
        /// The file.
        path: PathBuf,
        /// "bodies" or "joints with a state".
        quantity: &'static str,
        /// Number in a state of the trajectory.
        found: usize,
        /// Number in the world.
        expected: usize,
    },
    /// The file contains no valid mesh or pressure field. Indices of vertices do not count vertices that no tetrahedron uses.
    #[error("{} does not hold a usable mesh: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: MeshError,
    },
    /// A number that the caller chose is out of range. Nothing is read or written.
    #[error("the {name} for {} is {found:e}, but must be {expected}", path.display())]
    Option {
        /// The file.
        path: PathBuf,
        /// Name of the number.
        name: String,
        /// The number.
        found: f64,
        /// Numbers that are allowed.
        expected: &'static str,
    },
    /// The triangles in the file are not a valid closed surface.
    #[error("{} does not hold a usable surface: {source}", path.display())]
    Surface {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: SurfaceError,
    },
}

impl FileError {
    /// Error for a file that is not valid in its format.
    pub(super) fn syntax(
        path: &Path,
        format: &'static str,
        source: impl Into<Box<dyn Error + Send + Sync>>,
    ) -> Self {
        Self::Syntax {
            path: path.into(),
            format,
            source: source.into(),
        }
    }
}

/// Indefinite article before the name of a format.
fn article(format: &str) -> &'static str {
    if format.starts_with(['A', 'O']) {
        "an"
    } else {
        "a"
    }
}
