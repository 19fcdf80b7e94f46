//! Closed triangle surfaces: mass properties, neighbors, components, and rejected input.

mod neighbors;
mod overlaps;
mod repairs;
mod sample_surfaces;
mod solids;
mod validation;
mod welding;
