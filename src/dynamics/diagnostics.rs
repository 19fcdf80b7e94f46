use super::model::Model;
use super::sweep::Sweep;
use super::{
    BodyShape, BodyState, Force, Inertia, JointState, RolloutError, State, World, WorldError,
};
use crate::scalar::{Scalar, lift, lift_vector};
use nalgebra::Vector3;

/// Energies and momentum of a state. Only dynamic bodies have kinetic energy, gravitational energy and momentum.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Diagnostics<T = f64> {
    /// Kinetic energy (J): ½ m v² + ½ ω·I·ω of bodies, and ½ A u² of the armatures of joints.
    pub kinetic_energy: T,
    /// Gravitational energy (J): −m g·x, with the center of mass x relative to the origin of the world.
    pub gravitational_energy: T,
    /// Potential energy (J) of all contacts.
    pub contact_energy: T,
    /// Linear and angular momentum.
    pub momentum: Momentum<T>,
}

/// Linear and angular momentum of all dynamic bodies.
#[derive(Debug, Clone, Copy)]
pub struct Momentum<T = f64> {
    /// Linear momentum (kg m/s).
    pub linear: Vector3<T>,
    /// Angular momentum (kg m²/s) about the origin of the world.
    pub angular: Vector3<T>,
}

/// Set of touching tetrahedron pairs in a state. If it changes between two states, a derivative may be one-sided.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(from = "Vec<[usize; 4]>", into = "Vec<[usize; 4]>")
)]
pub struct ContactTopology {
    /// Bodies A and B, tetrahedron of A, tetrahedron or triangle of B. The list is sorted.
    touching: Vec<[usize; 4]>,
}

impl ContactTopology {
    /// Number of contact polygons.
    #[must_use]
    pub fn polygon_count(&self) -> usize {
        self.touching.len()
    }

    /// Whether two bodies touch. The arguments are indices of bodies in the world.
    #[must_use]
    pub fn touches(&self, first: usize, second: usize) -> bool {
        let is_theirs =
            |pair: &[usize; 4]| pair[..2] == [first, second] || pair[..2] == [second, first];
        self.touching.iter().any(is_theirs)
    }

    /// Number of tetrahedron pairs that touch in exactly one of the two states.
    #[must_use]
    pub fn changes_since(&self, before: &Self) -> usize {
        let missing = |from: &Self, in_other: &Self| {
            let is_missing = |pair: &&[usize; 4]| in_other.touching.binary_search(pair).is_err();
            from.touching.iter().filter(is_missing).count()
        };
        missing(self, before) + missing(before, self)
    }
}

#[cfg(feature = "serde")]
impl From<Vec<[usize; 4]>> for ContactTopology {
    fn from(mut touching: Vec<[usize; 4]>) -> Self {
        touching.sort_unstable();
        touching.dedup();
        Self { touching }
    }
}

#[cfg(feature = "serde")]
impl From<ContactTopology> for Vec<[usize; 4]> {
    fn from(topology: ContactTopology) -> Self {
        topology.touching
    }
}

impl<T: Scalar> Diagnostics<T> {
    /// Sum of kinetic, gravitational and contact energy (J). It does not include energy that is stored in other forces.
    #[must_use]
    pub fn total_energy(&self) -> T {
        self.kinetic_energy + self.gravitational_energy + self.contact_energy
    }
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Energies and momentum of a state.
    ///
    /// # Errors
    /// If the state has another number of bodies than the world, a pose that is not rigid, or a
    /// number that is not finite.
    pub fn diagnostics(&self, state: &State<T>) -> Result<Diagnostics<T>, WorldError> {
        state.check_fits(self.bodies())?;
        Ok(self.model.diagnostics(state))
    }

    /// Pairs of bodies, A and B, that have passed so far into each other that contact may no longer push them apart: see
    /// [`ContactPair::has_sunk_through`](crate::contact::ContactPair::has_sunk_through). Bodies are given by their indices.
    ///
    /// # Errors
    /// If the state has another number of bodies than the world, a pose that is not rigid, or a
    /// number that is not finite.
    pub fn fully_submerged(&self, state: &State<T>) -> Result<Vec<[usize; 2]>, WorldError> {
        state.check_fits(self.bodies())?;
        Ok(self.model.fully_submerged(state))
    }

    /// Touching tetrahedron pairs in a state.
    ///
    /// # Errors
    /// If the state has another number of bodies than the world, a pose that is not rigid, or a
    /// number that is not finite.
    pub fn topology(&self, state: &State<T>) -> Result<ContactTopology, WorldError> {
        state.check_fits(self.bodies())?;
        Ok(self.model.topology(state))
    }
}

impl<T: Scalar> Model<T> {
    /// Energies and momentum of a state that fits the bodies.
    fn diagnostics(&self, state: &State<T>) -> Diagnostics<T> {
        let zero = lift_vector(&Vector3::zeros());
        let mut diagnostics = Diagnostics {
            kinetic_energy: self.kinetic_energy(state),
            gravitational_energy: lift(0.0),
            contact_energy: self.contact_energy(state),
            momentum: Momentum {
                linear: zero,
                angular: zero,
            },
        };
        for (body, body_state) in self.bodies.iter().zip(&state.bodies) {
            let Some(inertia) = body.inertia() else {
                continue;
            };
            let (pose, twist) = (&body_state.pose, &body_state.twist);
            let center = pose.translation() + pose.rotated_constant(&inertia.center_of_mass);
            let linear = twist.linear * inertia.mass;
            let spin = inertia.angular_momentum(pose.rotation(), &twist.angular);
            diagnostics.gravitational_energy -= self.gravity.dot(&center) * inertia.mass;
            diagnostics.momentum.linear += linear;
            diagnostics.momentum.angular += spin + center.cross(&linear);
        }
        diagnostics
    }

    /// Kinetic energy (J) of all dynamic bodies and of the armatures of joints.
    pub(super) fn kinetic_energy(&self, state: &State<T>) -> T {
        let bodies = self.bodies.iter().enumerate();
        let of_rotors = bodies.filter_map(|(index, body)| {
            let (joint, multiplier) = self.state_of_joint(index)?;
            let squared = match &state.joints[joint] {
                JointState::Scalar { velocity, .. } => *velocity * *velocity,
                JointState::Ball {
                    angular_velocity, ..
                } => angular_velocity.dot(angular_velocity),
            };
            let armature = body.joint()?.law.armature;
            Some(squared * armature * (0.5 * multiplier * multiplier))
        });
        let of_rotors = of_rotors.fold(lift(0.0), |sum: T, energy| sum + energy);
        let bodies = self.bodies.iter().zip(&state.bodies);
        bodies.fold(of_rotors, |sum, (body, state)| {
            let of_body =
                |inertia: &Inertia<T>| inertia.momentum(state).dot(&state.twist.to_vector()) * 0.5;
            sum + body.inertia().map_or(lift(0.0), of_body)
        })
    }

    /// Potential energy (J) of all contacts.
    pub(super) fn contact_energy(&self, state: &State<T>) -> T {
        let mut sweep = Sweep::default();
        let pairs = self.close_pairs(&state.bodies, &mut sweep).iter();
        pairs.fold(lift(0.0), |sum, &(i, j)| {
            let pair = self.pair_of([i, j], [&state.bodies[i], &state.bodies[j]]);
            sum + pair.map_or(lift(0.0), |pair| pair.potential_energy())
        })
    }

    /// Pairs of bodies of which one is wholly inside the other, in a state that fits the bodies.
    fn fully_submerged(&self, state: &State<T>) -> Vec<[usize; 2]> {
        let mut sweep = Sweep::default();
        let pairs = self.close_pairs(&state.bodies, &mut sweep).iter();
        let submerged = pairs.filter(|&&(i, j)| {
            let pair = self.pair_of([i, j], [&state.bodies[i], &state.bodies[j]]);
            pair.is_some_and(|pair| pair.has_sunk_through())
        });
        submerged.map(|&(i, j)| [i, j]).collect()
    }

    /// Returns an error if a dynamic body is wholly below the surface of a half-space without a contact that would push it out.
    pub(super) fn below_half_space(&self, states: &[BodyState<T>]) -> Option<RolloutError> {
        let is_half_space =
            |index: &usize| matches!(self.bodies[*index].shape, BodyShape::HalfSpace(_));
        let names = |indices: [usize; 2]| indices.map(|index| self.bodies[index].name().to_owned());
        for half_space in (0..states.len()).filter(is_half_space) {
            let from_world = states[half_space].pose.real().inverse();
            for body in self.dynamic_bodies() {
                let pose = from_world * states[body].pose.real();
                let order = self.ordered_pair(body.min(half_space), body.max(half_space));
                let Some((a, b)) = order else {
                    continue;
                };
                let is_below = self.bodies[body].shape.bounds_at(&pose).upper.z < 0.0;
                let contact = self.pair_of([a, b], [&states[a], &states[b]]);
                if is_below && contact.is_none_or(|pair| pair.touching_tets().is_empty()) {
                    let bodies = names([body, half_space]);
                    return Some(RolloutError::StartsBelow { bodies });
                }
            }
        }
        None
    }

    /// Touching tetrahedron pairs in a state that fits the bodies.
    fn topology(&self, state: &State<T>) -> ContactTopology {
        let mut touching = Vec::new();
        for &(i, j) in self.close_pairs(&state.bodies, &mut Sweep::default()) {
            let pair = self.pair_of([i, j], [&state.bodies[i], &state.bodies[j]]);
            let tets = pair.map_or_else(Vec::new, |pair| pair.touching_tets());
            touching.extend(tets.into_iter().map(|[a, b]| [i, j, a, b]));
        }
        touching.sort_unstable();
        ContactTopology { touching }
    }
}
