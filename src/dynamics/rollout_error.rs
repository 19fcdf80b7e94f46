use super::{Integrator, WorldError};
use crate::parallel::Panicked;

/// Reason why a rollout ended early.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RolloutError {
    /// The start state does not fit the world.
    #[error(transparent)]
    State(#[from] WorldError),
    /// A body starts wholly below the surface of a half-space, without a contact that pushes it out.
    #[error(
        "body {:?} starts wholly below the surface of half-space {:?}, and no contact pushes it out: start it above (z > 0 in the frame of the half-space), turn the half-space, or ignore the pair",
        .bodies[0], .bodies[1]
    )]
    StartsBelow {
        /// Names of the body and of the half-space.
        bodies: [String; 2],
    },
    /// The slip tolerance of the world is too small for implicit steps. Friction would change by its full value within the accuracy of the
    /// velocities of a stage.
    #[error(
        "implicit steps need a slip tolerance of at least {least:e} m/s, but that of the world is {found:e} m/s: raise it by World::with_slip_tolerance"
    )]
    SlipTolerance {
        /// Slip tolerance of the world (m/s).
        found: f64,
        /// Smallest valid slip tolerance (m/s).
        least: f64,
    },
    /// The world has joints, but the integrator is explicit.
    #[error(
        "steps of {integrator:?} cannot integrate joints, but body {body:?} has a joint: use Integrator::Sdirk3 or Integrator::ImplicitEuler"
    )]
    Joints {
        /// Integrator of the plan.
        integrator: Integrator,
        /// Name of the first body on a joint, or of a body of a loop joint.
        body: String,
    },
    /// The rollout was [stopped](super::Rollout::with_cancel_flag), or its batch ended before the
    /// rollout began.
    #[error("the rollout was stopped before its end")]
    Stopped,
    /// A state is no longer finite.
    #[error(
        "step {step} (t = {time} s) took body {body:?} to a state that is not finite: the time step may be too long for its stiffness (see World::largest_stable_step)"
    )]
    NotFinite {
        /// Step that led to the state, counted from 1.
        step: usize,
        /// Time of the state (s).
        time: f64,
        /// Name of the body.
        body: String,
    },
    /// The path of a kinematic body returned a pose or a twist that is not finite.
    #[error("step {step} (t = {time} s): the path of body {body:?} is not finite")]
    PathNotFinite {
        /// Step that leads to this time, counted from 1.
        step: usize,
        /// Time (s).
        time: f64,
        /// Name of the body.
        body: String,
    },
    /// The sum of contact and other forces on a body is not finite in an implicit step.
    #[error(
        "step {step} (t = {time} s): the sum of the forces on body {body:?} is not finite; a force that was passed in may divide by zero"
    )]
    ForceNotFinite {
        /// Step that was not taken, counted from 1.
        step: usize,
        /// Time (s).
        time: f64,
        /// Name of the body.
        body: String,
    },
    /// An explicit time step is too long for the contacts, so the rollout ends before it becomes unstable.
    /// [`Plan::without_stability_check`](super::Plan::without_stability_check) turns this check off.
    #[error(
        "step {step} (from t = {time:.6} s) was not taken: the time step of {time_step:.3e} s exceeds {limit:.3e} s, the stability limit of the contacts; the stiffest contact is that of bodies {:?} and {:?}; use shorter steps or an implicit integrator (Sdirk3), or make the contact softer",
        .bodies[0], .bodies[1]
    )]
    TimeStepTooLong {
        /// Step that was not taken, counted from 1.
        step: usize,
        /// Time at the start of the step (s).
        time: f64,
        /// Time step (s).
        time_step: f64,
        /// [`World::largest_stable_step`](super::World::largest_stable_step) without friction, at the poses of the contacts (s).
        limit: f64,
        /// Names of the two bodies whose contact alone has the smallest limit.
        bodies: [String; 2],
    },
    /// A contact created energy in explicit time steps: it returned more than twice the energy that it absorbed. Either a body moved far
    /// into another body within a step, or successive bounces gained energy.
    #[error(
        "step {step} (from t = {time:.6} s) was not taken: the contact of bodies {:?} and {:?} would have returned {returned:.3e} J, after it absorbed {absorbed:.3e} J; the time step of {time_step:.3e} s is too long for their impacts; use shorter steps or an implicit integrator (Sdirk3)",
        .bodies[0], .bodies[1]
    )]
    EnergyGained {
        /// Step that was not taken, counted from 1.
        step: usize,
        /// Time at the start of the step (s).
        time: f64,
        /// Time step (s).
        time_step: f64,
        /// Names of the two bodies.
        bodies: [String; 2],
        /// Energy that the contact absorbed from the bodies, or stored at the start of the rollout (J).
        absorbed: f64,
        /// Energy that the contact would have returned to the bodies (J).
        returned: f64,
    },
    /// The equations of an implicit step were not solved, although the step was divided down to the shortest duration.
    #[error(
        "step {step} (from t = {time:.6} s) was not solved, down to {shortest:.3e} s: body {body:?} is the farthest from a solution; it may have started deep inside another, or a force may not be smooth"
    )]
    NotSolved {
        /// Step that was not taken, counted from 1.
        step: usize,
        /// Time at the start of the step (s).
        time: f64,
        /// Name of the body whose velocity is farthest from a solution.
        body: String,
        /// Shortest duration that was tried (s).
        shortest: f64,
    },
    /// A user function panicked: a force, a path, an outcome, or the function of [`Batch::map`](super::Batch::map). A program that
    /// aborts on panic does not return this error.
    #[error("a force, a path, an outcome or the function of a batch panicked: {message}")]
    Panicked {
        /// Panic message.
        message: String,
    },
}

impl From<Panicked> for RolloutError {
    fn from(Panicked(message): Panicked) -> Self {
        Self::Panicked { message }
    }
}
