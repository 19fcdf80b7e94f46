//! Stability check of every explicit step, based on the contact wrenches of its kick. The check
//! detects steps that may be too long, and contacts that have created energy.
//!
//! The net work of a contact on its two bodies is at most the energy that the contact stored at the
//! start. The reason is that a contact returns the energy that it absorbed, less the losses by
//! dissipation and friction. This bound holds in every frame, for kinematic bodies, and for any
//! motion of other bodies. A contact has created energy if it returned more than twice the energy
//! that it absorbed. The factor of two leaves room for stable steps, in which the energy of a mode
//! oscillates.

use super::kick::{ContactChange, Kick, KickedBody};
use super::limit::stiffest;
use crate::dynamics::BodyState;
use crate::dynamics::model::Model;
use crate::scalar::Scalar;
use crate::spatial::Pose;
use nalgebra::Vector6;
use std::mem;

/// A stability limit of more than this number of time steps is far away. No comparison is required
/// for steps below half of the limit.
const FAR: f64 = 2.0;

/// Longest pause between comparisons with the limit, in steps. A comparison costs several steps.
const LONGEST_PAUSE: usize = 31;

/// Energy balances of the contacts of a rollout, over its explicit steps.
#[derive(Debug, Clone, Default)]
pub(in crate::dynamics) struct ContactBalances {
    /// All bodies at the start of the rollout.
    start: Vec<BodyState>,
    /// Bodies and contacts after the last accepted step.
    last: Kicked,
    /// Bodies and contacts after the kick that is checked.
    next: Kicked,
    /// Change of the contacts with each body in the kick.
    changes: Vec<ContactChange>,
}

/// Bodies and contacts after a kick.
#[derive(Debug, Clone, Default)]
struct Kicked {
    poses: Vec<Pose>,
    /// Contacts that act or have a net gain of energy, sorted by their bodies.
    contacts: Vec<Balance>,
    /// Remaining steps until the next comparison with the limit.
    pause: usize,
    /// Length (steps) of the last pause.
    last_pause: usize,
}

/// Work of a contact on its two bodies.
#[derive(Debug, Clone)]
struct Balance {
    /// Indices of the two bodies, A first.
    bodies: [usize; 2],
    /// Wrenches in the kick, about the reference points of the two bodies, or zero if the contact
    /// does not act.
    now: [Vector6<f64>; 2],
    /// Wrenches in the last kick.
    last: [Vector6<f64>; 2],
    /// Energy (J) stored at the start of the rollout, or `None` if it has not been evaluated.
    stored: Option<f64>,
    /// Net work (J) since the contact began.
    net_work: f64,
    /// Largest net energy (J) that the bodies have given to the contact.
    absorbed: f64,
}

/// Reason why a step is too long. `bodies` are the indices of the two bodies of the contact.
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) enum Instability {
    /// The time step exceeds the stability limit (s). The contact is the stiffest one.
    AboveLimit { bodies: [usize; 2], limit: f64 },
    /// The contact has returned much more energy (J) than it absorbed or stored at the start.
    EnergyGain {
        bodies: [usize; 2],
        absorbed: f64,
        returned: f64,
    },
}

const ZERO: [Vector6<f64>; 2] = [Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0); 2];

impl ContactBalances {
    /// Checks a kick of a rollout that began at a state. Returns the reason if the time step is too long. [`Self::accept`] keeps the
    /// kick.
    pub fn check<T: Scalar>(
        &mut self,
        model: &Model<T>,
        kick: &Kick<T>,
        start: &[BodyState<T>],
    ) -> Option<Instability> {
        if self.start.is_empty() {
            self.start.extend(start.iter().map(BodyState::real));
        }
        self.set_wrenches(model, kick);
        self.changes.clear();
        self.changes
            .resize(kick.after.len(), ContactChange::default());
        let mut gain = None;
        for balance in &mut self.next.contacts {
            let bodies = balance.bodies.map(|index| kick.body(model, index));
            balance.add_change(&bodies, &mut self.changes);
            let last_poses = balance.bodies.map(|index| self.last.poses.get(index));
            balance.add_work(&bodies, last_poses, kick.time_step);
            let others = balance.bodies.map(|index| kick.other_forces(model, index));
            let allowed = balance.allowed(&bodies, &others, kick.time_step);
            if balance.has_created(allowed) {
                let stored = || model.stored_energy(balance.bodies, &self.start);
                balance.stored.get_or_insert_with(stored);
                if balance.has_created(allowed) {
                    gain.get_or_insert(balance.gain());
                }
            }
        }
        let mut changes = self.changes.iter().enumerate();
        let may_exceed = changes.any(|(index, change)| {
            change.now != change.last
                && kick
                    .body(model, index)
                    .may_exceed_limit(change, kick.time_step)
        });
        let poses = kick.after.iter().map(|state| state.pose.real());
        self.next.poses.clear();
        self.next.poses.extend(poses);
        let above_limit = self.compared_with_limit(model, kick, may_exceed);
        above_limit.or(gain)
    }

    /// Compares the time step with the stability limit if it may exceed the limit. After a step far below the limit, comparisons
    /// pause for a growing number of steps, because they linearize all contacts. The balances detect a mode that grows meanwhile.
    fn compared_with_limit<T: Scalar>(
        &mut self,
        model: &Model<T>,
        kick: &Kick<T>,
        may_exceed: bool,
    ) -> Option<Instability> {
        let Kicked {
            pause, last_pause, ..
        } = self.last;
        (self.next.pause, self.next.last_pause) = (pause.saturating_sub(1), last_pause);
        if !may_exceed || pause > 0 {
            return None;
        }
        let limit = model.limit_without_friction(&kick.states_before());
        let is_far = limit
            .as_ref()
            .is_none_or(|(limit, _)| *limit > FAR * kick.time_step);
        let pause = if is_far {
            LONGEST_PAUSE.min(2 * last_pause + 1)
        } else {
            0
        };
        (self.next.pause, self.next.last_pause) = (pause, pause);
        let (limit, contacts) = limit.filter(|(limit, _)| kick.time_step > *limit)?;
        let stiffest = stiffest(&contacts)?;
        Some(Instability::AboveLimit {
            bodies: stiffest.bodies,
            limit,
        })
    }

    /// Keeps the kick that was checked last.
    pub fn accept(&mut self) {
        mem::swap(&mut self.last, &mut self.next);
    }

    /// Sets the wrenches of all contacts in a kick, and removes contacts that have ended without a net gain.
    fn set_wrenches<T: Scalar>(&mut self, model: &Model<T>, kick: &Kick<T>) {
        let contacts = &mut self.next.contacts;
        contacts.clone_from(&self.last.contacts);
        contacts.retain(|balance| balance.now != ZERO || balance.net_work > 0.0);
        for balance in &mut *contacts {
            balance.last = mem::replace(&mut balance.now, ZERO);
        }
        for (&(a, b), contact) in kick.pairs.iter().zip(kick.contacts) {
            let (bodies, wrenches) = ([a, b], [&contact.on_a, &contact.on_b]);
            if wrenches
                .iter()
                .all(|wrench| wrench.real().to_vector().amax() == 0.0)
            {
                continue;
            }
            let position = contacts.binary_search_by_key(&bodies, |balance| balance.bodies);
            let index = position.unwrap_or_else(|index| {
                contacts.insert(index, Balance::new(bodies));
                index
            });
            let side = |side: usize| {
                kick.body(model, bodies[side])
                    .about_reference(wrenches[side])
            };
            contacts[index].now = [side(0), side(1)];
        }
    }
}

impl Balance {
    fn new(bodies: [usize; 2]) -> Self {
        Self {
            bodies,
            now: ZERO,
            last: ZERO,
            stored: None,
            net_work: 0.0,
            absorbed: 0.0,
        }
    }

    /// Adds the change since the last kick to the changes of both bodies.
    fn add_change(&self, bodies: &[KickedBody; 2], changes: &mut [ContactChange]) {
        let power = |side: usize| {
            let change = self.now[side] - self.last[side];
            change.dot(&bodies[side].before.to_vector())
        };
        let power = power(0) + power(1);
        for (side, &index) in self.bodies.iter().enumerate() {
            let change = &mut changes[index];
            change.now += self.now[side];
            change.last += self.last[side];
            change.power += power;
        }
    }

    fn add_work(
        &mut self,
        bodies: &[KickedBody; 2],
        last_poses: [Option<&Pose>; 2],
        time_step: f64,
    ) {
        for (side, body) in bodies.iter().enumerate() {
            self.net_work += body.work(&self.now[side], last_poses[side], time_step);
        }
        self.absorbed = self.absorbed.max(-self.net_work);
    }

    /// Energy (J) that the forces of one kick give to the bodies from rest. These are all forces except contact, and this contact if it
    /// also acted in the last kick. Friction at rest may reverse velocities of this size in each step, but they do not grow.
    fn allowed(&self, bodies: &[KickedBody; 2], others: &[Vector6<f64>; 2], time_step: f64) -> f64 {
        let energy = |wrenches: &[Vector6<f64>; 2]| {
            let energies = bodies.iter().zip(wrenches);
            energies
                .map(|(body, wrench)| body.energy(wrench, time_step))
                .sum::<f64>()
        };
        energy(others) + energy(&self.now).min(energy(&self.last))
    }

    /// Whether the contact has returned more than twice the energy that it absorbed or stored, and more than an allowed energy (J).
    /// Infinite energy does not count, because a state that is not finite has its own error.
    fn has_created(&self, allowed: f64) -> bool {
        let most = self.absorbed + 2.0 * self.stored.unwrap_or(0.0) + allowed;
        self.net_work > most && self.net_work.is_finite()
    }

    fn gain(&self) -> Instability {
        Instability::EnergyGain {
            bodies: self.bodies,
            absorbed: self.absorbed + self.stored.unwrap_or(0.0),
            returned: self.net_work + self.absorbed,
        }
    }
}
