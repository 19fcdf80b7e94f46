//! Detection of bodies that might pass through each other in a substep, between two evaluations of their contacts.

use super::island_solver::IslandSolver;
use super::solved_stage::SolvedStage;
use crate::dynamics::BodyState;
use crate::dynamics::sweep::Sweep;
use crate::geometry::Aabb;
use crate::scalar::portable::sin_cos;
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;
use std::iter::once;

/// Participant in a state, with the center and the radius of its motion.
struct MovingBody {
    /// Center of mass, or the origin of a body without inertia.
    center: Vector3<f64>,
    state: BodyState,
    /// Largest distance (m) of points of the body from the center.
    radius: f64,
}

impl IslandSolver<'_> {
    /// States of all participants at the start of a substep.
    fn participants_at(&self, offset: f64) -> Vec<BodyState> {
        let step = self.step;
        let neighbors = step.context.neighbors_at(step.island, step.start + offset);
        let bodies = &self.solved.progress.kinematics.states[..step.island.dynamic.len()];
        bodies.iter().copied().chain(neighbors).collect()
    }

    /// Largest motion of two bodies relative to each other in a substep, divided by the sum of
    /// their thicknesses. It is 0 if the ratio is at most 1, or if no two bodies may hit each
    /// other. Bodies that touch at the start are omitted if the errors are within the tolerances,
    /// because error control then resolves their contact.
    pub fn tunneling_ratio(
        &self,
        (offset, duration): (f64, f64),
        stages: &[SolvedStage],
        swept: &[Aabb],
        follows_contacts: bool,
    ) -> f64 {
        let from = &*self.participants_at(offset);
        let (context, island) = (self.step.context, self.step.island);
        let samples: Vec<_> = once(from)
            .chain(stages.iter().map(|stage| &*stage.end.states))
            .collect();
        let mut sweep = Sweep::default();
        let boxes = swept.iter().enumerate().map(|(participant, stages)| {
            let start = context.bounds(island.body(participant), &from[participant].pose);
            let margin = self.arc_height(participant, &samples, duration);
            stages.union(&start).inflated(margin)
        });
        let pairs = context.overlapping(island, boxes, &mut sweep);
        let ratio = |&(i, j): &(usize, usize)| {
            let [a, b] = [i, j].map(|participant| context.thickness(island.body(participant)));
            self.relative_motion([i, j], &samples, duration) / (a + b)
        };
        let is_touching = |&(i, j): &(usize, usize)| {
            let pair = context.pair(island, [i, j], from);
            pair.is_some_and(|pair| pair.frozen().is_some())
        };
        let pairs = pairs.iter().map(|pair| (pair, ratio(pair)));
        let is_omitted = |pair| follows_contacts && is_touching(pair);
        let far = pairs.filter(|(pair, ratio)| *ratio > 1.0 && !is_omitted(pair));
        far.map(|(_, ratio)| ratio).fold(0.0, f64::max)
    }

    /// Distance (m) by which a spinning participant may leave its boxes between two successive samples.
    fn arc_height(&self, participant: usize, samples: &[&[BodyState]], duration: f64) -> f64 {
        let spins = samples
            .iter()
            .map(|states| states[participant].twist.angular.norm());
        let spin = spins.fold(0.0, f64::max);
        // A half-space has no radius, and does not spin.
        if spin <= 0.0 {
            return 0.0;
        }
        // Successive samples are less than half a substep apart. An arc rises above its chord by r (1 − cos φ), where φ is half the angle
        // of the arc.
        let half_angle = (spin * duration / 4.0).min(FRAC_PI_2);
        let (sine, _) = sin_cos(half_angle / 2.0);
        let radius = self.moving(participant, samples[0]).radius;
        2.0 * radius * sine * sine
    }

    /// Upper bound of the motion (m) of two participants relative to each other in a substep, from their speeds and positions at all
    /// samples.
    fn relative_motion(&self, pair: [usize; 2], samples: &[&[BodyState]], duration: f64) -> f64 {
        let moving =
            |states: &[BodyState]| pair.map(|participant| self.moving(participant, states));
        let samples: Vec<_> = samples.iter().map(|states| moving(states)).collect();
        let speeds = samples
            .iter()
            .map(|[a, b]| a.speed_beside(b).min(b.speed_beside(a)));
        let apart = |[a, b]: &[MovingBody; 2]| a.center - b.center;
        let distances = samples
            .windows(2)
            .map(|two| (apart(&two[1]) - apart(&two[0])).norm());
        (duration * speeds.fold(0.0, f64::max)).max(distances.sum())
    }

    fn moving(&self, participant: usize, states: &[BodyState]) -> MovingBody {
        let body = self.step.island.body(participant);
        let link = self.step.multibody.links.get(participant);
        let center = link.map(|link| link.inertia.center_of_mass);
        let center = center.unwrap_or_default();
        let bounds = self.step.context.bounds(body, &Pose::identity());
        let state = states[participant];
        MovingBody {
            center: state.pose.transformed_point(&center),
            state,
            radius: (bounds.center() - center).norm() + bounds.half_extents().norm(),
        }
    }
}

impl MovingBody {
    /// Upper bound of the speed (m/s) of points of the body relative to another body.
    fn speed_beside(&self, other: &Self) -> f64 {
        let (twist, other_twist) = (&self.state.twist, &other.state.twist);
        let frame = other_twist.linear + other_twist.angular.cross(&(self.center - other.center));
        let spin = (twist.angular - other_twist.angular).norm();
        // A half-space has no radius, and does not spin.
        let turning = if spin > 0.0 { spin * self.radius } else { 0.0 };
        (twist.linear - frame).norm() + turning
    }
}
