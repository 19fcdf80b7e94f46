use super::workspace::Workspace;
use super::{Acceleration, Body, BodyState, ExternalForces, Inertia, Situation, State, World};
use crate::scalar::Scalar;
use crate::spatial::{Pose, Twist, turned_about_own_axis, turned_by};
use nalgebra::{Matrix3, Vector3};

/// How a state is taken one time step further.
///
/// Both schemes alternate between two exact parts of the motion. A *kick* changes the velocities by
/// the accelerations at fixed poses; a *drift* moves the bodies freely. Forces in pairs balance in
/// a kick and momenta stay in a drift, so momentum and angular momentum are conserved to round-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Integrator {
    /// Kick, then drift: the paper's scheme (§V), first order, symplectic. Bodies turn about their
    /// centres of mass by the exponential map.
    SymplecticEuler,
    /// Half a drift, kick, half a drift: second order, symplectic and time-reversible as long as
    /// forces do not depend on velocities. Those that do (dissipation, friction, drag) are taken at
    /// the velocities before the kick, which is first order. Bodies turn freely by rotations about
    /// their principal axes in a symmetric order, which conserve the angular momentum. The same
    /// cost: one evaluation of the contacts per step.
    #[default]
    Leapfrog,
}

impl Integrator {
    /// Takes a state one time step (s) further.
    pub(super) fn step<T: Scalar, F: ExternalForces>(
        self,
        world: &World<T, F>,
        state: &mut State<T>,
        time_step: f64,
        workspace: &mut Workspace<T>,
    ) {
        match self {
            Self::SymplecticEuler => {
                world.kick(state, time_step, workspace);
                world.drift(state, time_step, turned_by_spin);
            }
            Self::Leapfrog => {
                let half = time_step / 2.0;
                world.drift(state, half, turned_by_axes);
                world.kick(state, time_step, workspace);
                world.drift(state, half, turned_by_axes);
            }
        }
    }
}

/// A way to turn a free body: orientation and spin after a time (s).
type Turning<T> = fn(&Inertia<T>, &Matrix3<T>, &Vector3<T>, f64) -> (Matrix3<T>, Vector3<T>);

impl<T: Scalar, F: ExternalForces> World<T, F> {
    /// Lets the accelerations act for a time (s) at fixed poses.
    fn kick(&self, state: &mut State<T>, duration: f64, workspace: &mut Workspace<T>) {
        let wrenches = self.contact_wrenches(&state.bodies, workspace);
        let bodies = self.bodies.iter().zip(&mut state.bodies);
        for ((body, body_state), wrench) in bodies.zip(wrenches) {
            let Some(inertia) = body.inertia() else {
                continue;
            };
            let rotation = body_state.pose.rotation();
            let contact = Acceleration {
                angular: inertia.angular_velocity(rotation, &wrench.torque),
                linear: wrench.force / inertia.mass,
            };
            let situation = self.situation(body, inertia, body_state, state.time);
            let acceleration = self.external.acceleration(&situation, contact);
            let twist = &mut body_state.twist;
            twist.angular += acceleration.angular.map(|component| component * duration);
            twist.linear += acceleration.linear.map(|component| component * duration);
        }
    }

    fn situation<'a>(
        &'a self,
        body: &'a Body<T>,
        inertia: &Inertia<T>,
        state: &'a BodyState<T>,
        time: f64,
    ) -> Situation<'a, T> {
        Situation {
            time,
            body: body.name(),
            mass: inertia.mass,
            state,
            gravity: &self.gravity,
        }
    }

    /// Lets all bodies move freely, or as prescribed, for a time (s).
    fn drift(&self, state: &mut State<T>, duration: f64, turning: Turning<T>) {
        state.time += duration;
        for (index, body_state) in state.bodies.iter_mut().enumerate() {
            match self.bodies[index].inertia() {
                Some(inertia) => move_freely(body_state, inertia, duration, turning),
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
fn move_freely<T: Scalar>(
    state: &mut BodyState<T>,
    inertia: &Inertia<T>,
    duration: f64,
    turning: Turning<T>,
) {
    let Twist { angular, linear } = &mut state.twist;
    let center_before = state.pose.rotated_constant(&inertia.center_of_mass);
    let moved = linear.map(|component| component * duration);
    let (rotation, spin) = turning(inertia, state.pose.rotation(), angular, duration);
    let turned = Pose::from_drifted_rotation(&rotation);
    let center_after = turned.rotated_constant(&inertia.center_of_mass);
    let origin = state.pose.translation() + center_before + moved - center_after;
    state.pose = turned.with_translation(origin);
    *angular = spin;
}

/// By the exponential of the spin at the start; the spin at the end follows from the angular
/// momentum, which stays.
fn turned_by_spin<T: Scalar>(
    inertia: &Inertia<T>,
    rotation: &Matrix3<T>,
    spin: &Vector3<T>,
    duration: f64,
) -> (Matrix3<T>, Vector3<T>) {
    let turned = turned_by(rotation, &spin.map(|rate| rate * duration));
    if inertia.is_isotropic() {
        return (turned, *spin);
    }
    let momentum = inertia.unit_momentum(&inertia.principal_frame(rotation), spin);
    let spin_after = inertia.velocity_of_unit(&inertia.principal_frame(&turned), &momentum);
    (turned, spin_after)
}

/// By rotations about the principal axes in the order 1 2 3 2 1, half the time for each but the
/// third: each is the exact motion of a body with one finite moment. A body of equal moments turns
/// steadily, which is exact.
fn turned_by_axes<T: Scalar>(
    inertia: &Inertia<T>,
    rotation: &Matrix3<T>,
    spin: &Vector3<T>,
    duration: f64,
) -> (Matrix3<T>, Vector3<T>) {
    if inertia.is_isotropic() {
        return turned_by_spin(inertia, rotation, spin, duration);
    }
    let mut frame = inertia.principal_frame(rotation);
    // Free motion is the same whatever the mass.
    let momentum = inertia.unit_momentum(&frame, spin);
    for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        let along: T = frame.column(axis).dot(&momentum);
        let angle = along * (share * duration / inertia.unit_moments[axis]);
        frame = turned_about_own_axis(&frame, axis, angle);
    }
    let spin_after = inertia.velocity_of_unit(&frame, &momentum);
    (inertia.rotation_of(&frame), spin_after)
}
