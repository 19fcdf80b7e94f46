//! Tetrahedral meshes, pressure fields on them, and surfaces of rigid bodies. All are `f64` and are validated once.
//!
//! A [`TetMesh`] is the geometry. A [`PressureField`] assigns an *extent* to every vertex: 0 on the surface and
//! positive inside. The pressure is the hydroelastic modulus (Pa) times the extent, and is linear in each tetrahedron
//! (the paper, §III-B). [`shapes`] has ready-made fields. A [`TriangleSurface`] is the closed surface of a solid
//! without a field. With the feature `serde` it can be saved and loaded.
//!
//! ```
//! use hydroelastic::mesh::{PressureField, TetMesh, shapes};
//!
//! let sphere = shapes::icosphere(0.1, 2)?;
//! assert_eq!(sphere.mesh().tet_count(), 320);
//!
//! // A field on a custom mesh: the distance to the surface.
//! let same_mesh = TetMesh::new(sphere.mesh().vertices().to_vec(), sphere.mesh().tets().to_vec())?;
//! let field = PressureField::from_distance(&same_mesh)?;
//! assert_eq!(field.extents().iter().copied().fold(0.0, f64::max), 1.0);
//! # Ok::<(), hydroelastic::mesh::MeshError>(())
//! ```

mod convex_hull;
mod coordinates;
mod deepest;
mod distance;
mod distance_fit;
pub(crate) mod ear_clipping;
mod error;
mod linearized_distances;
mod mass;
mod nearest_feet;
mod overlaps;
mod pressure_field;
mod refinement;
#[cfg(feature = "serde")]
mod serial;
mod shape_rates;
pub mod shapes;
mod skin;
mod solid;
mod splitting;
mod surface;
mod surface_distance;
mod surface_error;
mod surface_faults;
mod surface_warning;
mod tet_mesh;
mod thin_triangles;
mod triangle_checks;
mod triangle_components;
mod triangle_edges;
mod triangle_solid;
mod triangle_soup;
mod triangle_surface;
mod welding;

pub use error::MeshError;
pub use linearized_distances::{DistanceGradient, LinearizedDistances};
pub use mass::DensityError;
pub use pressure_field::{FieldTet, PressureField};
pub use shape_rates::ShapeRates;
pub use solid::{Resolution, Solid, SolidError, SolidWarning};
pub(crate) use surface::OUTSIDE;
pub use surface_error::SurfaceError;
pub use surface_faults::{Fault, SurfaceFaults};
pub use surface_warning::SurfaceWarning;
#[cfg(feature = "files")]
pub(crate) use surface_warning::unusual_size;
pub use tet_mesh::TetMesh;
pub use triangle_soup::TriangleSoup;
pub use triangle_surface::TriangleSurface;
#[cfg(feature = "files")]
pub(crate) use welding::first_in_chain;
