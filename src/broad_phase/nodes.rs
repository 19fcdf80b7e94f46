//! The layout of a tree of triangles: four children or four triangles side by side.

use super::flat_tree::{FourBoxes, NO_BOXES, WIDTH};
use crate::geometry::Aabb;
use crate::lanes::Quad;
use nalgebra::Vector3;

/// The corners of four triangles, by corner and coordinate.
pub(super) type FourCorners = [[Quad; 3]; 3];

/// Where the triangles below each of four children are, side by side: in a box and between two parallel planes.
#[derive(Debug, Clone)]
#[repr(C, align(32))]
pub(super) struct Node {
    /// The boxes.
    pub bounds: FourBoxes,
    /// Unit normals of the planes: the mean of those of the triangles. Or 0, where these cancel.
    pub normal: [Quad; 3],
    /// The smallest values of normal · x (m) and the largest.
    pub between: [Quad; 2],
}

impl Node {
    /// Without children.
    pub const EMPTY: Self = Self {
        bounds: NO_BOXES,
        normal: [[0.0; WIDTH]; 3],
        between: [[f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]],
    };

    /// The box of a child.
    pub fn aabb(&self, slot: usize) -> Aabb {
        let side = |side: usize| Vector3::from_fn(|k, _| self.bounds[k][side][slot]);
        Aabb {
            lower: side(0),
            upper: side(1),
        }
    }
}
