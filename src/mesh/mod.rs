//! Tetrahedral meshes and their pressure fields, all `f64` and validated once.
//!
//! A [`TetMesh`] is geometry; a [`PressureField`] puts an *extent* on every vertex, 0 on the
//! surface and positive inside, so that the pressure is the hydroelastic modulus (Pa) times the
//! extent, linear in each tetrahedron (the paper, §III-B). [`shapes`] has ready-made fields.
//!
//! ```
//! use hydroelastic::mesh::{PressureField, TetMesh, shapes};
//!
//! let sphere = shapes::icosphere(0.1, 2)?;
//! assert_eq!(sphere.mesh().tet_count(), 320);
//!
//! // A field of one's own: the distance to the surface, on any mesh.
//! let same_mesh = TetMesh::new(sphere.mesh().vertices().to_vec(), sphere.mesh().tets().to_vec())?;
//! let field = PressureField::from_distance(&same_mesh)?;
//! assert_eq!(field.extents().iter().copied().fold(0.0, f64::max), 1.0);
//! # Ok::<(), hydroelastic::mesh::MeshError>(())
//! ```

mod distance;
mod error;
mod mass;
mod pressure_field;
pub mod shapes;
mod skin;
mod splitting;
mod surface;
mod surface_tree;
mod tet_mesh;

pub use error::MeshError;
pub use pressure_field::{FieldTet, PressureField};
pub use tet_mesh::TetMesh;
