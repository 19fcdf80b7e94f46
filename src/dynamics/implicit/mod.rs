//! Implicit time steps: every stage of every step is a system of equations for the velocities of bodies that touch.
//!
//! A step is taken in passes over the same substeps and stages ([`island_step`], [`stage`]). The real pass in `f64` decides which bodies
//! belong together ([`island`]), how a step is divided ([`advance`], [`substep`], [`errors`]), and which velocities solve each stage
//! ([`newton`]). If the scalar carries derivatives, [`dual_pass`] repeats the stages in that scalar. The reverse sweep reads them from a
//! [`replay`].
//!
//! 1. `ImplicitIntegratorState` keeps data between steps: the wrench on each body in the last
//!    stage, the `StepReport`, and the substeps of the islands (`IslandRecord`). `StepContext` is
//!    the world in `f64` during one step. Predicted bounding boxes and `Force::coupling_groups`
//!    divide the dynamic bodies into *islands*. Each island is solved separately, on any thread. If
//!    a body has left its box for the box of another island, both islands are solved again as one.
//! 2. An `IslandSolver` takes an island through the step. A `Trial` of a substep solves the stages
//!    of the `Scheme`. With SDIRK3, an `ErrorEstimator` estimates two errors. The error of values
//!    is the difference from an embedded formula. For the error of slopes, the velocities and
//!    accelerations at the start are propagated through the linearized stages and compared with the
//!    velocities and accelerations at the end. `ErrorControl` has the tolerances of each body, and
//!    `StepSize` chooses the next duration. A step has a budget of trials. Near the end of the
//!    budget, substeps are longer, and are accepted whatever their errors. A substep that is not
//!    solved is tried again with a quarter of its duration.
//! 3. A stage is the equation P(q̃ ⊕ τu, u) = p̃ + τf for the velocities u at its end, in momenta P
//!    (`StageEquations`). The equations are between momenta, so they have no gyroscopic term. An
//!    `Evaluation` computes the contacts once (`ContactPair::frozen`): exact wrenches, closed-form
//!    elastic derivatives, and the polygons with pressure and slip. The inner iteration is Newton's
//!    method on these *frozen polygons*. It treats the direction of friction exactly and does not
//!    search for contacts. The outer iteration evaluates the contacts again, unless the rate of
//!    convergence predicts that no correction would remain. If it converges slowly, evaluations use
//!    the exact derivatives of friction too. The matrix has 6×6 blocks. From 16 bodies on it is
//!    sparse (`sparse.rs`, the only user of faer), and its symbolic factors are cached while the
//!    same bodies touch.
//! 4. `DualPass` repeats the accepted substeps in `T`. At the real root, u − J⁻¹(r − re r) with the exact real J gives all first
//!    derivatives at once. Each repetition gives the derivatives of the next order. `Replay` repeats the substeps in `f64` for the reverse
//!    sweep.
//!
//! The following rules hold:
//!
//! - The `f64` world decides islands, substeps, iterations and convergence. Values with and without
//!   derivatives solve the same equations. Derivatives hold the durations of substeps fixed.
//!   Durations are rounded to values of a fixed list, so most small changes do not alter them.
//! - The solver measures velocities, not forces. It compares the remaining correction J⁻¹r with the tolerance (the *natural test*), because
//!   stiff contact turns the residual r into rounding errors.
//! - Frozen polygons only lead to the root. The root solves the equations with the exact wrench, because each evaluation starts from the
//!   exact wrench.

mod about_centers;
mod advance;
mod damping;
mod dual_pass;
mod error_control;
mod errors;
mod evaluation;
mod forces;
mod frozen_contact_model;
mod integrator_state;
mod island;
mod island_solver;
mod island_step;
mod islands;
mod linearization;
mod matrix;
mod newton;
mod rates;
mod replay;
mod report;
mod scheme;
mod solved_stage;
#[cfg(feature = "sparse")]
mod sparse;
mod stage;
mod stage_matrix;
mod step_context;
mod step_size;
mod substep;
mod tunneling;

pub(super) use integrator_state::{ImplicitIntegratorState, LastStep, StepSettings};
pub(super) use island::Island;
pub(super) use island_step::{IslandRecord, StepError};
pub(super) use replay::{Replay, ReplayedStage, ReplayedSubstep, StageAdjoint};
pub use report::{BodyErrors, EnergyBalance, StepReport, Work};
pub(super) use scheme::{IMPLICIT_EULER, SDIRK3, Scheme};
pub(super) use step_context::StepContext;
