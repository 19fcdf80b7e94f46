//! Energy that an explicit step makes out of nothing: a body that moves far into another within a step is thrown out of it.

use crate::dynamics::State;
use crate::dynamics::system::System;
use crate::scalar::{Scalar, real_part};
use crate::spatial::Wrench;
use nalgebra::Vector6;

/// A step may give this many times the energy that there was. A stable step swings the energy of an undamped mode by
/// 1/(1 − h²k/4) at most, which is 10 where h²k is 3.6 of at most 4.
const MOST_GAIN: f64 = 10.0;

/// Energies are evaluated only where a step multiplies the kinetic energy by this: they cost more than the step.
const FASTER: f64 = 2.0;

impl<T: Scalar> System<T> {
    /// The energy (J) that there was before a step, and that after it, if contact made most of the latter out of nothing. The
    /// wrenches on each body acted in the step for a time (s): those of contact, and all. None where a body on a path is touched:
    /// its work is not known, because nothing holds the twist of a path to its poses.
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
            let way = (twists[0] + twists[1]) * (time_step / 2.0);
            let [contact, all] = [contact, all].map(|wrenches| wrenches[index].real().to_vector());
            let Some(inertia) = body.inertia() else {
                if body.motion.is_prescribed() && contact != Vector6::zeros() {
                    return None;
                }
                continue;
            };
            let weight = self.gravity.map(real_part) * real_part(inertia.mass);
            work += (all - contact).dot(&way) + weight.dot(&way.fixed_rows::<3>(3));
        }
        let had = energy(before) + work.abs();
        let has = energy(after);
        (has > (1.0 + MOST_GAIN) * had).then_some([had, has])
    }
}
