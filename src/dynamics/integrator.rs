use super::any_world::AnyWorld;
use super::system::System;
use super::workspace::Workspace;
use super::wrenches::all_wrenches;
use super::{BodyState, Inertia, State};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Twist};

/// How a state is taken one time step further.
///
/// Both schemes alternate between two exact parts of the motion. A *kick* changes the velocities by
/// the accelerations at fixed poses; a *drift* moves the bodies freely. Forces in pairs balance in
/// a kick and momenta stay in a drift, so momentum and angular momentum are conserved to round-off. In a drift the centre
/// of mass moves straight on, and the body turns about it by a splitting that is symplectic, of second order, and exact for
/// spheres and symmetric tops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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
}

impl Integrator {
    /// The first part of a time step (s): takes a state to where the kick acts.
    pub(super) fn approach<T: Scalar>(
        self,
        system: &System<T>,
        state: &mut State<T>,
        time_step: f64,
    ) {
        match self {
            Self::SymplecticEuler => {}
            Self::Leapfrog => system.drift(state, time_step / 2.0),
        }
    }

    /// The rest of the time step.
    pub(super) fn complete<T: Scalar>(
        self,
        world: &dyn AnyWorld<T>,
        state: &mut State<T>,
        time_step: f64,
        workspace: &mut Workspace<T>,
    ) {
        let middle = match self {
            Self::SymplecticEuler => state.time + time_step / 2.0,
            Self::Leapfrog => state.time,
        };
        kick(world, state, time_step, middle, workspace);
        let system = world.system();
        match self {
            Self::SymplecticEuler => system.drift(state, time_step),
            Self::Leapfrog => system.drift(state, time_step / 2.0),
        }
    }
}

/// Lets all forces act for a time (s) at fixed poses, the controls as they are in the middle of the step.
fn kick<T: Scalar>(
    world: &dyn AnyWorld<T>,
    state: &mut State<T>,
    duration: f64,
    middle: f64,
    workspace: &mut Workspace<T>,
) {
    let wrenches = all_wrenches(world, state, middle, workspace);
    let System {
        bodies, gravity, ..
    } = world.system();
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

impl<T: Scalar> System<T> {
    /// Lets all bodies move freely, or as prescribed, for a time (s).
    fn drift(&self, state: &mut State<T>, duration: f64) {
        state.time += duration;
        for (index, body_state) in state.bodies.iter_mut().enumerate() {
            match self.bodies[index].inertia() {
                Some(inertia) => move_freely(body_state, inertia, duration),
                None => {
                    if let Some(driven) = self.driven_state(index, state.time) {
                        *body_state = driven;
                    }
                }
            }
        }
    }
}

/// The centre of mass moves straight on; the body turns about it.
fn move_freely<T: Scalar>(state: &mut BodyState<T>, inertia: &Inertia<T>, duration: f64) {
    let Twist { angular, linear } = &mut state.twist;
    let center_before = state.pose.rotated_constant(&inertia.center_of_mass);
    let moved = linear.map(|component| component * duration);
    let principal = &inertia.principal;
    let (rotation, spin) = principal.turned_freely(state.pose.rotation(), angular, duration);
    let turned = Pose::from_drifted_rotation(&rotation);
    let center_after = turned.rotated_constant(&inertia.center_of_mass);
    let origin = state.pose.translation() + center_before + moved - center_after;
    state.pose = turned.with_translation(origin);
    *angular = spin;
}
