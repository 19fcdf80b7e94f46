//! Signed distance between two bodies, with derivatives also before contact.
//!
//! - **Apart**: the smallest distance between the boundary surfaces. `nearest` finds the closest features (vertex, edge, face) in `f64`, by
//!   branch and bound on the trees of triangles. `separation` computes the distance and the closest points from these features in the
//!   scalar type of the pair.
//! - **Overlapping**: minus the depth, which `depth` computes from the pressure fields.
//!
//! The clearance is continuous. It is smooth as long as the features stay the same, and has kinks where the features change. By the
//! envelope theorem, its first derivative is the derivative for fixed features.
//!
//! # Depth
//!
//! The pressure fields select points of the overlap: the corners of the contact polygons, where both pressures are equal, and the vertices
//! inside the other body at which the pressure of their own body is smaller. The depth of a point is its distance to the surface of A plus
//! its distance to the surface of B. The depth of the bodies is the largest depth of these points.
//!
//! The depth is continuous, because a vertex joins the points when the contact surface passes it. For parallel faces, and for a ball in a
//! half-space, it is the geometric depth. Tetrahedra without pressure have no contact surface, so the clearance is 0 there.

mod closest;
mod depth;
mod feature;
mod linearized;
mod nearest;
mod separation;

pub use closest::Clearance;
pub use feature::Feature;
pub use linearized::LinearizedClearance;
