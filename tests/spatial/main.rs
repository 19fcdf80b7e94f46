//! Poses, twists, wrenches, and the scalars they are generic over.

mod dense_dual;
mod interop;
mod poses;
