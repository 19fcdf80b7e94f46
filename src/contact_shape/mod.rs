//! Bodies in contact: shapes with their search trees, and bodies made of a shape, a pose and a modulus.
//!
//! A [`Shape`] is compliant. A [`RigidShape`] or a [`HalfSpace`] can be a [`Partner`] of a compliant [`ContactBody`]. A
//! [`PartnerShape`] is the shape of a partner of any kind. Shapes are `f64`. Poses and moduli are generic over the
//! scalar.
//!
//! # A new kind of partner
//!
//! A new kind of partner needs a file here, a variant of [`PartnerShape`] with cells, a variant of `BodyShape` in `dynamics`, and its seeds in
//! `route` of `search/following.rs` and in `search/culled_pairs.rs`. The compiler does not report `matches!` and wildcard patterns, so search for
//! `PartnerShape::` in `narrow_phase` and `search`, and for `BodyShape::` in `dynamics` and `io`.

mod body;
mod half_space;
mod partner;
mod rigid_shape;
mod shape;

pub(crate) use body::STEEPEST;
pub use body::{BodyError, ContactBody};
pub use half_space::{HalfSpace, ThicknessError};
pub use partner::Partner;
pub(crate) use partner::PartnerShape;
pub use rigid_shape::RigidShape;
pub use shape::Shape;
