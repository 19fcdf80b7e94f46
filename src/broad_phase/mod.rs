//! Which tetrahedra of two bodies may touch: R\*-trees of the boxes of a mesh's tetrahedra and of its
//! creases, and flat trees of its surface triangles and tetrahedra, built once in the body's frame and never again,
//! however the poses change (the paper, §IV-C).
//!
//! For a relative pose, [`TetTree::visit_near`] walks B's tree down to the tetrahedra that come
//! near A as a whole, and [`TetTree::visit_overlapping`] asks A's tree for the partners of each.
//! `crossings` walks both bodies' trees of triangles at once, to the pairs that may cross.
//! Boxes are closed; whoever asks inflates the query by the round-off of the coordinates it
//! transformed, and then no pair that touches is missed. Everything here is `f64`: it looks at real
//! parts and never at a derivative.

#![expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has no more tetrahedra than a u32 counts"
)]

mod box_tree;
mod crossings;
mod field_tree;
mod flat_tree;
mod four_triangles;
mod half_space;
mod landscape;
mod lists;
mod nodes;
mod patch;
mod positivity;
mod projections;
mod rigid_shape;
mod seeds;
mod shape;
mod tet_tree;
mod triangle_tree;

pub(crate) use crossings::visit_crossings;
pub(crate) use field_tree::{Below, FieldBounds, FieldNode, FieldTree};
pub use half_space::{HalfSpace, ThicknessError};
pub(crate) use landscape::{Escape, Landscape};
pub use positivity::NotFollowed;
pub use projections::Projections;
pub use rigid_shape::RigidShape;
pub(crate) use seeds::{Ridges, Seeds};
pub use shape::Shape;
pub use tet_tree::TetTree;
pub(crate) use triangle_tree::TriangleTree;
