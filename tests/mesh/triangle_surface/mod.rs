//! Closed surfaces of triangles: mass properties, neighbors, components, and what is refused.

mod neighbors;
mod sample_surfaces;
mod solids;
mod validation;
mod welding;
