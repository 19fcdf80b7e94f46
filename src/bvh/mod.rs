//! A bounding-volume hierarchy: a tree of boxes that finds the items near a point, a box or a plane
//! without testing all items.
//!
//! A [`Bvh`] is built once, by median splits, and never changed. Each node has up to four children,
//! whose boxes are tested together with SIMD instructions. A [`BoxTest`] decides which children a
//! traversal enters. [`PerNode`] holds an additional value for each node, such as bounds of a
//! pressure field.

#![expect(
    clippy::cast_possible_truncation,
    reason = "items are counted by a u32, because a mesh has no more tetrahedra"
)]

mod four_boxes;
mod per_node;
mod queries;
mod tree;

pub(crate) use four_boxes::{FourBoxes, FourCorners, WIDTH, four_bits};
pub(crate) use per_node::PerNode;
pub(crate) use tree::{BoxTest, Bvh, Node};
