//! Derivatives of the motion of an island along a direction, or along the motion itself.

use super::island_step::IslandStep;
use crate::dynamics::joint::JointPosition;
use crate::dynamics::multibody::{Coordinates, Kinematics, Multibody};
use crate::dynamics::rigid_motion::six;
use crate::dynamics::{BodyState, Inertia};
use crate::scalar::{DenseDual, lift};
use crate::spatial::{Pose, Twist, turn_from_real, turned_real};
use nalgebra::{DVector, Vector3, Vector6};

/// Number with one derivative.
pub(super) type Change = DenseDual<1>;

/// Bodies of an island and applied wrenches as numbers with one derivative.
pub(super) struct ChangedBodies {
    pub multibody: Multibody<Change>,
    /// Weight and control of each body of the world.
    pub applied: Vec<Vector6<Change>>,
}

/// Rates along the motion at the start of a substep.
pub(super) struct StartRates {
    pub bodies: ChangedBodies,
    /// Displacement and velocities of the neighbors, per second.
    pub neighbors: Vec<BodyChange>,
    /// Rates of the generalized velocities.
    pub accelerations: DVector<f64>,
}

/// Time derivatives of quantities that the states of the dynamic bodies do not determine.
pub(super) struct RatesInTime {
    /// Displacement and velocities of the neighbors, per second.
    pub neighbors: Vec<BodyChange>,
    /// Forces other than contact on the dynamic bodies, per second.
    pub forces: Vec<Vector6<f64>>,
    /// Joint forces, per second.
    pub joint_forces: DVector<f64>,
}

/// Half the step of central differences in time, as a fraction of the duration of a stage.
pub(super) const SHORT: f64 = 1e-3;

/// Displacement of a body and change of its velocities, or the rates of both. They refer to the center of mass, or to the origin of a body
/// without mass.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyChange {
    pub displacement: Vector6<f64>,
    pub velocities: Vector6<f64>,
}

impl RatesInTime {
    /// Zero rates.
    pub fn zero(multibody: &Multibody) -> Self {
        let zero = BodyChange {
            displacement: Vector6::zeros(),
            velocities: Vector6::zeros(),
        };
        Self {
            neighbors: vec![zero; multibody.neighbors.len()],
            forces: vec![Vector6::zeros(); multibody.links.len()],
            joint_forces: DVector::zeros(multibody.width()),
        }
    }
}

impl IslandStep<'_> {
    /// Displacement and velocities of the neighbors, per second, at a time (s). Accelerations are central differences over a small part of
    /// a duration (s).
    pub(super) fn neighbor_rates(&self, time: f64, duration: f64) -> Vec<BodyChange> {
        let short = SHORT * duration;
        let twists = |time: f64| {
            let states = self.context.neighbors_at(self.island, time).into_iter();
            states
                .map(|state| state.twist.to_vector())
                .collect::<Vec<_>>()
        };
        let [early, now, late] = [time - short, time, time + short].map(twists);
        let changes = early.iter().zip(&late).map(|(early, late)| late - early);
        let rates = now.into_iter().zip(changes);
        rates
            .map(|(displacement, change)| BodyChange {
                displacement,
                velocities: change / (2.0 * short),
            })
            .collect()
    }
}

impl ChangedBodies {
    /// Bodies of an island in a step, with zero derivatives.
    pub fn new(step: &IslandStep) -> Self {
        let applied = step.context.applied.iter();
        Self {
            multibody: step.multibody.lifted(),
            applied: applied.map(|six| six.map(lift)).collect(),
        }
    }

    /// Derivative parts of the states of the dynamic bodies.
    pub fn changes<'k>(
        &'k self,
        kinematics: &'k Kinematics<Change>,
    ) -> impl Iterator<Item = BodyChange> + 'k {
        let links = self.multibody.links.iter().zip(&kinematics.states);
        links.map(|(link, state)| BodyChange::carried_by(&link.inertia, state))
    }

    /// Rates of the generalized velocities, from the rates of the momenta and the rates of the neighbors.
    pub fn accelerations(
        &self,
        step: &IslandStep,
        kinematics: &Kinematics,
        momentum_rates: &DVector<f64>,
        neighbors: &[BodyChange],
    ) -> DVector<f64> {
        let still = DVector::zeros(momentum_rates.len());
        let moved = self.along(kinematics, &still, neighbors);
        let transported = self
            .multibody
            .generalized_momenta(&moved)
            .map(|number| number.eps[0]);
        let masses = step.multibody.mass_factors(kinematics);
        let mut accelerations = masses.velocities(momentum_rates - transported);
        if step.multibody.constraint_count() > 0 {
            let rates = self.multibody.loop_rates(&moved).map(|rate| rate.eps[0]);
            // The rates of a loop that closes decay, as the values of its constraints do.
            let loop_rates = step.multibody.loop_rates(kinematics);
            let drift = rates + step.loop_product(|loops| &loops.closing, &loop_rates);
            step.multibody.add_loop_accelerations(
                &mut accelerations,
                (kinematics, &masses),
                step.loop_regularizations(),
                &drift,
            );
        }
        accelerations
    }

    /// Kinematics with the derivatives along the motion, from the rates of the generalized velocities.
    pub fn along(
        &self,
        kinematics: &Kinematics,
        accelerations: &DVector<f64>,
        neighbors: &[BodyChange],
    ) -> Kinematics<Change> {
        let count = self.multibody.links.len();
        let states = kinematics.states[count..].iter().zip(neighbors);
        let states: Vec<_> = states
            .map(|(state, rates)| rates.applied_to(state))
            .collect();
        let Coordinates {
            positions,
            velocities,
            multipliers,
        } = &kinematics.coordinates;
        let positions: Vec<_> = positions.iter().map(JointPosition::lifted).collect();
        let displacement = velocities.map(|velocity| Change::new(0.0, [velocity]));
        let coordinates = Coordinates {
            positions: self.multibody.displaced(&positions, &displacement),
            velocities: velocities.zip_map(accelerations, |value, rate| Change::new(value, [rate])),
            multipliers: multipliers.map(lift),
        };
        self.multibody.kinematics(coordinates, &states)
    }
}

impl BodyChange {
    /// Derivative part of a state.
    pub fn carried_by(inertia: &Inertia<Change>, state: &BodyState<Change>) -> Self {
        let change = |number: Change| number.eps[0];
        let turn = turn_from_real(state.pose.rotation());
        let center = state.pose.transformed_constant(&inertia.center_of_mass);
        Self {
            displacement: six(&turn, &center).map(change),
            velocities: state.twist.to_vector().map(change),
        }
    }

    /// State with this derivative part, for a body without mass.
    pub fn applied_to(&self, state: &BodyState) -> BodyState<Change> {
        let change = |number: f64| Change::new(0.0, [number]);
        let Twist { angular, linear } = Twist::from_vector(&self.displacement.map(change));
        let Twist {
            angular: spin,
            linear: velocity,
        } = Twist::from_vector(&self.velocities.map(change));
        let with =
            |vector: &Vector3<f64>, change: Vector3<Change>| vector.map(lift::<Change>) + change;
        BodyState {
            pose: Pose::from_parts(
                turned_real(state.pose.rotation(), &angular),
                with(state.pose.translation(), linear),
            ),
            twist: Twist {
                angular: with(&state.twist.angular, spin),
                linear: with(&state.twist.linear, velocity),
            },
        }
    }
}
