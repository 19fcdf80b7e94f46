use super::dyn_world::DynWorld;
use super::implicit::{IMPLICIT_EULER, SDIRK3, Scheme};
use super::model::Model;
use super::workspace::Workspace;
use super::wrenches::all_wrenches;
use super::{BodyState, Inertia, State, TimeSpan};
use crate::scalar::Scalar;
use crate::spatial::{Twist, Wrench};

/// How a state is taken one time step further.
///
/// # Explicit steps
///
/// [`SymplecticEuler`](Self::SymplecticEuler) and [`Leapfrog`](Self::Leapfrog) alternate between two exact parts of the
/// motion. A *kick* changes the velocities by the accelerations at fixed poses; a *drift* moves the bodies freely. Forces in
/// pairs balance in a kick and momenta stay in a drift, so momentum and angular momentum are conserved to round-off. In a
/// drift the center of mass moves straight on, and the body turns about it by a splitting that is symplectic, of second
/// order, and exact for spheres and symmetric tops. The step must be short against the contacts' periods
/// ([`World::largest_stable_step`](super::World::largest_stable_step)).
///
/// # Implicit steps
///
/// [`Sdirk3`](Self::Sdirk3) and [`ImplicitEuler`](Self::ImplicitEuler) solve, in each stage, for velocities u that the wrenches f
/// at the end of the stage lead to: P(q̃ ⊕ τu, u) = p̃ + τ f(q̃ ⊕ τu, u), with momenta P, poses q̃ and momenta p̃ to start
/// from, and the duration τ. Steps may be as long as the task allows, 1 to 10 ms for most, however stiff the contact and small
/// the slip tolerance. Bodies that do not touch are solved, and their steps divided, by themselves. Derivatives are exact for the
/// steps that are taken, by the implicit function theorem. Stages are solved to [`Plan::with_solver_tolerance`](super::Plan::with_solver_tolerance).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Integrator {
    /// Kick, then drift: the paper's scheme (§V, there for equal moments), first order, symplectic.
    SymplecticEuler,
    /// Half a drift, kick, half a drift: second order, symplectic and time-reversible as long as
    /// forces do not depend on velocities. Those that do (dissipation, friction, drag) are taken at
    /// the velocities before the kick, which is first order. The same cost: one evaluation of the contacts per step.
    #[default]
    Leapfrog,
    /// Three stages, each an implicit equation for the velocities, of third order, L-stable and stiffly accurate
    /// \[Alexander 1977\]. The time step is the longest substep and the interval between states. A step is divided until the errors of
    /// values and of derivatives are below the tolerances of [`Plan::with_accuracy`](super::Plan::with_accuracy), so that derivatives
    /// are those of the motion. Rest, sliding and flight take one substep. If two bodies that are apart might collide within a substep,
    /// they move relative to each other by at most the sum of their thicknesses in it.
    Sdirk3,
    /// One implicit stage, of first order. It is the cheapest choice, and damps whatever is fast compared with the step: bodies
    /// come to rest and do not bounce. Its derivatives are those of the damped motion: right for pushing, sliding and settling,
    /// and wrong for what bounces. The step is divided only if a stage is not solved: a body that moves by more than its own size
    /// in a step may pass through another, and what is wholly inside another feels no force.
    ImplicitEuler,
}

impl Integrator {
    /// Whether each step solves a system of equations.
    #[must_use]
    pub fn is_implicit(self) -> bool {
        matches!(self.kind(), Kind::Implicit(_))
    }

    /// Whether it is an explicit scheme, and which.
    pub(super) fn kind(self) -> Kind {
        match self {
            Self::SymplecticEuler => Kind::Explicit(Splitting::KickDrift),
            Self::Leapfrog => Kind::Explicit(Splitting::DriftKickDrift),
            Self::Sdirk3 => Kind::Implicit(&SDIRK3),
            Self::ImplicitEuler => Kind::Implicit(&IMPLICIT_EULER),
        }
    }
}

/// An integrator by what it does.
pub(super) enum Kind {
    Explicit(Splitting),
    Implicit(&'static Scheme),
}

/// How kicks and drifts make up an explicit step.
#[derive(Clone, Copy)]
pub(super) enum Splitting {
    KickDrift,
    DriftKickDrift,
}

impl Splitting {
    /// The first part of a time step (s): takes a state to where the kick acts.
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

    /// Lets all forces act for the time step (s) at fixed poses. Controls act by their means over the step.
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

    /// The rest of the time step.
    pub(super) fn depart<T: Scalar>(self, model: &Model<T>, state: &mut State<T>, time_step: f64) {
        let [_, share] = self.drifts();
        model.drift(state, share * time_step);
    }

    /// The parts of a time step that bodies drift for before the kick, and after it.
    pub(super) fn drifts(self) -> [f64; 2] {
        match self {
            Self::KickDrift => [0.0, 1.0],
            Self::DriftKickDrift => [0.5, 0.5],
        }
    }

    /// The time step of this duration (s) that has its kick at a state.
    pub(super) fn span<T: Scalar>(self, state: &State<T>, time_step: f64) -> TimeSpan {
        let [before, _] = self.drifts();
        TimeSpan::new(state.time - before * time_step, time_step)
    }
}

/// Changes the velocities by gravity and wrenches about the centers of mass, which act for a time (s).
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
    /// Lets all bodies move freely, or as prescribed, for a time (s).
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

/// The center of mass moves straight on; the body turns about it.
fn move_freely<T: Scalar>(state: &mut BodyState<T>, inertia: &Inertia<T>, duration: f64) {
    let Twist { angular, linear } = &mut state.twist;
    let moved = linear.map(|component| component * duration);
    let principal = &inertia.principal;
    let (rotation, spin) = principal.turned_freely(state.pose.rotation(), angular, duration);
    state.pose = inertia.turned_and_moved(&state.pose, &rotation, &moved);
    *angular = spin;
}
