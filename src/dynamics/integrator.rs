use super::dyn_world::DynWorld;
use super::implicit::{IMPLICIT_EULER, SDIRK3, Scheme};
use super::model::Model;
use super::workspace::Workspace;
use super::wrenches::all_wrenches;
use super::{BodyState, Inertia, State, TimeSpan};
use crate::scalar::Scalar;
use crate::spatial::{Twist, Wrench};

/// Method that advances a state by one time step.
///
/// # Explicit steps
///
/// [`SymplecticEuler`](Self::SymplecticEuler) and [`Leapfrog`](Self::Leapfrog) alternate between two exact parts of the motion. A *kick*
/// changes the velocities by the accelerations at fixed poses. A *drift* moves the bodies freely. The forces of a pair balance in a kick,
/// and a drift keeps all momenta, so momentum and angular momentum are conserved to round-off. In a drift the center of mass moves on a
/// straight line. The body turns about it by a splitting that is symplectic, of second order, and exact for spheres and symmetric tops. The
/// step must be short compared with the periods of the contacts ([`World::largest_stable_step`](super::World::largest_stable_step)).
///
/// # Implicit steps
///
/// [`Sdirk3`](Self::Sdirk3) and [`ImplicitEuler`](Self::ImplicitEuler) solve each stage for the velocities u at its end:
/// P(q̃ ⊕ τu, u) = p̃ + τ f(q̃ ⊕ τu, u). Here P are the momenta, f the wrenches at the end of the stage, q̃ and p̃ the poses and momenta at its start, and τ
/// its duration. Steps of 1 to 10 ms suit most tasks, however stiff the contact and small the slip tolerance. Bodies that do not touch are
/// solved separately, and their steps are divided separately. Derivatives are exact for the discrete steps, by the implicit function
/// theorem. Stages are solved to [`Plan::with_solver_tolerance`](super::Plan::with_solver_tolerance).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Integrator {
    /// Kick, then drift. This is the scheme of the paper (§V, there for equal moments). It is symplectic and of first order.
    SymplecticEuler,
    /// Half a drift, kick, half a drift. It is of second order, symplectic and time-reversible if
    /// forces do not depend on velocities. Forces that depend on velocities (dissipation, friction,
    /// drag) use the velocities before the kick, which is of first order. Like
    /// [`SymplecticEuler`](Self::SymplecticEuler), it evaluates the contacts once per step.
    #[default]
    Leapfrog,
    /// Three implicit stages, third order, L-stable and stiffly accurate \[Alexander 1977\]. The time step is the longest substep and the
    /// interval between states. A step is divided until the errors of values and of derivatives are below the tolerances of
    /// [`Plan::with_accuracy`](super::Plan::with_accuracy). The derivatives then approximate the derivatives of the motion. Rest, sliding
    /// and flight take one substep. If two separate bodies might collide within a substep, their relative motion in it is at most the sum
    /// of their thicknesses.
    Sdirk3,
    /// One implicit stage, first order. It is the cheapest method, and damps motion that is fast compared with the step: bodies come to
    /// rest and do not bounce. Its derivatives are the derivatives of the damped motion. They are correct for pushing, sliding and settling,
    /// and wrong for bouncing. A step is divided only if a stage is not solved. A body that moves by more than its own size in a step may
    /// pass through another body. A body that is wholly inside another body feels no force.
    ImplicitEuler,
}

impl Integrator {
    /// Whether each step solves a system of equations.
    #[must_use]
    pub fn is_implicit(self) -> bool {
        matches!(self.kind(), Kind::Implicit(_))
    }

    /// Kind of the integrator, with its splitting or scheme.
    pub(super) fn kind(self) -> Kind {
        match self {
            Self::SymplecticEuler => Kind::Explicit(Splitting::KickDrift),
            Self::Leapfrog => Kind::Explicit(Splitting::DriftKickDrift),
            Self::Sdirk3 => Kind::Implicit(&SDIRK3),
            Self::ImplicitEuler => Kind::Implicit(&IMPLICIT_EULER),
        }
    }
}

/// An explicit splitting or an implicit scheme.
pub(super) enum Kind {
    Explicit(Splitting),
    Implicit(&'static Scheme),
}

/// Order of kick and drifts in an explicit step.
#[derive(Clone, Copy)]
pub(super) enum Splitting {
    KickDrift,
    DriftKickDrift,
}

impl Splitting {
    /// Advances a state to the kick, in the first part of a time step (s).
    pub(super) fn approach<T: Scalar>(
        self,
        model: &Model<T>,
        state: &mut State<T>,
        time_step: f64,
    ) {
        let [share, _] = self.drifts();
        if share > 0.0 {
            model.drift(state, share * time_step);
        }
    }

    /// Applies all forces for the time step (s) at fixed poses. Controls are averaged over the step.
    pub(super) fn kick<T: Scalar>(
        self,
        world: &dyn DynWorld<T>,
        state: &mut State<T>,
        time_step: f64,
        workspace: &mut Workspace<T>,
    ) {
        let span = self.span(state, time_step);
        let wrenches = all_wrenches(world, state, span, workspace);
        accelerate(world.model(), state, wrenches, time_step);
    }

    /// Advances a state from the kick to the end of a time step (s).
    pub(super) fn depart<T: Scalar>(self, model: &Model<T>, state: &mut State<T>, time_step: f64) {
        let [_, share] = self.drifts();
        model.drift(state, share * time_step);
    }

    /// Fractions of the time step in which bodies drift, before and after the kick.
    pub(super) fn drifts(self) -> [f64; 2] {
        match self {
            Self::KickDrift => [0.0, 1.0],
            Self::DriftKickDrift => [0.5, 0.5],
        }
    }

    /// Time span of a step with this duration (s) whose kick is at the time of a state.
    pub(super) fn span<T: Scalar>(self, state: &State<T>, time_step: f64) -> TimeSpan {
        let [before, _] = self.drifts();
        TimeSpan::new(state.time - before * time_step, time_step)
    }
}

/// Changes the velocities by gravity and by wrenches about the centers of mass that act for a time (s).
pub(super) fn accelerate<T: Scalar>(
    model: &Model<T>,
    state: &mut State<T>,
    wrenches: &[Wrench<T>],
    duration: f64,
) {
    let Model {
        bodies, gravity, ..
    } = model;
    let bodies = bodies.iter().zip(&mut state.bodies);
    for ((body, body_state), wrench) in bodies.zip(wrenches) {
        let Some(inertia) = body.inertia() else {
            continue;
        };
        let rotation = body_state.pose.rotation();
        let angular = inertia.angular_velocity(rotation, &wrench.torque);
        let linear = wrench.force / inertia.mass + gravity;
        let twist = &mut body_state.twist;
        twist.angular += angular.map(|component| component * duration);
        twist.linear += linear.map(|component| component * duration);
    }
}

impl<T: Scalar> Model<T> {
    /// Moves dynamic bodies freely and kinematic bodies along their paths, for a time (s).
    fn drift(&self, state: &mut State<T>, duration: f64) {
        state.time += duration;
        for (index, body_state) in state.bodies.iter_mut().enumerate() {
            match self.bodies[index].inertia() {
                Some(inertia) => move_freely(body_state, inertia, duration),
                None => {
                    if let Some(driven) = self.prescribed_state(index, state.time) {
                        *body_state = driven;
                    }
                }
            }
        }
    }
}

/// Moves the center of mass on a straight line and turns the body about it.
fn move_freely<T: Scalar>(state: &mut BodyState<T>, inertia: &Inertia<T>, duration: f64) {
    let Twist { angular, linear } = &mut state.twist;
    let moved = linear.map(|component| component * duration);
    let principal = &inertia.principal;
    let (rotation, spin) = principal.turned_freely(state.pose.rotation(), angular, duration);
    state.pose = inertia.turned_and_moved(&state.pose, &rotation, &moved);
    *angular = spin;
}
