//! Bodies as contact sees them: the shapes, with the trees that find their parts, and the bodies made of a shape, a pose and a modulus.
//!
//! A [`Shape`] is compliant; a [`RigidShape`] and a [`HalfSpace`] can be a [`Partner`] of a compliant [`ContactBody`]. A
//! [`PartnerShape`] gives access to the shape of a partner of any kind. Shapes are `f64`; poses and moduli are generic.

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
