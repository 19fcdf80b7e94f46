//! Implicit time steps: every stage of every step is a system of equations for the velocities of bodies that touch.
//!
//! A step is taken twice over. First in `f64`, whatever the scalar: which bodies belong together ([`island`]), how a step is
//! divided ([`steps`]), and the velocities that solve each stage ([`newton`], [`problem`]). Then, if the scalar carries
//! derivatives, along the same stages in that scalar ([`carried`]).

mod about_centers;
mod attempt;
mod carried;
mod carried_stage;
mod forces;
mod island;
mod matrix;
mod memory;
mod newton;
mod pair_model;
mod problem;
mod report;
mod rigid;
mod scene;
mod scheme;
#[cfg(feature = "sparse")]
mod sparse;
mod steps;
mod trace;

pub(super) use island::Island;
pub(super) use memory::{Memory, Step};
use pair_model::PairWrenches;
pub use report::{EnergyBalance, StepReport, Work};
pub(super) use rigid::displaced_back;
pub(super) use scene::Scene;
pub(super) use scheme::{IMPLICIT_EULER, SDIRK2, Scheme};
pub(super) use steps::Stuck;
pub(super) use trace::{Follower, PartTaken, StageTaken, Trace};
