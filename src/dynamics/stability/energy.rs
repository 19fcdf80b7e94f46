//! Detection of explicit steps in which contact creates energy. If a body moves far into another within one step, contact throws it
//! out faster than it came.

use crate::dynamics::State;
use crate::dynamics::system::System;
use crate::scalar::{Scalar, real_part};
use crate::spatial::Wrench;
use nalgebra::Vector6;

/// A step may add at most this many times the energy before it. A stable step changes the energy of an undamped mode by a factor of
/// at most 1/(1 − h²k/4), which is 10 at h²k = 3.6. The stability limit is h²k = 4.
const MOST_GAIN: f64 = 10.0;

/// Energies are evaluated only if a step multiplies the kinetic energy by more than this, because they cost more than the step.
const FASTER: f64 = 2.0;

impl<T: Scalar> System<T> {
    /// Returns the energies (J) before and after a step if contact created most of the energy after it. The arguments are the
    /// states before and after the step, the contact wrench and the total wrench on each body, and the duration (s).
    ///
    /// Returns `None` if a body on a path is touched. The work of such a body is unknown, because the twist of a path need not agree
    /// with its poses.
    pub(in crate::dynamics) fn energy_gained(
        &self,
        [before, after]: [&State<T>; 2],
        [contact, all]: [&[Wrench<T>]; 2],
        time_step: f64,
    ) -> Option<[f64; 2]> {
        let kinetic = |state| real_part(self.kinetic_energy(state));
        if kinetic(after) <= FASTER * kinetic(before) {
            return None;
        }
        let energy = |state| kinetic(state) + real_part(self.contact_energy(state));
        let mut work = 0.0;
        for (index, body) in self.bodies.iter().enumerate() {
            let twists = [before, after].map(|state| state.bodies[index].real().twist.to_vector());
            let displacement = (twists[0] + twists[1]) * (time_step / 2.0);
            let [contact, all] = [contact, all].map(|wrenches| wrenches[index].real().to_vector());
            let Some(inertia) = body.inertia() else {
                if body.motion.is_prescribed() && contact != Vector6::zeros() {
                    return None;
                }
                continue;
            };
            let weight = self.gravity.map(real_part) * real_part(inertia.mass);
            work +=
                (all - contact).dot(&displacement) + weight.dot(&displacement.fixed_rows::<3>(3));
        }
        let energy_before = energy(before) + work.abs();
        let energy_after = energy(after);
        (energy_after > (1.0 + MOST_GAIN) * energy_before).then_some([energy_before, energy_after])
    }
}
