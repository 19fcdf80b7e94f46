//! What a body is for contact, and which of its parts may touch another body: bounding-volume hierarchies of the tetrahedra,
//! surface triangles of a mesh, built once in the body's frame, however the poses change (the paper, §IV-C).
//!
//! `TetBvh` finds the tetrahedra near a box, a point or a plane. `crossings` walks both bodies' trees of triangles at once, to the
//! pairs that may cross. [`RStarTree`] is the tree of the paper's culling, and only culling uses it.
//! Boxes are closed. Callers inflate the query by the round-off of the coordinates that they
//! transformed, so no pair that touches is missed. Everything here is `f64`: it reads real
//! parts and never a derivative.

#![expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has no more tetrahedra than a u32 counts"
)]

mod crossings;
mod escapes;
mod field_bounds;
mod four_triangles;
mod half_space;
mod lists;
mod patch;
mod positivity;
mod projections;
mod r_star_tree;
mod rigid_shape;
mod seeds;
mod shape;
mod slabs;
mod tet_bvh;
mod triangle_bvh;

pub(crate) use crossings::visit_crossings;
pub(crate) use escapes::Escape;
pub(crate) use field_bounds::FieldBounds;
pub use half_space::{HalfSpace, ThicknessError};
pub use positivity::NotFollowed;
pub use projections::Projections;
pub use r_star_tree::RStarTree;
pub use rigid_shape::RigidShape;
pub(crate) use seeds::Seeds;
pub use shape::Shape;
pub(crate) use tet_bvh::TetBvh;
pub(crate) use triangle_bvh::TriangleBvh;
