//! Bounding-volume hierarchies of the parts of a mesh, and tests that exclude parts that cannot
//! touch. The trees are built once in the body frame and serve all poses (the paper, §IV-C).
//!
//! `TetBvh` finds the tetrahedra near a box, a point or a plane. `crossings` descends into both
//! bodies' trees of triangles at once, and finds the pairs that may cross. [`RStarTree`] is the
//! tree of the paper's culling, and only culling uses it.
//!
//! Boxes are closed. Callers inflate the query by the rounding error of the coordinates that they
//! transformed, so no pair that touches is missed. Everything here is `f64`: it reads real parts
//! and never a derivative.

#![expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has no more tetrahedra than a u32 counts"
)]

mod box_slab;
mod crossings;
mod four_triangles;
mod projections;
mod r_star_tree;
mod slabs;
mod tet_bvh;
mod traversal_kernels;
mod triangle_bvh;

pub(crate) use crossings::visit_crossing_triangles;
pub use projections::Projections;
pub use r_star_tree::RStarTree;
pub(crate) use tet_bvh::TetBvh;
pub(crate) use triangle_bvh::{SurfaceFace, TriangleBvh};
