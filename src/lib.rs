//! Differentiable pressure-field (hydroelastic) contact between soft-skinned rigid bodies.
//!
//! Each body is a tetrahedral mesh with a pressure field that grows from zero on its surface to a maximum inside. If two bodies
//! overlap, the contact surface is the surface on which their pressures are equal. The contact force is the integral of pressure
//! times normal over the contact surface. This force is continuous and has derivatives. The library computes the force and its
//! derivatives exactly.
//!
//! The modules are the stages of a pipeline. Each module uses only the modules before it:
//!
//! [`scalar`] → [`spatial`] → [`geometry`] → [`mesh`] → [`broad_phase`] → [`contact`] →
//! [`dynamics`] → [`gradient`] → [`identification`], with [`io`] for files. Start with [`contact`], or with the chapters of the [`guide`].
//!
//! # Conventions
//!
//! - SI units throughout.
//! - **Sign**: the contact normal points out of B into A; the wrench on B is the negative of the
//!   wrench on A about the same point.
//! - 6-vectors have the angular part first: (torque, force), (angular, linear).
//! - `pose_ab` maps coordinates in B to coordinates in A, so `pose_wb = pose_wa * pose_ab`.
//! - Shapes are `f64`; poses, moduli and results are generic over [`scalar::Scalar`].
//!
//! # The same bits
//!
//! A program gives the same bits in every run and with any number of threads: wrenches, Jacobians, rollouts, batches and files.
//! The compiler neither fuses nor reorders floating-point operations, so different builds should agree as well. Builds at
//! optimization levels 0 and 2 agreed (`cargo test --test threads reproducible:: -- --nocapture` prints hashes to compare).
//!
//! Contacts, rollouts and their derivatives also have the same bits on every processor and with every C library
//! (`cargo test --test threads every_processor::`). The bits do not depend on the number of SIMD lanes. The crate `libm` computes
//! sines, arctangents and logarithms, with only operations that IEEE 754 defines. Three exceptions depend on the platform:
//!
//! - Implicit steps of at least 16 bodies, because the sparse solver (feature `sparse`) uses fused multiply-add if the processor
//!   has it.
//! - User-defined forces, paths and losses that call functions such as `sin` and `ln` on `f64` or dual numbers.
//! - Quaternions in recordings, which have single precision.
//!
//! Bits may differ between versions of this library, between `f64` and dual numbers, and between dual numbers of different widths.
//! The results agree to round-off.
//!
//! # References
//!
//! - *The paper*: "An Efficient Implementation of Pressure Field Models". This library reimplements its system (in Julia,
//!   Hydroelastics.jl), and adds the derivatives that the paper's system lacks.
//! - \[Clarke 1983\] F. H. Clarke, *Optimization and Nonsmooth Analysis*, Wiley, 1983.
//! - \[Elandt 2019\] R. Elandt, E. Drumwright, M. Sherman, A. Ruina, "A pressure field model for
//!   fast, robust approximation of net contact force and moment between nominally rigid objects",
//!   IROS 2019.
//! - \[Duff 2017\] T. Duff et al., "Building an Orthonormal Basis, Revisited", Journal of Computer Graphics
//!   Techniques 6(1), 2017.
//! - \[Hunt 1975\] K. Hunt, F. Crossley, "Coefficient of restitution interpreted as damping in
//!   vibroimpact", Journal of Applied Mechanics 42(2), 1975.
//! - \[Nielsen 1999\] H. B. Nielsen, "Damping parameter in Marquardt's method", report IMM-REP-1999-05, Technical University of
//!   Denmark, 1999.
//! - \[Okabe 2008\] M. Okabe, K. Ito, "Color Universal Design: how to make figures and presentations
//!   that are friendly to colorblind people", 2008.

// The last bits of the disallowed methods depend on the platform. `scalar::portable` has replacements.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod broad_phase;
mod bvh;
pub mod contact;
mod contact_shape;
pub mod dynamics;
mod friction;
pub mod geometry;
pub mod gradient;
pub mod guide;
pub mod identification;
#[cfg(any(feature = "files", feature = "parry"))]
pub mod io;
mod lanes;
pub mod mesh;
mod narrow_phase;
pub mod parallel;
pub mod scalar;
mod search;
mod seeds;
pub mod spatial;

/// Re-export of nalgebra, whose vectors and matrices the interfaces of this crate use.
pub use nalgebra;
/// Re-export of num-dual, whose numbers implement [`scalar::Scalar`].
pub use num_dual;

/// Compiles and runs the program of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
