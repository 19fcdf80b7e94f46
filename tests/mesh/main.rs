//! Meshes, their fields and built-in shapes, and surfaces of rigid bodies.

mod convex_hull;
mod shapes;
mod solids;
mod star_shaped;
mod tet_mesh;
mod triangle_surface;

#[path = "../support/moved_meshes.rs"]
mod moved_meshes;
