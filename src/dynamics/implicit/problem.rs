//! One implicit stage: velocities u of an island's bodies for which
//!
//! P(q̃ ⊕ τu, u) = p̃ + τ f(q̃ ⊕ τu, u, t),
//!
//! with poses q̃ and momenta p̃ to start from, a duration τ, and f all wrenches about the centres of mass. Momenta P and
//! not velocities stand in it, so no gyroscopic term is needed, and free bodies keep their momentum.

use super::about_centers::{PairGeometry, block, joined, part};
use super::island::Island;
use super::matrix::BlockMatrix;
use super::pair_model::{PairModel, PairWrenches};
use super::rigid::displacement;
use super::{Scene, Stuck};
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia};
use crate::spatial::{Pose, Twist};
use crate::threads::mapped_into;
use nalgebra::{DVector, Matrix6, Vector6};

/// A stage of an island: see the module.
pub(super) struct Problem<'a> {
    pub scene: &'a Scene<'a>,
    pub island: &'a Island,
    /// Of its dynamic bodies.
    pub inertias: &'a [&'a Inertia],
    /// The poses that the dynamic bodies start from.
    pub poses: Vec<Pose>,
    /// The momenta (N m s, N s) that they start with.
    pub momenta: Vec<Vector6<f64>>,
    /// τ (s).
    pub duration: f64,
    /// The states of the other bodies, at the time at which the wrenches act.
    pub neighbors: Vec<BodyState>,
    /// That time (s).
    pub time: f64,
}

/// All that acts on an island's bodies in a state, and a model of it nearby.
pub(super) struct Evaluation {
    /// The velocities of this state.
    pub velocities: DVector<f64>,
    pub states: Vec<BodyState>,
    pub contacts: Vec<PairModel>,
    /// The wrenches of forces other than contact, and their derivatives.
    forces: Vec<Vector6<f64>>,
    slopes: Vec<ForceSlopes>,
}

/// The wrench on one body by the displacement and the velocities of another.
pub(super) struct ForceSlopes {
    pub row: usize,
    pub column: usize,
    pub by_displacement: Matrix6<f64>,
    pub by_velocities: Matrix6<f64>,
}

impl Problem<'_> {
    /// The states of all participants after the duration with these velocities.
    pub fn states_with(&self, velocities: &DVector<f64>) -> Vec<BodyState> {
        let moved = self.poses.iter().enumerate().map(|(place, pose)| {
            let own = own(velocities, place);
            BodyState {
                pose: self.inertias[place].displaced(pose, &(own * self.duration)),
                twist: Twist::from_vector(&own),
            }
        });
        moved.chain(self.neighbors.iter().copied()).collect()
    }

    /// The contacts as they are with these velocities: the one place where geometry is looked at.
    pub fn evaluation(&self, velocities: DVector<f64>, is_exact: bool) -> Evaluation {
        let states = self.states_with(&velocities);
        let mut sweep = Sweep::default();
        let pairs = self.scene.close_pairs(self.island, &states, &mut sweep);
        let mut models = Vec::new();
        mapped_into(&mut models, pairs, |&(i, j)| {
            let pair = self.scene.pair(self.island, [i, j], &states)?;
            PairModel::of(&pair, [i, j], is_exact)
        });
        let contacts: Vec<_> = models.into_iter().flatten().collect();
        let (mut forces, mut slopes) = (Vec::new(), Vec::new());
        if !self.scene.forces.is_nothing() {
            let here: Vec<_> = contacts.iter().map(PairModel::here).collect();
            forces = self.forces(&states, &here);
            slopes = self.force_slopes(&states, &here);
        }
        Evaluation {
            velocities,
            states,
            contacts,
            forces,
            slopes,
        }
    }

    /// The residual and its matrix in an evaluated state.
    pub fn residual_in(&self, evaluation: &Evaluation) -> (DVector<f64>, BlockMatrix) {
        let contacts: Vec<_> = evaluation.contacts.iter().map(PairModel::here).collect();
        let states = &evaluation.states;
        let matrix = self.matrix(states, &contacts, &evaluation.slopes);
        (self.residual(states, &contacts, &evaluation.forces), matrix)
    }

    /// The residual and its matrix near an evaluated state, contact polygons staying as they are there.
    pub fn residual_near(
        &self,
        evaluation: &Evaluation,
        velocities: &DVector<f64>,
    ) -> (DVector<f64>, BlockMatrix) {
        let states = self.states_with(velocities);
        let change = velocities - &evaluation.velocities;
        let displacement = |place: usize| {
            let [from, to] = [&evaluation.states[place].pose, &states[place].pose];
            displacement(self.inertias[place], from, to)
        };
        let count = self.island.dynamic.len();
        let displacements: Vec<_> = (0..count).map(displacement).collect();
        let near = |contact: &PairModel| {
            let of = |numbers: &dyn Fn(usize) -> Vector6<f64>| {
                joined(
                    contact
                        .bodies
                        .map(|body| (body < count).then(|| numbers(body))),
                )
            };
            let velocities = of(&|body| own(&change, body));
            contact.near(&of(&|body| displacements[body]), &velocities)
        };
        let contacts: Vec<_> = evaluation.contacts.iter().map(near).collect();
        let mut forces = evaluation.forces.clone();
        for slopes in &evaluation.slopes {
            forces[slopes.row] += slopes.by_displacement * displacements[slopes.column]
                + slopes.by_velocities * own(&change, slopes.column);
        }
        let matrix = self.matrix(&states, &contacts, &evaluation.slopes);
        (self.residual(&states, &contacts, &forces), matrix)
    }

    /// P − p̃ − τf.
    fn residual(
        &self,
        states: &[BodyState],
        contacts: &[PairWrenches],
        forces: &[Vector6<f64>],
    ) -> DVector<f64> {
        let count = self.island.dynamic.len();
        let mut residual = DVector::zeros(6 * count);
        for (place, state) in states.iter().take(count).enumerate() {
            let momentum = self.inertias[place].momentum(state);
            let force = forces.get(place).copied().unwrap_or_default() + self.given(place);
            let mut own = residual.fixed_rows_mut::<6>(6 * place);
            own += momentum - self.momenta[place] - force * self.duration;
        }
        for contact in contacts {
            for (side, &body) in contact.bodies.iter().enumerate() {
                if body < count {
                    let mut on = residual.fixed_rows_mut::<6>(6 * body);
                    on -= part(&contact.wrenches, side) * self.duration;
                }
            }
        }
        residual
    }

    /// The derivatives of the residual by the velocities.
    pub fn matrix(
        &self,
        states: &[BodyState],
        contacts: &[PairWrenches],
        forces: &[ForceSlopes],
    ) -> BlockMatrix {
        let count = self.island.dynamic.len();
        let rates: Vec<_> = (0..count)
            .map(|place| self.inertias[place].rates(&states[place], self.duration))
            .collect();
        let mut matrix = BlockMatrix::zeros(count);
        for (place, rates) in rates.iter().enumerate() {
            let by_pose = rates.momentum_by_pose * rates.displacement;
            matrix.add(place, place, &(by_pose + rates.momentum_by_twist));
        }
        let mut add = |row: usize,
                       column: usize,
                       by_displacement: &Matrix6<f64>,
                       by_velocities: &Matrix6<f64>| {
            let slopes = by_displacement * rates[column].displacement + by_velocities;
            matrix.add(row, column, &(slopes * -self.duration));
        };
        for slopes in forces {
            add(
                slopes.row,
                slopes.column,
                &slopes.by_displacement,
                &slopes.by_velocities,
            );
        }
        for contact in contacts {
            for (row, &body) in contact.bodies.iter().enumerate() {
                for (column, &other) in contact.bodies.iter().enumerate() {
                    if body < count && other < count {
                        let slopes = [&contact.by_displacements, &contact.by_velocities];
                        let [by_displacement, by_velocities] =
                            slopes.map(|slopes| block(slopes, row, column));
                        add(body, other, &by_displacement, &by_velocities);
                    }
                }
            }
        }
        matrix
    }

    /// The derivatives with these contacts, all of whose own are exact.
    pub fn exact_matrix(&self, states: &[BodyState], contacts: &[PairWrenches]) -> BlockMatrix {
        let slopes = self.force_slopes(states, contacts);
        self.matrix(states, contacts, &slopes)
    }

    /// How the motions of two participants count in their contact.
    pub fn geometry<'s>(&'s self, bodies: [usize; 2], states: &'s [BodyState]) -> PairGeometry<'s> {
        self.scene.geometry(self.island, bodies, states)
    }

    /// The stage where its matrix is singular.
    pub fn unsolved(&self) -> Stuck {
        Stuck::Unsolved {
            body: self.island.dynamic[0],
            duration: self.duration,
        }
    }

    /// Gravity and controls on a body.
    pub fn given(&self, place: usize) -> Vector6<f64> {
        self.scene.given[self.island.dynamic[place]]
    }

    /// The speed (m/s) of velocities of all bodies.
    pub fn speed(&self, velocities: &DVector<f64>) -> f64 {
        let speeds = (0..self.island.dynamic.len())
            .map(|place| self.inertias[place].speed(&own(velocities, place)));
        speeds.map(|speed| speed * speed).sum::<f64>().sqrt()
    }

    /// The body with the largest speed of such velocities.
    pub fn fastest(&self, velocities: &DVector<f64>) -> usize {
        let speed = |place: &usize| self.inertias[*place].speed(&own(velocities, *place));
        let places = 0..self.island.dynamic.len();
        let fastest = places.max_by(|one, other| speed(one).total_cmp(&speed(other)));
        self.island.dynamic[fastest.unwrap_or_default()]
    }
}

impl Evaluation {
    fn force(&self, place: usize) -> Vector6<f64> {
        self.forces.get(place).copied().unwrap_or_default()
    }

    /// The wrenches of all but gravity and controls on a dynamic body.
    pub fn acting(&self, place: usize) -> Vector6<f64> {
        let mut sum = self.force(place);
        for contact in &self.contacts {
            for (side, &body) in contact.bodies.iter().enumerate() {
                if body == place {
                    sum += part(&contact.wrenches, side);
                }
            }
        }
        sum
    }
}

/// One body's numbers of a vector of all.
pub(super) fn own(vector: &DVector<f64>, place: usize) -> Vector6<f64> {
    vector.fixed_rows::<6>(6 * place).into_owned()
}

/// The vector of all bodies' numbers.
pub(super) fn joined_all(parts: impl Iterator<Item = Vector6<f64>>) -> DVector<f64> {
    let mut numbers = Vec::new();
    for part in parts {
        numbers.extend_from_slice(part.as_slice());
    }
    DVector::from_vec(numbers)
}
