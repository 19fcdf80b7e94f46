//! Tetrahedral meshes: validation, surface, mass properties, inner vertices, pressure fields, distance fields, skins.

mod distance_fields;
mod inner_vertices;
mod linearized_distances;
mod mass_properties;
mod pressure_fields;
pub mod sample_meshes;
mod skins;
mod surface;
mod validation;
