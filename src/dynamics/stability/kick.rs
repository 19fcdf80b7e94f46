//! Data of the kick of an explicit step for the stability check.

use crate::contact::ContactWrench;
use crate::dynamics::model::Model;
use crate::dynamics::rigid_motion::turn_between;
use crate::dynamics::{BodyState, Inertia};
use crate::scalar::{Scalar, real_part};
use crate::spatial::{Pose, Twist, Wrench};
use nalgebra::Vector6;

/// Secants below this value need no exact check. A secant of 1 corresponds to half of the largest
/// stable step. With this step, an impact lasts about three kicks. A longer step may reverse a body
/// in a single kick, and the secant is then above 1.
const LARGEST_SECANT: f64 = 1.0;

/// Relative changes of a wrench below this value are round-off of a body at rest. The change by an
/// unstable mode grows beyond this value.
const ROUND_OFF: f64 = 1e-6;

/// Kick of an explicit step.
pub(in crate::dynamics) struct Kick<'a, T> {
    pub time_step: f64,
    /// Twists of all bodies before the kick.
    pub before: &'a [Twist],
    /// All bodies after the kick.
    pub after: &'a [BodyState<T>],
    /// Close pairs of bodies, and their contacts.
    pub pairs: &'a [(usize, usize)],
    pub contacts: &'a [ContactWrench<T>],
    /// Net contact wrench on each body, about its center of mass.
    pub contact: &'a [Wrench<T>],
    /// Wrench of all but gravity on each body.
    pub all: &'a [Wrench<T>],
}

/// One body in a kick, without derivatives.
pub(super) struct KickedBody<'a> {
    inertia: Option<Inertia>,
    pose: Pose,
    pub before: &'a Twist,
    after: Twist,
}

/// Change of the contacts with one body since the last kick.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ContactChange {
    pub last: Vector6<f64>,
    pub now: Vector6<f64>,
    /// Power (W) of the changes of the wrenches of these contacts, summed over both bodies of each
    /// contact.
    pub power: f64,
}

impl<T: Scalar> Kick<'_, T> {
    /// All bodies before the kick, without derivatives.
    pub(super) fn states_before(&self) -> Vec<BodyState<T>> {
        let states = self.after.iter().zip(self.before);
        let before = states.map(|(state, &twist)| BodyState {
            twist,
            ..state.real()
        });
        before.map(|state| state.lifted()).collect()
    }

    /// The body with this index.
    pub(super) fn body(&self, model: &Model<T>, index: usize) -> KickedBody<'_> {
        let after = self.after[index].real();
        KickedBody {
            inertia: model.bodies[index].inertia().map(Inertia::real),
            pose: after.pose,
            before: &self.before[index],
            after: after.twist,
        }
    }

    /// Wrench of all but contact on a body, about its center of mass.
    pub(super) fn other_forces(&self, model: &Model<T>, index: usize) -> Vector6<f64> {
        let mut others = self.all[index].real() + -self.contact[index].real();
        if let Some(inertia) = model.bodies[index].inertia() {
            others.force += model.gravity.map(real_part) * real_part(inertia.mass);
        }
        others.to_vector()
    }
}

impl KickedBody<'_> {
    /// A wrench about the reference point: the center of mass, or the origin of a body without inertia.
    pub fn about_reference<T: Scalar>(&self, wrench: &Wrench<T>) -> Vector6<f64> {
        let center = self.inertia.as_ref().map(|inertia| inertia.center_of_mass);
        let arm = self.pose.rotation() * center.unwrap_or_default();
        wrench.real().about(&arm).to_vector()
    }

    /// Work (J) of a wrench in the kick. For a kinematic body, the motion comes from its twist or from its poses, whichever takes more
    /// energy from the contact. Nothing ensures that the twist of a path is the rate of its poses.
    pub fn work(&self, wrench: &Vector6<f64>, last_pose: Option<&Pose>, time_step: f64) -> f64 {
        let mean = (self.before.to_vector() + self.after.to_vector()) / 2.0;
        let by_twist = wrench.dot(&mean) * time_step;
        match (last_pose, &self.inertia) {
            (Some(last), None) => {
                let turn = turn_between(last.rotation(), self.pose.rotation());
                let shift = self.pose.translation() - last.translation();
                let displacement = Twist {
                    angular: turn,
                    linear: shift,
                }
                .to_vector();
                by_twist.min(wrench.dot(&displacement))
            }
            _ => by_twist,
        }
    }

    /// Energy (J) that a wrench gives to the body from rest in the kick.
    pub fn energy(&self, wrench: &Vector6<f64>, time_step: f64) -> f64 {
        let velocities = self
            .inertia
            .as_ref()
            .map(|inertia| inertia.velocities(self.pose.rotation(), wrench));
        velocities.map_or(0.0, |velocities| {
            wrench.dot(&velocities) * time_step * time_step / 2.0
        })
    }

    /// Whether contact with the body begins, or changes so fast that the time step (s) may be too long for it.
    ///
    /// With the change ΔW of the wrench and the velocities v that led to it, h ΔW·M⁻¹ΔW/|ΔW·v| is a Rayleigh quotient of h²K. The power
    /// ΔW·v includes both bodies of each contact, so it depends on their relative velocities. For elastic contact with a body at rest, the
    /// quotient is a lower bound of the largest eigenvalue. It approaches this eigenvalue as an unstable mode grows.
    pub fn may_exceed_limit(&self, contact: &ContactChange, time_step: f64) -> bool {
        let ContactChange { last, now, power } = contact;
        let change = now - last;
        if self.inertia.is_none() || change.amax() == 0.0 || last.amax() == 0.0 {
            return self.inertia.is_some() && change.amax() > 0.0;
        }
        let [of_change, of_all] =
            [&change, now].map(|wrench| 2.0 * self.energy(wrench, time_step) / time_step);
        of_change > LARGEST_SECANT * power.abs() && of_change > ROUND_OFF * ROUND_OFF * of_all
    }
}
