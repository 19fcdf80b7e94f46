use crate::dynamics::any_world::AnyWorld;
use crate::dynamics::implicit::Trace;
use crate::dynamics::integrator::Kind;
use crate::dynamics::steps::{Checkpoint, Steps};
use crate::dynamics::{BodyState, Plan, RolloutError, State};
use std::cmp;

/// Steps of up to so many bytes are all kept; halved ones take more, and are not counted twice.
const ROOM: usize = 256 << 20;

/// The steps of a rollout, to be read from the last to the first. All of them are kept, or one checkpoint in √l of l, from which
/// the steps to the next one are taken again, with the same bits.
pub(crate) struct Tape<'w> {
    world: &'w dyn AnyWorld<f64>,
    plan: &'w Plan,
    /// Steps from one checkpoint to the next.
    stride: usize,
    checkpoints: Vec<Checkpoint>,
    /// The steps since the last checkpoint.
    stretch: Vec<StepTaken>,
}

/// A step that was taken.
#[derive(Debug)]
pub(crate) struct StepTaken {
    /// The state from which it went on.
    pub before: State,
    /// The ways of the islands, if it is implicit.
    pub(super) traces: Vec<Trace>,
}

impl<'w> Tape<'w> {
    /// Of no steps yet.
    pub fn new(world: &'w dyn AnyWorld<f64>, plan: &'w Plan) -> Self {
        let steps = plan.steps();
        let of_body = match plan.integrator().kind() {
            Kind::Explicit(_) => 0,
            Kind::Implicit(scheme) => Trace::least_size(scheme),
        };
        let of_step = (size_of::<BodyState>() + of_body) * world.system().bodies.len();
        let fits = steps.saturating_mul(of_step) <= ROOM;
        Self {
            world,
            plan,
            stride: if fits { steps } else { steps.isqrt() }.max(1),
            checkpoints: Vec::new(),
            stretch: Vec::new(),
        }
    }

    /// Takes down so many steps that were taken; to be called before the first and after each of them.
    pub fn keep(&mut self, taken: usize, steps: &Steps<f64>) {
        self.finish(steps);
        if taken == self.plan.steps() {
            return;
        }
        if taken.is_multiple_of(self.stride) {
            self.checkpoints.push(steps.checkpoint());
            self.stretch.clear();
        }
        self.begin(steps);
    }

    fn begin(&mut self, steps: &Steps<f64>) {
        self.stretch.push(StepTaken {
            before: steps.state.clone(),
            traces: Vec::new(),
        });
    }

    fn finish(&mut self, steps: &Steps<f64>) {
        if let Some(last) = self.stretch.last_mut() {
            last.traces = steps.traces().to_vec();
        }
    }

    /// The step after so many, of which those after later ones are not asked for again.
    pub fn back_to(&mut self, taken: usize) -> Result<&StepTaken, RolloutError> {
        let (place, further) = (taken / self.stride, taken % self.stride);
        if place + 1 < self.checkpoints.len() {
            self.checkpoints.truncate(place + 1);
            self.take_again(place)?;
        }
        self.stretch.truncate(further + 1);
        Ok(&self.stretch[further])
    }

    /// Takes the steps from a checkpoint to the next.
    fn take_again(&mut self, place: usize) -> Result<(), RolloutError> {
        let first = place * self.stride;
        let count = cmp::min(self.stride, self.plan.steps() - first);
        let mut steps = Steps::resumed(&self.checkpoints[place], self.world, first);
        self.stretch.clear();
        for _ in 0..count {
            self.begin(&steps);
            steps.advance(self.world, self.plan)?;
            self.finish(&steps);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{HalfSpace, Shape};
    use crate::dynamics::{Body, Integrator, Mass, Material, World};
    use crate::mesh::shapes;
    use crate::spatial::Pose;
    use nalgebra::vector;

    /// A brick that falls on a corner and slides.
    fn world() -> World {
        let skin = Material::elastic(1e6)
            .with_friction(0.3)
            .with_dissipation(0.2);
        let brick = Shape::new(shapes::cuboid([0.2, 0.15, 0.1]).unwrap());
        let start = Pose::from_rotation_vector(&vector![0.2, 0.1, 0.3], vector![0.0, 0.0, 0.1]);
        let brick = Body::dynamic("brick", brick, skin, Mass::Total(1.0)).unwrap();
        let floor = Body::fixed("floor", HalfSpace::rigid(), Material::rigid()).unwrap();
        let bodies = vec![
            brick.at(start).with_velocity(vector![0.7, 0.1, -1.0]),
            floor,
        ];
        let world = World::new(bodies).unwrap();
        world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
    }

    /// All steps, the last first, as they are written down to the last bit.
    fn read(world: &World, plan: &Plan, stride: usize) -> Vec<String> {
        let mut tape = Tape {
            stride,
            ..Tape::new(world, plan)
        };
        let mut steps = Steps::from(world.initial_state());
        tape.keep(0, &steps);
        for taken in 1..=plan.steps() {
            steps.advance(world, plan).unwrap();
            tape.keep(taken, &steps);
        }
        let places = (0..plan.steps()).rev();
        places
            .map(|taken| format!("{:?}", tape.back_to(taken).unwrap()))
            .collect()
    }

    #[test]
    fn steps_between_checkpoints_are_taken_again_with_the_same_bits() {
        for (integrator, time_step) in [
            (Integrator::Leapfrog, 1e-3),
            (Integrator::Sdirk2, 5e-3),
            (Integrator::ImplicitEuler, 5e-3),
        ] {
            let plan = Plan::new(time_step, 40).unwrap();
            let plan = plan.with_integrator(integrator);
            let all = read(&world(), &plan, 40);
            for stride in [1, 6, 7, 39] {
                assert!(read(&world(), &plan, stride) == all);
            }
        }
    }
}
