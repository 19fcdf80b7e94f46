//! Files: tetrahedral meshes and closed surfaces in, contact surfaces and trajectories out; with the feature `files`, a default one;
//! those of VTK with the feature `vtk`, which is another.
//!
//! [`read_mesh`] reads the files of a mesher (Gmsh `.msh`, VTK `.vtk` and `.vtu`) into a
//! [`MeshFile`]: a mesh, and whatever numbers the file has for each vertex. Extents can be among
//! them ([`MeshFile::pressure_field`]); else they come from the distance to the surface
//! ([`PressureField::from_distance`](crate::mesh::PressureField::from_distance)).
//! [`read_triangle_surface`] reads the closed surface of a rigid body (STL, OBJ).
//! [`write_surface`] writes a contact surface for ParaView and its like, [`write_trajectory`] the
//! motion of all bodies as a table (CSV, or Parquet with the feature `parquet`); a [`Recording`] shows
//! it in any 3-D viewer. Meshes are taken to be in meters.
//!
//! These appear under their names when they are whole, each in the place of an older one; a draft named
//! `hydroelastic-….part` beside it is what a killed process leaves. A [`TrajectoryFile`] grows with its
//! rollout instead, for those that are not to be lost.
//!
//! With the feature `parry`, shapes of the collision library of that name (`parry3d-f64`) become pressure
//! fields (convex polyhedra, triangle meshes and the convex hulls of points) or rigid surfaces. Poses go both ways.
//!
//! Nothing in a file is trusted: damaged ones end in a [`FileError`], never in a panic.
//!
//! ```
//! # #[cfg(feature = "vtk")] {
//! use hydroelastic::io::{read_mesh, write_surface};
//! use hydroelastic::contact::{ContactBody, ContactPair, Shape};
//! use hydroelastic::mesh::{PressureField, shapes};
//! use hydroelastic::spatial::Pose;
//! use nalgebra::Vector3;
//!
//! let file = read_mesh("tests/data/meshes_from_mesher/bracket.msh")?;
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

#[cfg(feature = "vtk")]
pub use files::write_surface;
#[cfg(feature = "files")]
pub use files::{
    FileError, MeshFile, Recording, TrajectoryFile, read_mesh, read_triangle_surface,
    write_trajectory,
};
#[cfg(feature = "parry")]
pub use parry::{HullError, field_from_hull, field_from_polyhedron, field_from_trimesh};
#[cfg(feature = "parry")]
pub use parry_surface::{ShapeError, surface_from_shape};
