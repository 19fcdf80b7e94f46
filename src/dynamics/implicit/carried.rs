//! A step once more in a scalar that carries derivatives, along the stages that were solved in `f64`.
//!
//! At the real solution u₀ of a stage, u = u₀ − J⁻¹·(r(u) − re r(u)) makes the residual r vanish to one order more each time,
//! with the real matrix J: by the implicit function theorem the first of them gives all first derivatives, and all
//! parameters share one factorisation.

use super::carried_stage::Carried;
use super::island::Island;
use super::scheme::Scheme;
use super::steps::{Part, Way};
use super::{Scene, Stuck};
use crate::dynamics::BodyState;
use crate::dynamics::any_world::AnyWorld;
use crate::scalar::Scalar;
use nalgebra::Vector6;

/// An island to be carried through a step.
pub(super) struct Carrier<'a, T> {
    pub world: &'a dyn AnyWorld<T>,
    pub scene: &'a Scene<'a>,
    pub island: &'a Island,
    pub scheme: &'a Scheme,
    /// Time at the start of the step (s).
    pub start: f64,
    /// Weight and control of each body of the world.
    pub given: &'a [Vector6<T>],
}

impl<T: Scalar> Carrier<'_, T> {
    /// Takes all bodies' states through the island's way.
    pub fn through(&self, way: &Way, states: &mut [BodyState<T>]) -> Result<(), Stuck> {
        way.parts
            .iter()
            .try_for_each(|part| self.part(part, states))
    }

    fn part(&self, part: &Part, states: &mut [BodyState<T>]) -> Result<(), Stuck> {
        if self.scene.is_stopped() {
            return Err(Stuck::Stopped);
        }
        let system = self.world.system();
        let inertias: Vec<_> = self
            .island
            .dynamic
            .iter()
            .filter_map(|&body| system.bodies[body].inertia())
            .collect();
        let own: Vec<_> = self
            .island
            .dynamic
            .iter()
            .map(|&body| states[body])
            .collect();
        let bodies = || inertias.iter().zip(&own);
        let momenta: Vec<_> = bodies()
            .map(|(inertia, state)| inertia.momentum(state))
            .collect();
        let mut rates: Vec<[Vec<Vector6<T>>; 2]> = Vec::new();
        for (stage, root) in self.scheme.stages(part.duration).zip(&part.stages) {
            let accumulated = |kind: usize, place: usize| {
                let before: Vec<_> = rates.iter().map(|rates| rates[kind][place]).collect();
                stage.accumulated(&before)
            };
            let poses = bodies().enumerate();
            let poses = poses.map(|(place, (inertia, state))| {
                inertia.displaced(&state.pose, &accumulated(0, place))
            });
            let start = momenta.iter().enumerate();
            let start = start.map(|(place, momentum)| momentum + accumulated(1, place));
            let carried = Carried {
                of: self,
                inertias: inertias.clone(),
                poses: poses.collect(),
                momenta: start.collect(),
                duration: stage.duration,
                time: Part::time(self.start, part.offset, &stage),
            };
            let velocities = carried.solved(root, states)?;
            rates.push(carried.rates(velocities, states, stage));
        }
        Ok(())
    }
}
