//! Forces other than contact, backwards: by dual numbers of the width of a body's state.

use super::contact::WrenchCovector;
use super::{Reversal, StateCovector};
use crate::dynamics::any_world::Seeded;
use crate::dynamics::system::System;
use crate::dynamics::{BodyState, Motion};
use crate::spatial::{Twist, Wrench};
use nalgebra::{SVector, Vector3, Vector6};

/// What forces are differentiated in: the world, its numbers constants unless they are seeded.
pub(super) struct SeededForces {
    system: System<Seeded>,
    /// The bodies whose states forces depend on.
    coupled: Vec<usize>,
}

fn seeds<const COUNT: usize>(first: usize) -> SVector<Seeded, COUNT> {
    SVector::from_fn(|i, _| Seeded::variable(0.0, first + i))
}

impl SeededForces {
    /// None if the world has no forces.
    pub fn of(world: &dyn crate::dynamics::AnyWorld<f64>) -> Option<Self> {
        let (forces, system) = (world.real_forces(), world.system());
        if forces.is_nothing() {
            return None;
        }
        let mut coupled = forces.coupled(&system.bodies).concat();
        coupled.sort_unstable();
        coupled.dedup();
        Some(Self {
            system: system.lifted(),
            coupled,
        })
    }
}

/// Where forces act: the time (s), the states, and what contact does there.
pub(super) type Here<'a> = (f64, &'a [BodyState], &'a [Wrench]);

impl Reversal<'_> {
    /// Adds what follows from the derivatives by the wrenches of forces about the centres of mass: to those by the net wrenches
    /// of contact, which the forces see, too.
    pub(super) fn pull_back_forces(
        &mut self,
        here: Here,
        by_wrenches: &[WrenchCovector],
        by_contact: &mut [WrenchCovector],
    ) {
        let Some(mut forces) = self.forces.take() else {
            return;
        };
        for place in 0..forces.coupled.len() {
            let body = forces.coupled[place];
            let by_state = self.by_state(&forces.system, body, here, by_wrenches);
            self.states[body].add(&StateCovector::from_vector(&by_state));
        }
        for (body, by_contact) in by_contact.iter_mut().enumerate() {
            let by_numbers = self.by_numbers(&mut forces.system, body, here, by_wrenches);
            *by_contact += Wrench::from_vector(&by_numbers.fixed_rows::<6>(0).into_owned());
            let own = &mut self.gradient.bodies[body];
            own.mass += by_numbers[6];
            own.modulus += by_numbers[7];
            own.dissipation += by_numbers[8];
            own.friction += by_numbers[9];
        }
        let constant = forces.system.gravity;
        forces.system.gravity += seeds::<3>(0);
        let (states, contact) = lifted(here);
        let by_gravity = self.pulled_back(&forces.system, (here.0, &states, &contact), by_wrenches);
        self.gradient.gravity += by_gravity.fixed_rows::<3>(0);
        forces.system.gravity = constant;
        self.forces = Some(forces);
    }

    /// By the state of a body.
    fn by_state(
        &self,
        system: &System<Seeded>,
        body: usize,
        here: Here,
        by_wrenches: &[WrenchCovector],
    ) -> SVector<f64, 12> {
        let (mut states, contact) = lifted(here);
        let state = &mut states[body];
        state.pose = state.pose.moved_by(&Twist::from_vector(&seeds::<6>(0)));
        state.twist = Twist::from_vector(&(state.twist.to_vector() + seeds::<6>(6)));
        self.pulled_back(system, (here.0, &states, &contact), by_wrenches)
    }

    /// By the wrench of contact on a body (6 numbers), its mass, modulus, dissipation and friction.
    fn by_numbers(
        &self,
        system: &mut System<Seeded>,
        body: usize,
        here: Here,
        by_wrenches: &[WrenchCovector],
    ) -> SVector<f64, 12> {
        let (states, mut contact) = lifted(here);
        contact[body] = Wrench::from_vector(&(contact[body].to_vector() + seeds::<6>(0)));
        let constant = system.bodies[body].clone();
        let seeded = &mut system.bodies[body];
        if let Motion::Dynamic(inertia) = &mut seeded.motion {
            inertia.mass += Seeded::variable(0.0, 6);
        }
        if let Some(modulus) = &mut seeded.material.modulus {
            *modulus += Seeded::variable(0.0, 7);
        }
        seeded.material.dissipation += Seeded::variable(0.0, 8);
        seeded.material.friction += Seeded::variable(0.0, 9);
        let found = self.pulled_back(system, (here.0, &states, &contact), by_wrenches);
        system.bodies[body] = constant;
        found
    }

    /// By what is seeded.
    fn pulled_back(
        &self,
        system: &System<Seeded>,
        here: (f64, &[BodyState<Seeded>], &[Wrench<Seeded>]),
        by_wrenches: &[WrenchCovector],
    ) -> SVector<f64, 12> {
        let mut sums = vec![Wrench::zero(); by_wrenches.len()];
        system.with_forces(here, &mut sums, |wrenches, now| {
            self.world.real_forces().add_seeded(wrenches, now);
        });
        let mut found = SVector::zeros();
        for (by_wrench, wrench) in by_wrenches.iter().zip(&sums) {
            let numbers: Vector6<Seeded> = wrench.to_vector();
            for (factor, number) in by_wrench.to_vector().iter().zip(&numbers) {
                // Where nothing depends on a wrench, its derivatives need not be there.
                if *factor != 0.0 {
                    found += SVector::from(number.eps) * *factor;
                }
            }
        }
        found
    }
}

fn lifted((_, states, contact): Here) -> (Vec<BodyState<Seeded>>, Vec<Wrench<Seeded>>) {
    let constant = |vector: &Vector3<f64>| vector.map(crate::scalar::lift::<Seeded>);
    let wrench = |wrench: &Wrench| Wrench {
        torque: constant(&wrench.torque),
        force: constant(&wrench.force),
    };
    let states = states.iter().map(BodyState::lifted).collect();
    (states, contact.iter().map(wrench).collect())
}
