//! Reading and writing of files.

mod broken_writes;
mod closed_surfaces;
mod data_set_fields;
mod face_grids;
mod field_surfaces;
mod mesh_files;
mod recording;
mod surface_files;
mod surface_formats;
mod trajectory_file;
#[cfg(feature = "urdf")]
mod urdf;

#[path = "../support/mod.rs"]
mod support;
