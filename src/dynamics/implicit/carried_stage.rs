//! One stage of an island, in a scalar that carries derivatives.

use super::carried::Carrier;
use super::problem::{Problem, own};
use super::rigid::none;
use super::scheme::Stage;
use super::{PairWrenches, Stuck};
use crate::contact::{ContactWrench, LinearisedContact};
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia};
use crate::scalar::{Scalar, change, lift};
use crate::spatial::{Pose, Twist, Wrench};
use crate::threads::mapped_into;
use nalgebra::{DMatrix, DVector, Vector6};

/// The contact of two participants.
type Linearised = ([usize; 2], LinearisedContact);

/// A stage in the scalar.
pub(super) struct Carried<'a, T> {
    pub of: &'a Carrier<'a, T>,
    pub inertias: Vec<&'a Inertia<T>>,
    pub poses: Vec<Pose<T>>,
    pub momenta: Vec<Vector6<T>>,
    pub duration: f64,
    pub time: f64,
}

impl<T: Scalar> Carried<'_, T> {
    /// The velocities with their derivatives, from the real ones. Leaves the states that they lead to.
    pub fn solved(
        &self,
        root: &DVector<f64>,
        states: &mut [BodyState<T>],
    ) -> Result<Vec<Vector6<T>>, Stuck> {
        let Carrier { scene, island, .. } = self.of;
        let neighbors = scene.neighbors_at(island, self.time);
        for (&body, state) in island.neighbors.iter().zip(&neighbors) {
            // A path carries no derivatives; the pose of a fixed body may.
            if scene.system.bodies[body].motion.is_prescribed() {
                states[body] = state.lifted();
            }
        }
        let inertias = scene.inertias(island);
        let real = Problem {
            scene,
            island,
            inertias: &inertias,
            poses: self.poses.iter().map(Pose::real).collect(),
            momenta: Vec::new(),
            duration: self.duration,
            neighbors,
            time: self.time,
        };
        let count = island.dynamic.len();
        let mut velocities: Vec<Vector6<T>> =
            (0..count).map(|place| own(root, place).map(lift)).collect();
        let mut inverse: Option<DMatrix<f64>> = None;
        for _ in 0..T::NDERIV {
            self.place(&velocities, states);
            let (residual, contacts) = self.residual(states, inverse.is_none());
            let inverse = match inverse.take() {
                Some(known) => inverse.insert(known),
                None => inverse.insert(self.inverse(&real, root, &contacts)?),
            };
            correct(&mut velocities, inverse, &residual);
        }
        self.place(&velocities, states);
        Ok(velocities)
    }

    /// Puts the bodies where velocities take them.
    fn place(&self, velocities: &[Vector6<T>], states: &mut [BodyState<T>]) {
        let bodies = self.of.island.dynamic.iter().enumerate();
        for (place, &body) in bodies {
            let displacement = velocities[place].map(|number| number * self.duration);
            states[body] = BodyState {
                pose: self.inertias[place].displaced(&self.poses[place], &displacement),
                twist: Twist::from_vector(&velocities[place]),
            };
        }
    }

    /// The residual in placed states; and the contacts, linearised, if they are asked for.
    fn residual(
        &self,
        states: &[BodyState<T>],
        wants_contacts: bool,
    ) -> (Vec<Vector6<T>>, Vec<Linearised>) {
        let (acting, contacts) = self.acting(states, wants_contacts);
        let bodies = self.of.island.dynamic.iter().enumerate();
        let residual = bodies.map(|(place, &body)| {
            let momentum = self.inertias[place].momentum(&states[body]);
            let force = self.of.given[body] + acting[body].to_vector();
            momentum - self.momenta[place] - force.map(|number| number * self.duration)
        });
        (residual.collect(), contacts)
    }

    /// The wrenches of contacts and forces on all bodies.
    fn acting(
        &self,
        states: &[BodyState<T>],
        wants_contacts: bool,
    ) -> (Vec<Wrench<T>>, Vec<Linearised>) {
        let Carrier {
            world,
            scene,
            island,
            ..
        } = self.of;
        let system = world.system();
        let real: Vec<_> = (0..island.len())
            .map(|i| states[island.body(i)].real())
            .collect();
        let mut sweep = Sweep::default();
        let pairs = scene.close_pairs(island, &real, &mut sweep);
        let mut found = Vec::new();
        mapped_into(&mut found, pairs, |&(i, j)| {
            let pair = [i, j];
            let [a, b] = pair.map(|participant| island.body(participant));
            if !wants_contacts {
                return Some((pair, system.pair_wrench(states, a, b), None));
            }
            let touching = system.pair_of([a, b], [&states[a], &states[b]])?;
            let moving = system.motion_of([a, b], [&states[a], &states[b]]);
            let moving = moving.as_ref().map(|(law, twists)| (law, *twists));
            let (wrench, linearised) = touching.wrench_and_linearised(moving);
            Some((pair, wrench, Some(linearised)))
        });
        let mut contact = vec![Wrench::zero(); states.len()];
        let mut contacts = Vec::new();
        for (pair, ContactWrench { on_a, on_b }, linearised) in found.into_iter().flatten() {
            for (participant, wrench) in pair.into_iter().zip([on_a, on_b]) {
                let body = island.body(participant);
                let inertia = system.bodies[body].inertia();
                contact[body] += inertia.map_or(wrench, |inertia| {
                    let arm = states[body].pose.rotated_constant(&inertia.center_of_mass);
                    wrench.about(&arm)
                });
            }
            contacts.extend(linearised.map(|linearised| (pair, linearised)));
        }
        let mut all = contact.clone();
        let here = (self.time, states, &*contact);
        system.with_forces(here, &mut all, |wrenches, now| {
            world.add_forces(wrenches, now);
        });
        (all, contacts)
    }

    /// J⁻¹ at the root.
    fn inverse(
        &self,
        real: &Problem,
        root: &DVector<f64>,
        contacts: &[Linearised],
    ) -> Result<DMatrix<f64>, Stuck> {
        let states = real.states_with(root);
        let pairs = contacts.iter().map(|(bodies, contact)| {
            PairWrenches::of(&real.geometry(*bodies, &states), *bodies, contact)
        });
        let matrix = real.exact_matrix(&states, &pairs.collect::<Vec<_>>());
        let factors = matrix.factorised(self.of.scene.patterns);
        factors.inverse().ok_or_else(|| real.unsolved())
    }

    /// What later stages are made of.
    pub fn rates(
        &self,
        velocities: Vec<Vector6<T>>,
        states: &[BodyState<T>],
        stage: Stage,
    ) -> [Vec<Vector6<T>>; 2] {
        let bodies = self.of.island.dynamic.iter().enumerate();
        let forces = bodies.map(|(place, &body)| {
            let gained = self.inertias[place].momentum(&states[body]) - self.momenta[place];
            gained.map(|number| number * stage.duration.recip())
        });
        let forces = forces.collect();
        [velocities, forces]
    }
}

/// u − J⁻¹·(r − re r).
fn correct<T: Scalar>(
    velocities: &mut [Vector6<T>],
    inverse: &DMatrix<f64>,
    residual: &[Vector6<T>],
) {
    let changes: Vec<T> = residual
        .iter()
        .flat_map(|six| six.iter().map(|&number| change(number)).collect::<Vec<_>>())
        .collect();
    for (place, own) in velocities.iter_mut().enumerate() {
        let mut step: Vector6<T> = none();
        for (column, number) in changes.iter().enumerate() {
            for row in 0..6 {
                step[row] += *number * inverse[(6 * place + row, column)];
            }
        }
        *own -= step;
    }
}
