use crate::mesh::{MeshError, SurfaceError};
use std::error::Error;
use std::path::PathBuf;

/// Why a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file cannot be read from the disk.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A number to be written is not finite, or not in single precision.
    #[error(
        "nothing was written to {}: a number of {part} is NaN, infinite or beyond single precision",
        path.display()
    )]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// What the number belongs to.
        part: String,
    },
    /// The camera of a recording is where it looks, or too near to that for single precision.
    #[error(
        "nothing was written to {}: the camera is {distance:.3e} m from the point it looks at, which is too near",
        path.display()
    )]
    CameraTooNear {
        /// The file.
        path: PathBuf,
        /// The distance (m).
        distance: f64,
    },
    /// The radius of a target of a recording is not positive and finite in single precision.
    #[error(
        "nothing was written to {}: target {target:?} has the radius {radius:e} m, which has to be positive and finite in single precision",
        path.display()
    )]
    TargetRadius {
        /// The file.
        path: PathBuf,
        /// Name of the target.
        target: String,
        /// Its radius (m).
        radius: f64,
    },
    /// A recording cannot be slowed down so.
    #[error(
        "nothing was written to {}: it was to be {found} times slower, but that has to be a positive, finite number",
        path.display()
    )]
    Slowdown {
        /// The file.
        path: PathBuf,
        /// How many times slower it was to be.
        found: f64,
    },
    /// The name of the file does not end in a format that is known.
    #[error("the name of {} ends in {found:?}, but has to end in one of {expected:?}", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// What the name ends in; empty if there is no extension.
        found: String,
        /// The extensions there are.
        expected: &'static [&'static str],
    },
    /// The file is not of the format that its name promises.
    #[error("{} is not a {format} file, or is damaged: {source}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// What the parser says.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The file goes on where it should end: part of it is damaged or of an unknown kind.
    #[error("{} is not understood from byte {offset} on, where it says {found:?}", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// Where the part that is not understood begins.
        offset: usize,
        /// How it begins.
        found: String,
    },
    /// A variant of the format that is not supported.
    #[error("{} has {found}, but only {expected} can be read", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What the file has.
        found: String,
        /// What is supported.
        expected: &'static str,
    },
    /// A part of the file is shorter than it has to be.
    #[error("the {part} of {} has the length {found}, but needs at least {expected}", path.display())]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Which part.
        part: String,
        /// Its length.
        found: usize,
        /// The length it needs.
        expected: usize,
    },
    /// A part of the file claims to be longer than it can be.
    #[error("the {part} of {} claims the length {found}, but can have at most {limit}", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Which part.
        part: String,
        /// The length it claims.
        found: usize,
        /// The largest length possible.
        limit: usize,
    },
    /// Two vertices have the same tag.
    #[error("{} has more than one vertex with the tag {tag}", path.display())]
    RepeatedTag {
        /// The file.
        path: PathBuf,
        /// The tag.
        tag: u64,
    },
    /// A tetrahedron refers to a vertex that is not there.
    #[error("tetrahedron {tet} of {} refers to vertex {vertex}, which the file does not have", path.display())]
    UnknownVertex {
        /// The file.
        path: PathBuf,
        /// Number of the tetrahedron in the file, from 0, counting tetrahedra only.
        tet: usize,
        /// The tag (Gmsh) or index (VTK) it refers to.
        vertex: u64,
    },
    /// There is no tetrahedron in the file.
    #[error("{} has no tetrahedra: was only its surface meshed or saved?", path.display())]
    NoTetrahedra {
        /// The file.
        path: PathBuf,
    },
    /// There are tetrahedra with more than four vertices.
    #[error(
        "{} has tetrahedra of second or higher order ({found}), but only tetrahedra of first order, with 4 vertices, can be read",
        path.display()
    )]
    HigherOrder {
        /// The file.
        path: PathBuf,
        /// What the format calls them.
        found: String,
    },
    /// There are solid elements other than tetrahedra: without them the solid would have holes.
    #[error("{} has solid elements of the kind {found}, but only tetrahedra can be read", path.display())]
    OtherSolid {
        /// The file.
        path: PathBuf,
        /// What the format calls them.
        found: String,
    },
    /// The file has no point-data array of that name with one number per vertex.
    #[error("{} has no point-data array {name:?} with one number per vertex, only {found:?}", path.display())]
    NoSuchArray {
        /// The file.
        path: PathBuf,
        /// The name asked for.
        name: String,
        /// The names of the arrays there are.
        found: Vec<String>,
    },
    /// A trajectory and a world that it is not of: nothing is written.
    #[error(
        "nothing was written to {}: the trajectory has {found} bodies, but the world has {expected}",
        path.display()
    )]
    OtherWorld {
        /// The file.
        path: PathBuf,
        /// Number of bodies in a state of the trajectory.
        found: usize,
        /// Number of bodies in the world.
        expected: usize,
    },
    /// The numbers in the file are no mesh or no pressure field. Vertices are counted without
    /// those that no tetrahedron uses.
    #[error("{} does not hold a usable mesh: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: MeshError,
    },
    /// The unit of a surface file is no length.
    #[error("the unit of {} was given as {found} m, but has to be positive and finite", path.display())]
    Unit {
        /// The file.
        path: PathBuf,
        /// What was given (m).
        found: f64,
    },
    /// The triangles in the file are no closed surface. They are counted without those whose corners are not three
    /// places, and vertices at the same place are one.
    #[error("{} does not hold a usable surface: {source}", path.display())]
    Surface {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: SurfaceError,
    },
}
