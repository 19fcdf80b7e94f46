//! Every way to find the pairs of tetrahedra that touch finds all of them.

mod broad_phase;
mod culling;
mod following;
#[cfg(feature = "files")]
mod mesher;

#[path = "../support/mod.rs"]
mod support;
