//! Tetrahedral meshes: validation, surface, mass properties, inner vertices, pressure fields, distance fields.

mod distance_fields;
mod inner_vertices;
mod mass_properties;
mod pressure_fields;
pub mod sample_meshes;
mod surface;
mod validation;
