//! Where a pair of tetrahedra meets the plane of equal pressure, decided in `f64`.
//!
//! Everything is seen in A's frame. A [`RelativePair`] is what every decision is made on: both shapes, the moduli and
//! the relative pose, without derivatives.

mod body;
mod cut;
mod equilibrium;
mod partner;
mod relative_pair;

pub use body::{BodyError, ContactBody};
pub(crate) use cut::{Cut, Encounter};
pub(crate) use equilibrium::{COINCIDENCE, ELASTIC_COINCIDENCE, EquilibriumPlane, NUDGE, Weights};
pub use partner::Partner;
pub(crate) use partner::PartnerShape;
pub(crate) use relative_pair::{PosedTet, RelativePair, scales};
