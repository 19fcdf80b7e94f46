//! Common parts of the tests: reference data, random poses, finite differences, worlds, and a slow, exact twin of the contact kernel.
#![allow(dead_code, reason = "each test file uses its own part of the support")]

pub mod aligned;
pub mod balls;
pub mod differences;
pub mod exact;
pub mod exact_claims;
pub mod falling;
pub mod glb;
pub mod hostile;
pub mod hulls;
pub mod impacts;
pub mod moved_meshes;
pub mod moving;
pub mod octahedra;
pub mod reference;
pub mod robots;
pub mod scenes;
pub mod starts;
pub mod subdivisions;
pub mod sweep;
pub mod worlds;
