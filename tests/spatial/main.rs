//! Poses, twists, wrenches, and the scalars they are generic over.

mod dense_dual;
mod exponential_map;
mod interop;
mod poses;
mod samples_and_tolerances;
mod scalars;
mod wrenches;
