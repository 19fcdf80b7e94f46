//! Where a pair of tetrahedra meets the plane of equal pressure, decided in `f64`.
//!
//! Everything is seen in A's frame. A [`RelativePair`] is what every decision is made on: both shapes, the moduli and
//! the relative pose, without derivatives. [`RelativePair::classify`] decides whether the plane meets two tetrahedra, and
//! [`RelativePair::cut`] makes what it has in common with both.

mod cut;
mod equilibrium;
mod octet;
mod relative_pair;
mod weights;

pub(crate) use cut::{Cut, PairClass};
pub(crate) use equilibrium::{COINCIDENCE, ELASTIC_COINCIDENCE, EquilibriumPlane};
pub(crate) use octet::{CutOctets, Octet, ReachedFaces, SLOTS};
pub(crate) use relative_pair::{PosedTet, RelativePair, scales};
pub(crate) use weights::{PERTURBATION, Weight, Weights};
