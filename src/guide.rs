//! No code: the guide, in six chapters.
//!
//! 1. [`pressure_fields`]: shapes, meshes of one's own, and how to choose a modulus.
//! 2. [`contact`]: from two posed bodies to wrench, surface, energy and Jacobian.
//! 3. [`dynamics`]: worlds that move, how long a step may be, and saving what happened.
//! 4. [`gradients`]: derivatives of rollouts, and how far to trust them.
//! 5. [`performance`]: what costs what.
//! 6. [`time_steps`]: which integrator when, and what implicit steps take.
//!
//! The chapters are the files of `docs/guide`. Every Rust block in them runs under
//! `cargo test --doc`.

#[doc = include_str!("../docs/guide/1_pressure_fields.md")]
pub mod pressure_fields {}

#[doc = include_str!("../docs/guide/2_contact.md")]
pub mod contact {}

#[doc = include_str!("../docs/guide/3_dynamics.md")]
pub mod dynamics {}

#[doc = include_str!("../docs/guide/4_gradients.md")]
pub mod gradients {}

#[doc = include_str!("../docs/guide/5_performance.md")]
pub mod performance {}

#[doc = include_str!("../docs/guide/6_time_steps.md")]
pub mod time_steps {}
