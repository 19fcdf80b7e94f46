//! Readers and writers of files.

#[cfg(feature = "vtk")]
mod contact_surface;
#[cfg(feature = "vtk")]
mod data_set_fields;
mod error;
mod file_contents;
mod gmsh;
mod gmsh_headers;
mod mesh_file;
mod recording;
mod replacement;
mod stopped;
mod trajectory;
#[cfg(feature = "vtk")]
mod vtk;
#[cfg(feature = "vtk")]
mod vtu_lengths;

#[cfg(feature = "vtk")]
pub use contact_surface::write_surface;
pub use error::FileError;
pub use mesh_file::{MeshFile, read_mesh};
pub use recording::Recording;
pub use trajectory::{TrajectoryFile, write_trajectory};
