//! Every search for touching pairs of tetrahedra finds all of them.

mod broad_phase;
mod culling;
mod following;
#[cfg(feature = "files")]
mod mesher;

#[path = "../support/mod.rs"]
mod support;
