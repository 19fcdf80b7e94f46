//! Implicit time steps: every stage of every step is a system of equations for the velocities of bodies that touch.
//!
//! A step is taken in passes over the same substeps and stages ([`island_step`], [`stage`]). The real pass in `f64` decides
//! which bodies belong together ([`island`]), how a step is divided ([`advance`], [`substep`], [`errors`]), and the velocities
//! that solve each stage ([`newton`]). If the scalar carries derivatives, [`dual_pass`] repeats the stages in that scalar. The reverse sweep
//! reads them from a [`replay`].

mod about_centers;
mod advance;
mod damping;
mod dual_pass;
mod error_control;
mod errors;
mod evaluation;
mod forces;
mod island;
mod island_step;
mod linearization;
mod matrix;
mod memory;
mod newton;
mod pair_model;
mod replay;
mod report;
mod rigid;
mod scene;
mod scheme;
mod solved_stage;
#[cfg(feature = "sparse")]
mod sparse;
mod stage;
mod step_size;
mod substep;
mod tunneling;

pub(super) use island::Island;
pub(super) use island_step::{StepError, Trace};
pub(super) use memory::{LastStep, Memory, Step};
pub(super) use replay::{Replay, ReplayedStage, ReplayedSubstep};
pub use report::{BodyErrors, EnergyBalance, StepReport, Work};
pub(super) use rigid::displaced_back;
pub(super) use scene::Scene;
pub(super) use scheme::{IMPLICIT_EULER, SDIRK3, Scheme};
