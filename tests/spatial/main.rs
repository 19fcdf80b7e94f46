//! Poses, twists, wrenches, and the scalars over which they are generic.

mod dense_dual;
mod exponential_map;
mod interop;
mod poses;
mod samples_and_tolerances;
mod scalars;
mod wrenches;
