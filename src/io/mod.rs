//! Files and conversions. This module reads tetrahedral meshes and closed surfaces. It writes contact surfaces, trajectories and
//! recordings. The default feature `files` enables it.
//!
//! - [`read_mesh`] reads the file of a mesher (Gmsh, VTK, Medit, TetGen, Abaqus) into a [`MeshFile`]: a mesh (m), and point data.
//!   Extents are either an array of the point data ([`MeshFile::pressure_field`]) or computed from the distance to the surface
//!   ([`PressureField::from_distance`](crate::mesh::PressureField::from_distance)).
//! - [`read_triangle_surface`] reads the closed surface of a rigid body (STL, OBJ, OFF, PLY, glTF, COLLADA, VTK, MuJoCo).
//!   [`read_triangles`] reads triangles that need not be closed.
//! - [`write_surface`] writes a contact surface for ParaView and similar programs.
//! - [`write_trajectory`] writes the motion of all bodies as a table (CSV, or Parquet with the feature `parquet`).
//! - [`Recording`] writes an animation for any 3-D viewer.
//! - [`TrajectoryFile`] appends states to a table during a rollout, so that a crash does not lose them.
//!
//! All files except a [`TrajectoryFile`] are written atomically: a temporary file replaces the existing file when it is complete. A
//! killed process may leave a temporary file named `hydroelastic-….part` in the same folder.
//!
//! The feature `parry` adds conversions from shapes of the collision library parry (`parry3d-f64`): to pressure fields (convex
//! polyhedra and triangle meshes) and to rigid surfaces. It also converts poses in both directions.
//!
//! The feature `urdf` adds the module `urdf`, which reads robots in the Unified Robot Description Format.
//!
//! Readers validate everything in a file. A damaged file causes a [`FileError`], never a panic.
//!
//! ```
//! # #[cfg(feature = "files")] {
//! use hydroelastic::io::{MeshOptions, read_mesh, write_surface};
//! use hydroelastic::contact::{ContactBody, ContactPair, Shape};
//! use hydroelastic::mesh::{PressureField, shapes};
//! use hydroelastic::spatial::Pose;
//! use nalgebra::Vector3;
//!
//! let file = read_mesh("tests/data/meshes_from_mesher/bracket.msh", &MeshOptions::default())?;
//! let bracket = Shape::new(PressureField::from_distance(&file.mesh)?);
//! let ball = Shape::new(shapes::icosphere(0.03, 2)?);
//!
//! let on_foot = Pose::from_translation(Vector3::new(0.12, 0.05, 0.095));
//! let pair = ContactPair::new(
//!     ContactBody::new(&ball, on_foot, 1e5)?,
//!     ContactBody::new(&bracket, Pose::identity(), 1e6)?,
//! );
//! let path = std::env::temp_dir().join("ball_on_bracket.vtp");
//! write_surface(&path, &pair.surface())?;
//! # std::fs::remove_file(path)?;
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "files")]
mod files;
#[cfg(feature = "parry")]
mod parry;
#[cfg(feature = "parry")]
mod parry_surface;
#[cfg(feature = "urdf")]
pub mod urdf;

#[cfg(feature = "files")]
pub use files::{
    FileError, FileWarning, MeshFile, MeshOptions, Placement, Recording, TrajectoryFile, read_mesh,
    read_triangle_surface, read_triangles, write_surface, write_trajectory,
};
#[cfg(feature = "parry")]
pub use parry::{field_from_polyhedron, field_from_trimesh};
#[cfg(feature = "parry")]
pub use parry_surface::{ShapeError, surface_from_shape};
