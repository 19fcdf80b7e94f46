//! Intersection of a pair of tetrahedra with the plane of equal pressure, computed in `f64`.
//!
//! Everything is in A's frame. A [`RelativePair`] holds all inputs of the decisions: both shapes, the moduli and the relative pose, without
//! derivatives. [`RelativePair::classify`] decides whether the plane meets two tetrahedra, and [`RelativePair::cut`] computes the polygon
//! that the plane has in common with both. A [`Cut`] stores the faces that own each edge of its polygon. These faces determine the next
//! pairs of a search and the derivative of the edge.
//!
//! # Octets
//!
//! Pairs are processed eight at a time ([`Octet`]). [`CutOctets`] finds in lanes which of them are *generic*: no value that decides a
//! branch is near zero. It cuts several generic pairs at a time without branches: a polygon is a set of edges, one for each face that may
//! have an edge, and a clip moves end points, removes edges and adds one. All other pairs are *special*, and are cut one by one.
//!
//! # Partners
//!
//! A is always compliant and has a mesh. For a B of any kind, `PartnerShape::cells` returns tetrahedra with a field.
//!
//! - A *rigid body* has one tetrahedron behind each triangle. Its field is the depth below the triangle (m). Its other faces bound the
//!   polygon, and lead the walk to the next triangle. A *half-space* is one cell, whose faces bound nothing.
//! - *Rigid is a limit.* As the field of B grows steeper, the plane of equal pressure approaches depth 0, ∇p_A/|g| and 1/|g| approach 0,
//!   and ∇p_B/|g| approaches −n. Therefore the factors of the extents (`scales`) are the two moduli, or 0 and 1.
//!   `EquilibriumPlane::of_rigid` has the slopes, from which every formula gives its limit. The integrals use the pressure of A.
//!
//! # Rules
//!
//! - *Surface faces of B clip nothing.* On the plane both pressures are equal, and the pressure of A is never negative. So faces of B at
//!   which its pressure is 0 bound nothing. A polygon that reaches such a face ends at a face of A with pressure 0.
//! - *Signs decide whether the plane meets a face of B, not distances*: the signs of p_A − p_B at the corners. In a field much steeper than
//!   the other, the plane hardly moves in B when the bodies move. So a parallel layer may be within the margin and still be far
//!   from a coincidence (`tests/contact/layers.rs`).
//! - *A polygon counts by half for each side of its plane on which both tetrahedra have a section* (`weights`). A polygon in a face thus
//!   counts once if two tetrahedra share the face, whichever body is A and however the meshes are divided (`tests/contact/tiling.rs`).
//! - *Equal fields have no plane.* A pair is omitted if its gradients differ by less than 1e-9 of the fields' sensitivity to coordinates.
//!   The plane of more similar fields would be misplaced by more than margin/1e-9 = 3e-5.
//! - *Areas are signed.* A polygon has one orientation, so a doubled corner contributes nothing.
//!
//! # Tolerances
//!
//! The *margin*, 3e-14 of the distances from the origins of the frames, is the distance that counts as zero in boxes and projections. Times
//! the sensitivity of the other field it is the zero of p_A − p_B, and times a barycentric gradient the zero of a clip. It must exceed the
//! rounding error of a transformed coordinate (about 1e-15), or a corner on a plane would fall on both sides. A cut with a corner within
//! 2¹⁴ margins of a plane, but not on it, is *ill-conditioned*: rounding errors decide where such planes meet.

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
