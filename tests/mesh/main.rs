//! Meshes, their fields, and the ready-made shapes.

mod shapes;
mod star_shaped;
mod tet_mesh;
