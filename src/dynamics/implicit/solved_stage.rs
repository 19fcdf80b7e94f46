//! Solved stage and its first-order response to a change of its start.

use super::island_step::IslandStep;
use super::newton::Root;
use super::rigid::six;
use super::stage::{StageEquations, StageStart, concatenated, six_of};
use crate::dynamics::{BodyState, Inertia};
use crate::scalar::{DenseDual, lift};
use crate::spatial::{Twist, turn_from_real};
use nalgebra::{Vector3, Vector6};

/// Number with one derivative.
pub(super) type Change = DenseDual<1>;

/// Inertias and applied wrenches of an island as numbers with one derivative.
pub(super) struct ChangedBodies {
    pub inertias: Vec<Inertia<Change>>,
    /// Weight and control of each body of the world.
    pub applied: Vec<Vector6<Change>>,
}

/// Time derivatives along the motion that the states of the dynamic bodies do not determine.
pub(super) struct RatesInTime {
    /// Rate of change (per second) of the displacement and the velocities of the neighbors.
    pub neighbors: Vec<[Vector6<f64>; 2]>,
    /// Rate of change (per second) of the forces other than contact on the dynamic bodies.
    pub forces: Vec<Vector6<f64>>,
}

/// Half the step of central differences in time, as a fraction of the duration of a stage.
const SHORT: f64 = 1e-3;

/// Changes, or rates, of the displacement of a body about its center of mass and of its velocities.
pub(super) struct BodyChange {
    pub displacement: Vector6<f64>,
    pub velocities: Vector6<f64>,
}

/// Stage with its solution.
pub(super) struct SolvedStage<'a> {
    pub equations: StageEquations<'a>,
    /// States of all participants at the end of the stage.
    pub states: Vec<BodyState>,
    pub root: Root,
}

impl SolvedStage<'_> {
    /// Replaces the linearization by the exact derivatives of all contacts.
    pub fn linearize(&mut self) {
        self.root.linearization = self.equations.linearized(&self.states);
    }

    /// States of the dynamic bodies at the end, from a start with a derivative and from rates in
    /// time, or `None` if the matrix is singular.
    pub fn response(
        &self,
        (inertias, applied): (&[&Inertia<Change>], &[Vector6<Change>]),
        start: &StageStart<Change>,
        in_time: &RatesInTime,
    ) -> Option<Vec<BodyState<Change>>> {
        let equations = StageEquations {
            step: self.equations.step,
            inertias,
            applied,
            start: start.clone(),
            neighbors: Vec::new(),
        };
        let count = inertias.len();
        let mut velocities: Vec<_> = (0..count)
            .map(|index| {
                six_of(&self.root.velocities, index).map(|number| Change::new(number, [0.0]))
            })
            .collect();
        let states = equations.states_with(|index| velocities[index]);
        let bodies = inertias.iter().zip(&states);
        let dynamic = bodies.map(|(inertia, state)| BodyChange::carried_by(inertia, state));
        let dynamic = dynamic.map(|change| [change.displacement, change.velocities]);
        let changes: Vec<_> = dynamic.chain(in_time.neighbors.iter().copied()).collect();
        let wrenches = self.root.linearization.change(count, &changes);
        let wrenches = wrenches
            .iter()
            .zip(&in_time.forces)
            .map(|(change, in_time)| (change + in_time).map(|change| Change::new(0.0, [change])));
        let wrenches: Vec<_> = wrenches.collect();
        let residual = equations.residual(&states, &wrenches);
        let right = residual.iter().map(|six| six.map(|number| -number.eps[0]));
        let correction = self
            .root
            .linearization
            .factors
            .solve(&concatenated(right))?;
        for (index, six) in velocities.iter_mut().enumerate() {
            for (number, change) in six.iter_mut().zip(&six_of(&correction, index)) {
                number.eps[0] = *change;
            }
        }
        Some(equations.states_with(|index| velocities[index]))
    }

    /// Rates of neighbors and forces at the solution, by differences in time.
    pub fn rates_in_time(&self) -> RatesInTime {
        let StageEquations { step, start, .. } = &self.equations;
        let (context, count) = (step.context, step.inertias.len());
        let short = SHORT * start.duration;
        let [early, late] = [-short, short].map(|shift| {
            let time = start.time + shift;
            let mut states = self.states.clone();
            states[count..].copy_from_slice(&context.neighbors_at(step.island, time));
            let forces = if context.forces.is_empty() {
                vec![Vector6::zeros(); count]
            } else {
                self.equations
                    .forces(time, &states, &self.root.linearization.contacts)
            };
            (states, forces)
        });
        let rate = |early: &Vector6<f64>, late: &Vector6<f64>| (late - early) / (2.0 * short);
        let velocities = |state: &BodyState| state.twist.to_vector();
        let neighbors = (count..self.states.len()).map(|i| {
            let [early, late] = [&early.0, &late.0].map(|states| velocities(&states[i]));
            [velocities(&self.states[i]), rate(&early, &late)]
        });
        let forces = early.1.iter().zip(&late.1);
        RatesInTime {
            neighbors: neighbors.collect(),
            forces: forces.map(|(early, late)| rate(early, late)).collect(),
        }
    }

    /// Largest speed (m/s) of a dynamic body relative to the bodies that it touches. The result is
    /// at least the speed of the spin of the body.
    pub fn relative_speed(&self, index: usize) -> f64 {
        let inertia = self.equations.inertias[index];
        let center = |participant: usize| {
            let (pose, inertias) = (&self.states[participant].pose, self.equations.inertias);
            let center = inertias
                .get(participant)
                .map(|inertia| inertia.center_of_mass);
            pose.transformed_point(&center.unwrap_or_default())
        };
        let twist = &self.states[index].twist;
        let relative = |partner: usize| {
            let Twist { angular, linear } = &self.states[partner].twist;
            let carried = linear + angular.cross(&(center(index) - center(partner)));
            inertia.speed(&six(&(twist.angular - angular), &(twist.linear - carried)))
        };
        let contacts = self.root.linearization.contacts.iter();
        let partners = contacts.filter_map(|contact| match contact.bodies {
            [a, b] if a == index => Some(b),
            [a, b] if b == index => Some(a),
            _ => None,
        });
        let speeds = partners.map(relative);
        speeds.fold(
            inertia.speed(&six(&twist.angular, &Vector3::zeros())),
            f64::max,
        )
    }
}

impl RatesInTime {
    /// Zero rates for a number of neighbors and a number of dynamic bodies.
    pub fn zero(neighbors: usize, dynamic: usize) -> Self {
        Self {
            neighbors: vec![[Vector6::zeros(); 2]; neighbors],
            forces: vec![Vector6::zeros(); dynamic],
        }
    }
}

impl ChangedBodies {
    /// Bodies of an island in a step, with zero derivatives.
    pub fn new(step: &IslandStep) -> Self {
        let applied = step.context.applied.iter();
        Self {
            inertias: step
                .inertias
                .iter()
                .map(|inertia| inertia.lifted())
                .collect(),
            applied: applied.map(|six| six.map(lift)).collect(),
        }
    }
}

impl BodyChange {
    /// Rates of a body under a total wrench.
    pub fn rates(inertia: &Inertia, state: &BodyState, wrench: &Vector6<f64>) -> Self {
        let displacement = state.twist.to_vector();
        let [by_pose, _] = inertia.momentum_slopes(state);
        let impulse = wrench - by_pose * displacement;
        Self {
            displacement,
            velocities: inertia.velocities(state.pose.rotation(), &impulse),
        }
    }

    /// Derivative part of a state.
    pub fn carried_by(inertia: &Inertia<Change>, state: &BodyState<Change>) -> Self {
        let change = |number: Change| number.eps[0];
        let turn = turn_from_real(state.pose.rotation());
        let arm = state.pose.rotated_constant(&inertia.center_of_mass);
        Self {
            displacement: six(&turn, &(state.pose.translation() + arm)).map(change),
            velocities: state.twist.to_vector().map(change),
        }
    }

    /// State with this derivative part.
    pub fn applied_to(&self, inertia: &Inertia<Change>, state: &BodyState) -> BodyState<Change> {
        let lifted = state.lifted::<Change>();
        let change = |number: f64| Change::new(0.0, [number]);
        BodyState {
            pose: inertia.displaced(&lifted.pose, &self.displacement.map(change)),
            twist: Twist::from_vector(&(lifted.twist.to_vector() + self.velocities.map(change))),
        }
    }
}
