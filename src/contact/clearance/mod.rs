//! Signed distance between two bodies, with derivatives also before contact.
//!
//! - **Apart**: the smallest distance between the boundary surfaces. `nearest` finds the closest features (vertex, edge, face) in `f64`. For
//!   most convex bodies, it compares only the triangles that reach farthest along the direction between the bodies. For other bodies, it
//!   uses branch and bound on the trees of triangles. `separation` computes the distance and the closest points from these features in the
//!   scalar type of the pair.
//! - **Touching**, or overlapping by less than 1.2e-10 of the size: the signed distance of the features that are closest after a small shift
//!   apart. Round-off would otherwise decide between features, or between the depth and the distance.
//! - **Overlapping**: minus the depth, which `depth` computes from the pressure fields. [`Clearance`] has its definition.
//!
//! The clearance is continuous. It is smooth as long as the features stay the same, and has kinks where the features change. By the
//! envelope theorem, its first derivative is the derivative for fixed features.

mod closest;
mod depth;
mod feature;
mod linearized;
mod nearest;
mod separation;
mod side;

pub use closest::Clearance;
pub use feature::Feature;
pub use linearized::LinearizedClearance;
