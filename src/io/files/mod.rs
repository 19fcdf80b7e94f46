//! Readers and writers of files.

mod atomic_write;
mod collada;
#[cfg(feature = "vtk")]
mod contact_surface;
#[cfg(feature = "vtk")]
mod data_set_fields;
mod error;
mod extension;
mod file_contents;
mod gltf;
mod gmsh;
mod gmsh_headers;
mod mesh_file;
mod obj;
mod off;
mod placement;
mod ply;
mod polygons;
mod recording;
mod scene;
mod stl;
mod surface_file;
mod syntax_error;
mod text_lines;
mod trajectory;
#[cfg(feature = "vtk")]
mod vtk;
#[cfg(feature = "vtk")]
mod vtu_lengths;
#[cfg(feature = "vtk")]
mod xml;

#[cfg(feature = "vtk")]
pub use contact_surface::write_surface;
pub use error::FileError;
pub use mesh_file::{MeshFile, read_mesh};
pub use placement::Placement;
pub use recording::Recording;
#[cfg(feature = "urdf")]
pub(super) use surface_file::read_as_drawn;
pub use surface_file::{read_triangle_surface, read_triangles};
pub use trajectory::{TrajectoryFile, write_trajectory};
