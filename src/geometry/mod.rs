//! Shapes without physics: [`AffineField`], [`Tetrahedron`], [`ConvexPolygon`], boxes, and
//! triangles.

mod aabb;
mod affine_field;
mod plane_moments;
mod polygon;
mod tetrahedron;
mod tolerance;
mod triangle;
mod triangle_gap;

pub use aabb::Aabb;
pub use affine_field::AffineField;
pub(crate) use plane_moments::{PER_TRIANGLE, add_triangle};
pub(crate) use polygon::set_bits;
pub use polygon::{ConvexPolygon, POLYGON_CAPACITY};
pub use tetrahedron::Tetrahedron;
pub(crate) use tetrahedron::{ALL_FACES, EDGES, FACES, NEXT_FACES, face_of_slice};
pub(crate) use tolerance::{NearZeroHistogram, Tolerance, snapped};
pub(crate) use triangle::{Foot, Triangle};
pub(crate) use triangle_gap::{TriangleGap, TrianglePart};
