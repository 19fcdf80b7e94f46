//! Guide to the library, in eight chapters. This module has no code.
//!
//! 1. [`pressure_fields`]: shapes, your own meshes, and the choice of a modulus.
//! 2. [`contact`]: wrench, surface, energy and Jacobian of two posed bodies.
//! 3. [`dynamics`]: worlds, rollouts, limits of the time step, and files.
//! 4. [`gradients`]: derivatives of rollouts, and their accuracy.
//! 5. [`performance`]: cost of each stage.
//! 6. [`time_steps`]: choice of an integrator, and cost of implicit steps.
//! 7. [`robots`]: joints, robots from files, and equations of motion.
//! 8. [`identification`]: estimates of moduli, friction and other numbers from measured motions.
//!
//! The chapters are the files of `docs/guide`. `cargo test --doc` runs every Rust block in them.

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

#[doc = include_str!("../docs/guide/7_robots.md")]
pub mod robots {}

#[doc = include_str!("../docs/guide/8_identification.md")]
pub mod identification {}
