//! Bodies that might pass through each other in a substep, between two looks at their contacts.

use super::advance::IslandSolver;
use super::solved_stage::SolvedStage;
use crate::dynamics::BodyState;
use crate::dynamics::sweep::Sweep;
use crate::geometry::Aabb;
use crate::spatial::Pose;

impl IslandSolver<'_> {
    /// The states of all participants at the start of a substep.
    pub fn participants_at(&self, offset: f64) -> Vec<BodyState> {
        let step = self.step;
        let neighbors = step.scene.neighbors_at(step.island, step.start + offset);
        let bodies = self.solved.bodies.iter().map(|body| body.state);
        bodies.chain(neighbors).collect()
    }

    /// The largest motion of two bodies relative to each other in a substep, over the sum of their thicknesses; 0 if no two bodies may
    /// hit each other. Bodies that touch at the start are left out, because their contact acts in all stages.
    pub fn tunneling(
        &self,
        from: &[BodyState],
        stages: &[SolvedStage],
        swept: &[Aabb],
        duration: f64,
    ) -> f64 {
        let (scene, island) = (self.step.scene, self.step.island);
        let mut sweep = Sweep::default();
        let pairs = scene.overlapping(island, swept.iter().copied(), &mut sweep);
        let motion = |&(i, j): &(usize, usize)| {
            let thickness = [i, j].map(|participant| scene.thickness(island.body(participant)));
            let states = stages.iter().map(|stage| &*stage.states).chain([from]);
            let speed = states.map(|states| self.relative_speed([i, j], states));
            speed.fold(0.0, f64::max) * duration / (thickness[0] + thickness[1])
        };
        let touch = |&(i, j): &(usize, usize)| {
            let pair = scene.pair(island, [i, j], from);
            pair.is_some_and(|pair| pair.frozen().is_some())
        };
        let pairs = pairs.iter().map(|pair| (pair, motion(pair)));
        let far = pairs.filter(|(pair, motion)| *motion > 1.0 && !touch(pair));
        far.map(|(_, motion)| motion).fold(0.0, f64::max)
    }

    /// Bound of the speed (m/s) of the points that two participants may have in common: that of either body in the axes of the other.
    fn relative_speed(&self, pair: [usize; 2], states: &[BodyState]) -> f64 {
        let [a, b] = pair.map(|participant| {
            let body = self.step.island.body(participant);
            let (pose, inertia) = (
                &states[participant].pose,
                self.step.inertias.get(participant),
            );
            let center = inertia
                .map(|inertia| inertia.center_of_mass)
                .unwrap_or_default();
            let own = self.step.scene.bounds(body, &Pose::identity());
            let radius = (own.center() - center).norm() + own.half_extents().norm();
            (
                pose.transformed_point(&center),
                &states[participant].twist,
                radius,
            )
        });
        let spin = (a.1.angular - b.1.angular).norm();
        let bounds = [(a, b), (b, a)].map(|((center, twist, radius), (about, frame, _))| {
            let carried = frame.linear + frame.angular.cross(&(center - about));
            (twist.linear - carried).norm() + if spin > 0.0 { spin * radius } else { 0.0 }
        });
        bounds[0].min(bounds[1])
    }
}
