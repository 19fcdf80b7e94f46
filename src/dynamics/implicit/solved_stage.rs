//! Solved stage and its first-order response to a change of its start.

use super::newton::Root;
use super::rates::{Change, ChangedBodies, RatesInTime, SHORT};
use super::stage::{StageEquations, StageStart};
use crate::dynamics::multibody::Kinematics;
use crate::dynamics::rigid_motion::six;
use crate::spatial::Twist;
use nalgebra::Vector3;

/// Stage with its solution.
pub(super) struct SolvedStage<'a> {
    pub equations: StageEquations<'a>,
    pub end: Kinematics,
    pub root: Root,
}

impl SolvedStage<'_> {
    /// Replaces the linearization by the exact derivatives of all contacts.
    pub fn linearize(&mut self) {
        self.root.linearization = self.equations.linearized(&self.end);
    }

    /// End of the stage, from a start with a derivative and from rates in time; `None` if the matrix is singular.
    pub fn response(
        &self,
        bodies: &ChangedBodies,
        start: &StageStart<Change>,
        in_time: &RatesInTime,
    ) -> Option<Kinematics<Change>> {
        let count = self.equations.multibody.links.len();
        let neighbors = self.end.states[count..].iter().zip(&in_time.neighbors);
        let equations = StageEquations {
            step: self.equations.step,
            multibody: &bodies.multibody,
            applied: &bodies.applied,
            start: start.clone(),
            neighbors: neighbors
                .map(|(state, change)| change.applied_to(state))
                .collect(),
        };
        let mut unknowns = self.root.unknowns.map(|number| Change::new(number, [0.0]));
        let end = equations.end(unknowns.clone());
        let changes: Vec<_> = bodies
            .changes(&end)
            .chain(in_time.neighbors.iter().copied())
            .collect();
        let linearization = &self.root.linearization;
        let wrenches = linearization.change(count, &changes);
        let wrenches = wrenches
            .iter()
            .zip(&in_time.forces)
            .zip(&linearization.wrenches);
        let wrenches = wrenches.map(|((change, in_time), wrench)| {
            wrench.zip_map(&(change + in_time), |number, change| {
                Change::new(number, [change])
            })
        });
        let residual = equations.residual(&end, &wrenches.collect::<Vec<_>>());
        let mut right = residual.map(|number| -number.eps[0]);
        let mut impulses = right.rows_mut(0, in_time.joint_forces.len());
        impulses += &in_time.joint_forces * start.duration;
        let correction = linearization.factors.solve(right)?;
        for (number, change) in unknowns.iter_mut().zip(&correction) {
            number.eps[0] = *change;
        }
        Some(equations.end(unknowns))
    }

    /// Rates of neighbors and forces at the solution, by differences in time.
    pub fn rates_in_time(&self) -> RatesInTime {
        let StageEquations { step, start, .. } = &self.equations;
        let (context, count) = (step.context, step.multibody.links.len());
        let short = SHORT * start.duration;
        let [early, late] = [-short, short].map(|shift| {
            let coordinates = &self.end.coordinates;
            self.equations
                .multibody
                .joint_forces(coordinates, start.time + shift)
        });
        let rates = RatesInTime {
            neighbors: step.neighbor_rates(start.time, start.duration),
            joint_forces: (late - early) / (2.0 * short),
            ..RatesInTime::zero(self.equations.multibody)
        };
        if context.forces.is_empty() {
            return rates;
        }
        let [early, late] = [-short, short].map(|shift| {
            let time = start.time + shift;
            let mut states = self.end.states.clone();
            states[count..].copy_from_slice(&context.neighbors_at(step.island, time));
            let contacts = &self.root.linearization.contacts;
            self.equations.forces(time, &states, contacts)
        });
        let forces = early.iter().zip(&late);
        let forces = forces.map(|(early, late)| (late - early) / (2.0 * short));
        RatesInTime {
            forces: forces.collect(),
            ..rates
        }
    }

    /// Largest speed (m/s) of a dynamic body relative to the bodies that it touches. The result is
    /// at least the speed of the spin of the body.
    pub fn relative_speed(&self, index: usize) -> f64 {
        let links = &self.equations.multibody.links;
        let inertia = &links[index].inertia;
        let center = |participant: usize| {
            let pose = &self.end.states[participant].pose;
            let center = links
                .get(participant)
                .map(|link| link.inertia.center_of_mass);
            pose.transformed_point(&center.unwrap_or_default())
        };
        let twist = &self.end.states[index].twist;
        let relative = |partner: usize| {
            let Twist { angular, linear } = &self.end.states[partner].twist;
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
