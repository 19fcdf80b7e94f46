//! Readers and writers of files.

mod abaqus;
mod atomic_write;
mod collada;
mod contact_surface;
mod cursor;
mod error;
mod extension;
mod file_contents;
mod gltf;
mod gmsh;
mod medit;
mod mesh_file;
mod mesh_reader;
mod mesh_warnings;
mod mujoco;
mod obj;
mod off;
mod placement;
mod ply;
mod polygons;
mod recording;
mod scalar;
mod scene;
mod seams;
mod stl;
mod surface_file;
mod tetgen;
mod text_lines;
mod trajectory;
mod vtk;
mod vtk_data_set;
mod vtk_encoding;
mod vtk_legacy;
mod vtk_xml;
mod warning;

pub use contact_surface::write_surface;
pub use error::FileError;
pub use mesh_file::{MeshFile, MeshOptions};
pub use mesh_reader::read_mesh;
pub use placement::Placement;
pub use recording::Recording;
#[cfg(feature = "urdf")]
pub(super) use surface_file::read_in_file_axes;
pub use surface_file::{read_triangle_surface, read_triangles};
pub use trajectory::{TrajectoryFile, write_trajectory};
pub use warning::FileWarning;
